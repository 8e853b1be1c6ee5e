//! Steps of which the processor has run the first stages: what these have found is written to the columns that the later ones read, so that a
//! fault can be told to be in one stage or another. The state is the processor's between steps. Joints, and the bodies that they act on, are so
//! in any case (`mechanism`).
//! in   given      the columns of `cpu/given.rs`
//! out  margin, fat_aabb, bins, pairs, contact   of `collision`
//! out  gamma      [n_contacts]  N s, world
//! out  free       [n_bodies]    m/s, rad/s: before the solve
//! out  motion     [n_bodies]    m/s, rad/s: before the integration
//! out  displaced  [2 n_bodies]  m/s: with its share, before the integration

use super::rows::Body;
use super::{Fault, Gpu, Stepped, outcome};
use crate::cpu::given::Given;
use crate::model::Model;
use crate::plan::{Narrow, StepPlan};
use crate::stages::Stage;
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;

impl Gpu {
    /// The first stage of the device.
    pub fn from(&self) -> Stage {
        self.before.from
    }

    /// Take what the stages of the processor have found, for the next step.
    pub fn give(&mut self, given: Given) {
        self.before.given = given;
    }

    /// Write the state and what the processor has found, where it runs some of the stages.
    pub(super) fn place_given(&mut self, model: &Model, plan: &StepPlan, state: &State) -> Result<(), Fault> {
        let from = self.before.from;
        if from == Stage::Bounds {
            return Ok(());
        }
        self.collision.bodies.place(&self.device, model, state)?;
        let given = std::mem::take(&mut self.before.given);
        let placed = match from {
            Stage::Integrate => self.place_motion(model, state, &given),
            from if from > Stage::ContactWrite => self.place_contacts(model, plan, state, &given),
            _ => self.place_pairs(model, plan, state, &given),
        };
        self.before.given = given;
        placed
    }

    /// Boxes, and with them bins or pairs.
    fn place_pairs(&mut self, model: &Model, plan: &StepPlan, state: &State, given: &Given) -> Result<(), Fault> {
        let from = self.before.from;
        let rows = match from {
            Stage::ContactWrite => self.collision.rows_of_pairs(&self.device, model, &given.pairs)?,
            _ => vec![],
        };
        if rows.len() > self.collision.rooms()[0] {
            self.make_room(model, plan, [rows.len(); 2])?;
        }
        self.collision.give_boxes(&self.device, &given.margin, state, from);
        if from == Stage::ContactWrite {
            self.collision.give_pairs(&self.device, &rows);
        }
        Ok(())
    }

    /// Contacts, and with them their impulses or velocities without contacts.
    fn place_contacts(&mut self, model: &Model, plan: &StepPlan, state: &State, given: &Given) -> Result<(), Fault> {
        let (from, contacts, n) = (self.before.from, &given.contacts, given.contacts.len());
        if self.collision.rooms().iter().any(|room| n > *room) {
            self.make_room(model, plan, [n; 2])?;
        }
        let device = &self.device;
        // Tiles are cubes of space, which the boxes are in.
        self.collision.give_boxes(device, &given.margin, state, from);
        self.before.placed = self.collision.place_contacts(device, model, contacts)?;
        let (placed, problem) = (&self.before.placed, &self.solve.problem);
        self.collision.give_contacts(device, (model, state), contacts, placed);
        if from > Stage::WarmStart {
            let ordered = |column: &[DVec3]| -> Vec<[f32; 4]> {
                let row = |i: &u32| column.get(*i as usize).map_or([0.0; 4], |z| z.as_vec3().extend(0.0).to_array());
                placed.order.iter().map(row).collect()
            };
            problem.gamma.write(device, &ordered(&contacts.impulse));
            if problem.layout.rolls {
                problem.roll.write(device, &ordered(&contacts.rolling_impulse));
            }
        }
        if from > Stage::Force {
            problem.free.write(device, &bodies(model, state, &given.twist));
        }
        Ok(())
    }

    /// Velocities at the step's end, and displacements.
    fn place_motion(&mut self, model: &Model, state: &State, given: &Given) -> Result<(), Fault> {
        let (device, problem, overlaps) = (&self.device, &self.solve.problem, &self.overlaps);
        problem.motion.write(device, &bodies(model, state, &given.twist));
        problem.n_contacts.n.write(device, &[given.contacts.len() as u32]);
        self.collision.room().write(device, &[0, 1, 0]);
        let is_any = problem.layout.narrow == Narrow::Any;
        let four = |v: DVec3| v.as_vec3().extend(0.0).to_array();
        // The velocities have what keeps the angular momentum already.
        let rows = |moved: &Twist| [Some(four(moved.v)), Some([0.0; 4]), is_any.then(|| four(moved.w))];
        let rows: Vec<[f32; 4]> = given.displacement.iter().flat_map(rows).flatten().collect();
        overlaps.displaced.write(device, &rows);
        overlaps.share.write(device, &[if rows.is_empty() { 0.0 } else { 1.0 }]);
        Ok(())
    }

    /// The integration alone, of which the processor has the outcome and the time.
    pub(super) fn integrate(&mut self, model: &Model, plan: &StepPlan, state: &State) -> Result<Stepped, Fault> {
        self.place_given(model, plan, state)?;
        let mut stage_ms = [0.0; Stage::ALL.len()];
        let timings = self.recorded.own.end.submit(&self.device)?;
        let summary = self.survey.summary.read(&self.device, 1)?[0];
        self.add_times(timings, &mut stage_ms)?;
        (self.is_stale, self.has_old_bodies) = (true, true);
        Ok(Stepped { outcome: outcome(&summary), survey: self.survey.of_watch(&summary, self.mass), stage_ms })
    }

    /// Take the impulses of a solve over to the contacts of a state, which are the processor's.
    pub(super) fn fetch_impulses(&self, state: &mut State) -> Result<(), Fault> {
        let (device, problem, order) = (&self.device, &self.solve.problem, &self.before.placed.order);
        let contacts = &mut state.contacts;
        let wide = |z: &[f32; 4]| DVec3::new(z[0].into(), z[1].into(), z[2].into());
        let gamma = problem.gamma.read(device, order.len())?;
        contacts.impulse.resize(order.len(), DVec3::ZERO);
        order.iter().zip(&gamma).for_each(|(i, z)| contacts.impulse[*i as usize] = wide(z));
        if problem.layout.rolls {
            let roll = problem.roll.read(device, order.len())?;
            contacts.rolling_impulse.resize(order.len(), DVec3::ZERO);
            order.iter().zip(&roll).for_each(|(i, z)| contacts.rolling_impulse[*i as usize] = wide(z));
        }
        Ok(())
    }
}

/// Velocities as rows of a device.
fn bodies(model: &Model, state: &State, twist: &[Twist]) -> Vec<Body> {
    let row = |(b, own): (usize, &Twist)| match state.moves(b) {
        true => Body {
            v: own.v.as_vec3().to_array(),
            inv_mass: model.inv_mass[b] as f32,
            w: own.w.as_vec3().to_array(),
            inv_inertia: model.inv_inertia[b].x as f32,
        },
        false => Body::default(),
    };
    twist.iter().enumerate().map(row).collect()
}
