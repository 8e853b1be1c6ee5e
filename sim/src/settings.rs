//! Settings of the contact solver: the `solver` section of a model file.

/// The law of friction: the form of Coulomb's law that a step satisfies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// The convex relaxation of Negrut et al. 2012: a contact that slides at the speed `|v_t|` separates at `μ |v_t|`.
    #[default]
    Relaxed,
    /// Coulomb's law without relaxation: contact by contact in Gauss–Seidel sweeps, else by a fixed point on the slip
    /// feedback `μ |v_t|` (Cadoux 2009; Acary et al. 2011).
    Exact,
}

/// A level of quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// To see what happens: overlaps of some hundredths of the bodies' sizes, piles that settle for long.
    Draft,
    /// For films and most numbers: overlaps of some thousandths, piles that rest.
    Normal,
    /// For forces: overlaps below a ten thousandth.
    Tight,
}

impl Quality {
    /// Name, as in model files.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Normal => "normal",
            Quality::Tight => "tight",
        }
    }
}

/// The method that solves the contact problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Projected Jacobi (Negrut et al. 2012, Algorithm 1).
    Jacobi,
    /// Projected Gauss–Seidel on coloured blocks.
    GaussSeidel,
    /// Accelerated projected gradient descent with adaptive restart (Mazhar, Heyn, Negrut, Tasora 2015).
    Apgd,
    /// Spectral projected gradients with Barzilai–Borwein step lengths (Birgin, Martínez, Raydan 2000).
    BarzilaiBorwein,
}

impl Method {
    /// All methods.
    pub const ALL: [Method; 4] = [Method::Jacobi, Method::GaussSeidel, Method::Apgd, Method::BarzilaiBorwein];

    /// Name, as in model files.
    pub fn name(self) -> &'static str {
        match self {
            Method::Jacobi => "jacobi",
            Method::GaussSeidel => "gauss_seidel",
            Method::Apgd => "apgd",
            Method::BarzilaiBorwein => "barzilai_borwein",
        }
    }
}

/// How the impacts of a step act.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Impacts {
    /// All at once, with the contacts.
    #[default]
    Simultaneous,
    /// One after another, the fastest first, until none closes.
    Sequential,
}

/// Settings of the contact solver: the `solver` section of a model file.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// Method: `apgd`, `barzilai_borwein`, `gauss_seidel` or `jacobi`; if not given, `gauss_seidel` for beds of spheres, else `apgd`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// Law of friction: `relaxed` (the convex form) or `exact` (Coulomb's law).
    pub friction: FrictionLaw,
    /// How several impacts act: `simultaneous` or `sequential`, one after another, as in a cradle of spheres that touch.
    pub impacts: Impacts,
    /// Maximum number of iterations per step; if not given, 50,000 divided by the number of contacts, and at least 50.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<u32>,
    /// Overlap that a step may add at a contact, m: sweeps of Gauss–Seidel go on beyond `iterations`, up to four times as many, while they
    /// leave more, as where something lands; if not given, they do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap_tolerance: Option<f64>,
    /// Residual of the contacts of slow bodies of any shape, in the root mean square over a tile of them, m/s: sweeps of Gauss–Seidel over it go on beyond
    /// `iterations`, up to four times as many, while it is greater, and on the processor islands of them that still have a tenth of it are then solved as a whole, so that what stands comes to rest; if not given, they do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settling_tolerance: Option<f64>,
    /// Maximum number of iterations, of `apgd`, of a step in which no contact has an impulse to start from, as the first one of a model
    /// whose bodies stand on each other; if not given, `iterations`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_iterations: Option<u32>,
    /// Whether Gauss–Seidel takes over from another method the steps of a heap that begin far from their solution and have more contacts
    /// than iterations, as while it lands.
    pub sweep_landings: bool,
    /// Residual (as in `report.csv`) below which the iteration stops, m/s, that of `jacobi` with exact friction below a tenth of it; with 0 all
    /// iterations are done.
    pub tolerance: f64,
    /// Relaxation factor ω of Jacobi and Gauss–Seidel; if not given, 0.3 for Jacobi and 1 for Gauss–Seidel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<f64>,
    /// Smoothing factor λ of Jacobi.
    pub lambda: f64,
    /// Whether the iteration starts from the impulses of the last step.
    pub warm_start: bool,
    /// Maximum speed at which overlapping bodies are pushed apart, m/s.
    pub recovery_speed: f64,
    /// Gap at which bodies other than spheres come to rest on each other, m: what a solve leaves of closing gaps this small would rock a
    /// pile.
    pub rest_gap: f64,
    /// Speed below which what moves keeps only the share of its velocity in each step that it is of this, m/s: what a cut-off solve leaves of
    /// the slow modes of a high wall, which gravity makes grow, then dies away.
    pub rest_speed: f64,
    /// Maximum gap at which contacts are generated, m, to which the motion of a body in a step is added; if not given, a fiftieth of the
    /// smallest half length of a moving shape.
    pub envelope: Option<f64>,
    /// Relative motion of two shapes up to which their contact points are carried along with them rather than found again, m; if not
    /// given, a thousandth of the envelope.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recycle: Option<f64>,
    /// Speed below which bodies that hang together fall asleep after half a second, m/s: they stay where they are until something touches or
    /// drives them; if not given, none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sleep: Option<f64>,
}

impl Default for SolverSettings {
    fn default() -> SolverSettings {
        SolverSettings {
            method: None,
            friction: FrictionLaw::Relaxed,
            impacts: Impacts::Simultaneous,
            iterations: None,
            overlap_tolerance: None,
            settling_tolerance: None,
            start_iterations: None,
            sweep_landings: true,
            tolerance: 1e-7,
            omega: None,
            lambda: 1.0,
            warm_start: true,
            recovery_speed: 1.0,
            rest_gap: 0.0,
            rest_speed: 0.0,
            envelope: None,
            recycle: None,
            sleep: None,
        }
    }
}

impl SolverSettings {
    /// The most sweeps over all contacts, over the maximum number of iterations, where gaps are not to close too fast.
    pub const BEYOND: u32 = 4;

    /// The speed up to which bodies are slow, over that of a step of free fall.
    pub const SLOW: f64 = 6.0;

    /// The residual above which a step counts as not converged, m/s: 100 tolerances, and at least gravity times step size, `fall`.
    pub fn residual_bound(&self, fall: f64) -> f64 {
        let tolerance = if self.tolerance > 0.0 { self.tolerance } else { 1e-7 };
        (100.0 * tolerance).max(fall)
    }

    /// The settings of sweeps that take a step over: they go on where they leave more than half an `envelope`, m, of overlap.
    pub fn of_takeover(&self, envelope: f64) -> SolverSettings {
        let overlap = self.overlap_tolerance.or(Some(0.5 * envelope));
        SolverSettings { omega: None, overlap_tolerance: overlap, ..self.clone() }
    }

    /// Maximum number of iterations of a problem with `n_blocks` blocks of three multipliers: `iterations`, or its default.
    pub fn max_iterations(&self, n_blocks: usize) -> u32 {
        self.iterations.unwrap_or((50_000 / n_blocks.max(1)).max(50) as u32)
    }
}
