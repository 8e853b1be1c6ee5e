//! The settings of the contact solver: the `solver` section of a model file.

/// Which form of Coulomb's law a step satisfies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// The convex form of the paper: a sliding contact separates at `μ |v_t|`.
    #[default]
    Relaxed,
    /// Coulomb's law itself, by an outer fixed point on `μ |v_t|`.
    Exact,
}

/// The iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The paper's Algorithm 1.
    Jacobi,
    /// Block after block, coloured.
    GaussSeidel,
    /// Accelerated projected gradient descent with adaptive restart.
    Apgd,
    /// Spectral projected gradients.
    BarzilaiBorwein,
}

impl Method {
    /// All methods.
    pub const ALL: [Method; 4] = [Method::Jacobi, Method::GaussSeidel, Method::Apgd, Method::BarzilaiBorwein];

    /// The name, as model files write it.
    pub fn name(self) -> &'static str {
        match self {
            Method::Jacobi => "jacobi",
            Method::GaussSeidel => "gauss_seidel",
            Method::Apgd => "apgd",
            Method::BarzilaiBorwein => "barzilai_borwein",
        }
    }
}

/// How contacts are solved; also the `solver` section of a model file.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// `apgd`, `barzilai_borwein`, `gauss_seidel` or `jacobi`.
    pub method: Method,
    /// The law of friction: `relaxed` (the paper's convex form) or `exact`.
    pub friction: FrictionLaw,
    /// The most iterations a step; if not given 50, and more where contacts are few: up to 50,000 over their number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<u32>,
    /// Stop when the residual (as in `report.csv`) is below this, m/s; 0 does all iterations.
    pub tolerance: f64,
    /// Relaxation ω of Jacobi and Gauss–Seidel; 0.3 and 1 if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<f64>,
    /// Jacobi's smoothing λ.
    pub lambda: f64,
    /// Whether impulses of the last step are the starting point.
    pub warm_start: bool,
    /// Greatest speed at which an overlap is pushed apart, m/s.
    pub recovery_speed: f64,
    /// Contacts are made at gaps up to this, and farther for fast bodies, m; a fiftieth of the least moving shape if not given.
    pub envelope: Option<f64>,
}

impl Default for SolverSettings {
    fn default() -> SolverSettings {
        SolverSettings {
            method: Method::Apgd,
            friction: FrictionLaw::Relaxed,
            iterations: None,
            tolerance: 1e-7,
            omega: None,
            lambda: 1.0,
            warm_start: true,
            recovery_speed: 1.0,
            envelope: None,
        }
    }
}

impl SolverSettings {
    /// The most iterations for so many blocks.
    pub fn max_iterations(&self, n_blocks: usize) -> u32 {
        self.iterations.unwrap_or((50_000 / n_blocks.max(1)).max(50) as u32)
    }
}
