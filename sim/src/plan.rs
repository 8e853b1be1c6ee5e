//! The step plan: layout and method, which follow from the model and hold for many steps. It is resolved again only when a body
//! appears or begins to move, or the solver's settings change.

use crate::heap::{are_spheres_but, is_bed, is_heap, loads};
use crate::model::Model;
use crate::settings::{FrictionLaw, Impacts, Method, SolverSettings};
use crate::state::State;
use crate::watch::residual_bound;

use crate::inertia::is_isotropic;
use crate::shape::ShapeKind;

/// The narrow phase, and the layout of the contact rows that goes with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Narrow {
    /// For models in which all moving shapes are spheres about their bodies' centres of mass with isotropic inertia: spheres have a
    /// column of their own, pairs of spheres are tested four at a time, and a contact's arms are lengths along its normal.
    Spheres,
    /// For any shapes: pairs are tested one by one, and a contact's arms are vectors.
    #[default]
    Any,
}

impl Narrow {
    /// The narrow phase of a model, for the current activity of its bodies.
    pub fn of(model: &Model, state: &State) -> Narrow {
        if has_spheres_only(model, state) { Narrow::Spheres } else { Narrow::Any }
    }
}

/// The method of a step's contact solve: sweeps for spheres alone, or a [`Method`] on general blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMethod {
    /// Gauss–Seidel sweeps on packed contacts, which solve either law of friction contact by contact.
    Sweeps,
    /// A method on blocks of three multipliers, for any shapes and contact laws.
    Blocks(Method),
}

/// The plan of a step: the layout of its columns and its method, which follow from the model and hold for many steps. It is resolved
/// again when the activity of a body or the solver's settings change.
#[derive(Clone, Debug)]
pub struct StepPlan {
    /// The narrow phase and the layout of the contact rows.
    pub narrow: Narrow,
    /// The method of a step with contacts; [`StepPlan::method_with`] has that of other steps.
    pub method: ContactMethod,
    /// Whether a contact law has rolling or spinning friction, so that contacts have rolling impulses.
    pub rolls: bool,
    /// Whether a contact law has cohesion.
    pub coheres: bool,
    /// Whether a contact law has restitution, and impacts are solved with the contacts.
    pub bounces: bool,
    /// Whether a contact law has restitution, and impacts act one after another before the contacts are solved.
    pub has_sequential_impacts: bool,
    /// Whether the velocities without contacts and joints are a column; else each reader evaluates them, which happens twice a step.
    pub has_free_column: bool,
    /// Whether the solve starts from the last step's impulses.
    pub warm_starts: bool,
    /// The root mean square of the starting point's residual terms, m/s, above which sweeps take over a step with more contacts than iterations,
    /// as one in which a bed lands; none where they take over no step, negative where they take over each, as of grains under a load.
    pub takeover: Option<f64>,
    /// The settings of a step with contacts none of which has an impulse to start from, where they differ.
    start: Option<SolverSettings>,
    /// The settings that the plan was resolved from.
    settings: SolverSettings,
}

impl StepPlan {
    /// Resolve the plan of a model, for the current activity of its bodies.
    pub fn resolve(model: &Model, state: &State) -> StepPlan {
        /// What errors of a load that swings on bodies of any shapes may be, over those of a heap that lands.
        const SWINGS: f64 = 3.0;
        let settings = &model.solver;
        let (rolls, coheres) = (rolls(model), coheres(model));
        let narrow = Narrow::of(model, state);
        let has_spheres = narrow == Narrow::Spheres;
        let sweeps = match settings.method {
            Some(method) => method == Method::GaussSeidel,
            None => has_spheres && is_bed(model, state),
        };
        let method = if sweeps { ContactMethod::Sweeps } else { blocks(settings) };
        let bounces = model.laws.iter().any(|l| l.restitution > 0.0);
        let has_sequential_impacts = bounces && settings.impacts == Impacts::Sequential;
        let can_take_over = settings.sweep_landings && !sweeps && is_heap(model, state);
        let takeover = match &loads(model, state)[..] {
            [] => landing_bound(model, settings),
            loads if are_spheres_but(loads, model, state) => -1.0,
            // Sweeps over the manifolds of other shapes do not bring a load to rest.
            _ => SWINGS * landing_bound(model, settings),
        };
        let has_forces = !model.loads.is_empty() || has_joints(model);
        let start = settings.start_iterations.filter(|_| settings.warm_start).map(|iterations| SolverSettings {
            method: Some(Method::Apgd),
            iterations: Some(iterations),
            omega: None,
            ..settings.clone()
        });
        StepPlan {
            narrow,
            method,
            rolls,
            coheres,
            bounces: bounces && !has_sequential_impacts,
            has_sequential_impacts,
            has_free_column: has_forces || has_sequential_impacts || start.is_some() || !(sweeps && has_spheres),
            warm_starts: settings.warm_start,
            takeover: can_take_over.then_some(takeover),
            start,
            settings: settings.clone(),
        }
    }

