//! What the stages of this back end have found, for a back end that goes on with the step.

use super::Cpu;
use super::solve::bodies::Falling;
use crate::contacts::Contacts;
use crate::model::Model;
use crate::stages::Stage;
use crate::state::State;
use crate::twist::Twist;

/// The columns that stages from one on read of those before it.
#[derive(Default)]
pub struct Given {
    /// Margins of the shapes, m (n_shapes).
    pub margin: Vec<f32>,
    /// Pairs of shapes, the lower id first, and the triangle where one is a mesh or a height field; for the narrow phase (n_pairs).
    pub pairs: Vec<[u32; 3]>,
    /// The contacts, for what comes after the narrow phase.
    pub contacts: Contacts,
    /// Velocities without contacts, for the solve, or at the step's end, for the integration, m/s, rad/s, world (n_bodies).
    pub twist: Vec<Twist>,
    /// Displacements over the step that recover overlaps, for the integration, m/s, rad/s, world (n_bodies, or none).
    pub displacement: Vec<Twist>,
}

impl Cpu {
    /// The columns for the stages from `from` on, once those before it have run.
    pub fn given(&self, from: Stage, model: &Model, state: &State) -> Given {
        let mut given = Given { margin: self.margin.clone(), ..Given::default() };
        if from == Stage::ContactWrite {
            let spheres = self.pairs.spheres.iter().map(|[s, t]| [*s, *t, 0]);
            given.pairs = spheres.chain(self.pairs.others.iter().copied()).collect();
        }
        if from > Stage::ContactWrite {
            given.contacts = state.contacts.clone();
        }
        if from == Stage::Integrate {
            given.twist = self.response.twist.clone();
            let share = self.displacement.share;
            let made = |moved: &Twist| Twist { v: moved.v * share, w: moved.w * share };
            given.displacement = self.displacement.twist.iter().map(made).collect();
        } else if from > Stage::Force {
            let falling = Falling { model, state };
            given.twist = match self.free.is_empty() {
                true => (0..model.n_bodies()).map(|b| falling.twist(b)).collect(),
                false => self.free.clone(),
            };
        }
        given
    }
}
