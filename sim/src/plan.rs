//! What the steps of a run need, resolved once: again only when a body begins to move or the solver's settings change.

use crate::model::Model;
use crate::settings::{FrictionLaw, Method, SolverSettings};
use crate::state::State;

use crate::inertia::is_isotropic;
use crate::shape::ShapeKind;

/// Which shapes meet in contacts, and with that the narrow phase and the layout of the contacts' rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Narrow {
    /// All that moves are spheres about their bodies' centres that turn alike about all axes: they stand in a column of their own,
    /// pairs of them are looked at four at a time, and a contact's arms are lengths along its normal.
    Spheres,
    /// Any shapes: pair by pair, and a contact's arms are vectors.
    #[default]
    Any,
}

/// How the impulses of contacts are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMethod {
    /// Gauss–Seidel on packed contacts between spheres, which solve either law of friction contact by contact; where no limit of a
    /// joint may be met in the step.
    SphereSweeps,
    /// A method over blocks.
    Blocks(Method),
}

/// What the steps of a run need.
#[derive(Clone, Debug)]
pub struct StepPlan {
    /// The narrow phase and the layout of the contacts' rows.
    pub narrow: Narrow,
    /// How impulses are found.
    pub method: ContactMethod,
    /// Whether a material has rolling or spinning friction, so that contacts have rolling impulses.
    pub rolls: bool,
    /// Whether a material has cohesion.
    pub coheres: bool,
    /// Whether a material has restitution.
    pub bounces: bool,
    /// Whether velocities without contacts and joints are a column; else they are evaluated where they are asked for, twice a step.
    pub has_free_column: bool,
    /// Whether contacts start from the last step's impulses.
    pub warm_starts: bool,
    /// The settings that were resolved.
    settings: SolverSettings,
}

impl StepPlan {
    /// Resolve what a model needs while bodies do what they do.
    pub fn resolve(model: &Model, state: &State) -> StepPlan {
        let settings = &model.solver;
        let any = |has: fn(&crate::model::ContactLaw) -> bool| model.laws.iter().any(has);
        let rolls = any(|l| l.rolling > 0.0 || l.spinning > 0.0);
        let coheres = any(|l| l.cohesion != 0.0);
        let narrow = if has_spheres_only(model, state) { Narrow::Spheres } else { Narrow::Any };
        let has_spheres = narrow == Narrow::Spheres;
        let sweeps = settings.method == Method::GaussSeidel && has_spheres;
        let method = if sweeps && !rolls && !coheres {
            ContactMethod::SphereSweeps
        } else {
            ContactMethod::Blocks(settings.method)
        };
        let is_pushed = !(model.loads.is_empty() && model.joints.is_empty() && model.springs.is_empty());
        StepPlan {
            narrow,
            method,
            rolls,
            coheres,
            bounces: any(|l| l.restitution > 0.0),
            has_free_column: is_pushed || !sweeps,
            warm_starts: settings.warm_start,
            settings: settings.clone(),
        }
    }

    /// Whether the plan is still that of a model, while bodies do what they did.
    pub fn holds(&self, model: &Model) -> bool {
        self.settings == model.solver
    }

    /// How impulses are found in a step that may meet so many limits of joints.
    pub fn method_with(&self, n_limits: usize) -> ContactMethod {
        if n_limits == 0 { self.method } else { ContactMethod::Blocks(self.settings.method) }
    }

    /// Whether exact friction feeds the slip of contacts into their gaps' rates.
    pub fn feeds_slip(&self, method: ContactMethod) -> bool {
        self.settings.friction == FrictionLaw::Exact && method != ContactMethod::SphereSweeps
    }
}

/// Whether all that moves are spheres that turn alike about all axes, and all spheres are about their bodies' centres.
fn has_spheres_only(model: &Model, state: &State) -> bool {
    let fits = |s: usize| {
        let moves = state.moves(model.shape_body[s] as usize);
        model.is_centred_sphere(s) || (model.shape_kind[s] != ShapeKind::Sphere && !moves)
    };
    let turns_alike = |b: usize| !state.moves(b) || is_isotropic(model.inv_inertia[b]);
    (0..model.n_bodies()).all(turns_alike) && (0..model.n_shapes()).all(fits)
}
