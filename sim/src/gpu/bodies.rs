//! The state of the bodies as columns of a device, where it stays from step to step.

use super::fault::Fault;
use super::fixed::Scale;
use super::parts::Layout;
use super::rows::{BodyState, Fixed};
use crate::model::Model;
use crate::state::State;
use glam::{DQuat, DVec3, DVec4};
use gpu::{Buffer, Device, GpuError};

/// The columns, a row for each body.
pub struct Bodies {
    /// Number of bodies.
    pub n: usize,
    /// The units of positions.
    pub scale: Scale,
    /// Positions of the centres of mass, fine units.
    pub position: Buffer<Fixed>,
    /// Orientations, x, y, z, w.
    pub orientation: Buffer<[f32; 4]>,
    /// Velocities, m/s, world.
    pub velocity: Buffer<[f32; 4]>,
    /// Angular velocities, rad/s, in the bodies' frames.
    pub spin: Buffer<[f32; 4]>,
    /// Reciprocal mass, 1/kg, and principal moments of inertia, 1/(kg m²); zero for a body that does not move.
    pub mass: Buffer<[f32; 4]>,
    /// What the kernels are compiled for.
    pub layout: Layout,
    /// Moving, held or inactive.
    pub activity: Buffer<u32>,
    /// What `activity` holds.
    known: Vec<u32>,
}

impl Bodies {
    /// Columns for the bodies of a model.
    pub fn new(device: &Device, scale: Scale, layout: Layout, n: usize) -> Result<Bodies, GpuError> {
        Ok(Bodies {
            n,
            layout,
            scale,
            position: Buffer::zeros(device, "position", n)?,
            orientation: Buffer::zeros(device, "orientation", n)?,
            velocity: Buffer::zeros(device, "velocity", n)?,
            spin: Buffer::zeros(device, "spin", n)?,
            mass: Buffer::zeros(device, "mass", n)?,
            activity: Buffer::zeros(device, "activity", n)?,
            known: vec![],
        })
    }

    /// Write a state. Returns whether an activity has changed.
    ///
    /// # Errors
    /// [`Fault::Position`].
    pub fn place(&mut self, device: &Device, model: &Model, state: &State) -> Result<bool, Fault> {
        let fixed = |(body, p): (usize, &DVec3)| self.scale.fix(*p).ok_or(Fault::Position(body as u32));
        let position: Vec<Fixed> = state.position.iter().enumerate().map(fixed).collect::<Result<_, _>>()?;
        let vectors =
            |column: &[DVec3]| -> Vec<[f32; 4]> { column.iter().map(|v| v.as_vec3().extend(0.0).to_array()).collect() };
        let orientation: Vec<[f32; 4]> = state.orientation.iter().map(|q| q.as_quat().to_array()).collect();
        self.position.write(device, &position);
        self.orientation.write(device, &orientation);
        self.velocity.write(device, &vectors(&state.velocity));
        self.spin.write(device, &vectors(&state.angular_velocity));
        Ok(self.place_activity(device, model, state))
    }

    /// Write the activities and the masses that follow from them. Returns whether any has changed.
    pub fn place_activity(&mut self, device: &Device, model: &Model, state: &State) -> bool {
        let activity = |b: usize| match (state.is_inactive(b), state.moves(b)) {
            (true, _) => 2,
            (false, false) => 1,
            (false, true) => 0,
        };
        let activity: Vec<u32> = (0..self.n).map(activity).collect();
        let has_changed = activity != self.known;
        if has_changed {
            let mass = |b: usize| match state.moves(b) {
                true => {
                    let moments = model.inv_inertia[b];
                    [model.inv_mass[b], moments.x, moments.y, moments.z].map(|x| x as f32)
                }
                false => [0.0; 4],
            };
            let mass: Vec<[f32; 4]> = (0..self.n).map(mass).collect();
            self.activity.write(device, &activity);
            self.mass.write(device, &mass);
            self.known = activity;
        }
        has_changed
    }

    /// Read the poses and velocities of the bodies that move back into a state; those that are held stay where they are, to the last bit.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn fetch(&self, device: &Device, state: &mut State) -> Result<(), GpuError> {
        let begun = (
            self.position.read_back(device, self.n)?,
            self.orientation.read_back(device, self.n)?,
            self.velocity.read_back(device, self.n)?,
            self.spin.read_back(device, self.n)?,
        );
        let position = begun.0.wait(device)?;
        let [orientation, velocity, spin] = [begun.1.wait(device)?, begun.2.wait(device)?, begun.3.wait(device)?];
        for b in 0..self.n {
            self.put_row(state, b, (position[b], [orientation[b], velocity[b], spin[b]]));
        }
        Ok(())
    }

    /// Put the state of one body into its row, as [`Bodies::fetch`].
    pub fn put(&self, state: &mut State, row: &BodyState) {
        self.put_row(state, row.body as usize, (row.position, [row.orientation, row.velocity, row.spin]));
    }

    fn put_row(&self, state: &mut State, b: usize, (position, [orientation, velocity, spin]): (Fixed, [[f32; 4]; 3])) {
        let wide = |v: [f32; 4]| DVec4::from_array(v.map(f64::from));
        (state.velocity[b], state.angular_velocity[b]) = (wide(velocity).truncate(), wide(spin).truncate());
        if self.known[b] == 0 {
            state.position[b] = self.scale.unfix(position);
            state.orientation[b] = DQuat::from_vec4(wide(orientation));
        }
    }
}