    /// Whether the plan was resolved from the solver settings that the model has now.
    pub fn is_current(&self, model: &Model) -> bool {
        self.settings == model.solver
    }

    /// The method and the settings of a step in which no contact has an impulse to start from; none where they are those of other steps.
    pub fn start(&self) -> Option<(ContactMethod, &SolverSettings)> {
        self.start.as_ref().map(|settings| (blocks(settings), settings))
    }

    /// The method of a step with `n_contacts` contacts, without which there is nothing to sweep over.
    pub fn method_with(&self, n_contacts: usize) -> ContactMethod {
        if n_contacts > 0 { self.method } else { blocks(&self.settings) }
    }

    /// Whether contacts roll with friction or stick.
    pub fn resists(&self) -> bool {
        self.rolls || self.coheres
    }

    /// Whether `method` reaches exact friction by adding the slip feedback μ |v_t| to the gaps' rates, rather than contact by contact.
    pub fn has_slip_feedback(&self, method: ContactMethod) -> bool {
        self.settings.friction == FrictionLaw::Exact && method != ContactMethod::Sweeps
    }
}

/// The method on blocks of three multipliers: that of the settings, else APGD, which measures best on stacks, machines and great ratios of
/// masses.
fn blocks(settings: &SolverSettings) -> ContactMethod {
    ContactMethod::Blocks(settings.method.unwrap_or(Method::Apgd))
}

/// Whether a contact law of a model has rolling or spinning friction.
pub fn rolls(model: &Model) -> bool {
    model.laws.iter().any(|l| l.rolling > 0.0 || l.spinning > 0.0)
}

/// Whether joints or springs connect bodies of a model.
pub fn has_joints(model: &Model) -> bool {
    !(model.joints.is_empty() && model.springs.is_empty())
}

/// Whether a contact law of a model has cohesion.
pub fn coheres(model: &Model) -> bool {
    model.laws.iter().any(|l| l.cohesion != 0.0)
}

/// Whether the contact laws of a model know friction and restitution alone.
pub fn has_friction_alone(model: &Model) -> bool {
    !rolls(model) && !coheres(model)
}

/// The root mean square of residual terms from which on the starting point of a step of a bed is far from its solution, m/s: more than a step of
/// free fall changes speeds; of exact Jacobi, which rests from a tenth of what the others do, a tenth.
fn landing_bound(model: &Model, settings: &SolverSettings) -> f64 {
    let is_slow = settings.method == Some(Method::Jacobi) && settings.friction == FrictionLaw::Exact;
    residual_bound(model) * if is_slow { 0.1 } else { 1.0 }
}

/// Whether all moving shapes are spheres with isotropic inertia, and all spheres are about their bodies' centres of mass.
fn has_spheres_only(model: &Model, state: &State) -> bool {
    let fits = |s: usize| {
        let moves = state.is_free(model.shape_body[s] as usize);
        model.is_centred_sphere(s) || (model.shape_kind[s] != ShapeKind::Sphere && !moves)
    };
    let isotropic = |b: usize| !state.is_free(b) || is_isotropic(model.inv_inertia[b]);
    (0..model.n_bodies()).all(isotropic) && (0..model.n_shapes()).all(fits)
}
