//! The contact problem on a device: rows of the contacts, the contacts of each body, and what the methods share.
//! in     contact     [n_contacts]    of `contact_write`
//! in     mass        [n_bodies]      1/kg, and principal, 1/(kg m²)
//! in     velocity    [n_bodies]      m/s, at the step's start
//! in     free        [n_bodies]      m/s, rad/s: velocities at the step's end without contacts
//! inout  gamma       [n_contacts]    N s, world: the starting point, projected onto the cones
//! out    row         [n_contacts]
//! out    side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
//! out    side_start  [n_bodies]      first side of each body, and the end
//! out    motion      [n_bodies]      m/s, rad/s: velocities with γ
//! Kernels: solve_rows.wgsl, those of `sides`, response.wgsl, residual.wgsl, residual_sum.wgsl.
//! Twin: cpu/contact_solve.rs

use super::bodies::Bodies;
use super::collision::Collision;
use super::fault::Fault;
use super::joints::{Joints, Solve};
use super::parts::{Layout, ROWS, bits, groups, kernel_of};
use super::rows::{Arms, Body, Contact};
use super::sides::Sides;
use crate::model::{ContactLaw, Model};
use crate::plan::{Narrow, coheres};
use crate::settings::{Impacts, Method};
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels, Work};

/// The problem, with room for as many contacts as a collision has.
pub struct Problem {
    /// Number of bodies.
    pub n_bodies: usize,
    /// Number of contacts, and the most that there can be.
    pub n_contacts: Count,
    /// What the kernels are compiled for.
    pub layout: Layout,
    /// The contacts (n_contacts).
    pub contact: Buffer<Contact>,
    /// Their arms, where these are of any direction (n_contacts).
    pub arms: Buffer<Arms>,
    /// Velocities without contacts, and masses (n_bodies).
    pub free: Buffer<Body>,
    /// Impulses on B, N s, world; the fourth numbers are not used (n_contacts).
    pub gamma: Buffer<[f32; 4]>,
    /// What the impulses of an iterate turn the bodies by, as in `spin.wgsl`, where a method makes iterates of all impulses at once; else one row.
    pub spin: Buffer<[f32; 4]>,
    /// Velocities with these impulses, m/s, rad/s (n_bodies).
    pub motion: Buffer<Body>,
    /// The scalars of the solve (1).
    pub scalars: Buffer<[u32; 16]>,
    /// Workgroups of an iteration over contacts and over bodies, of a check, and of what it keeps (5).
    pub work: Buffer<[u32; 4]>,
    /// Sums over the rows of each workgroup.
    pub of_contacts: Buffer<[f32; 4]>,
    /// The same over bodies.
    pub of_bodies: Buffer<[f32; 4]>,
    /// The greatest overlap, m (1).
    pub worst: Buffer<u32>,
    /// Rolling and spinning impulses on B, N m s, world, where there is rolling friction; else one row (n_contacts).
    pub roll: Buffer<[f32; 4]>,
    /// The rows of their blocks (n_contacts).
    pub roll_row: Buffer<[f32; 4]>,
    /// By Coulomb's law itself: offsets without slip, slips that are fed and measured, m/s; else one row (n_contacts).
    pub slip: Buffer<[f32; 4]>,
    /// The joints, if there are any.
    pub joints: Option<Joints>,
    kernels: ProblemKernels,
    contact_groups: Groups,
    /// Rows of the contacts (n_contacts).
    row: Row,
    /// Masses, and orientations at the step's start; of bodies on joints, those of their inertia in the step (n_bodies).
    inertia: [Buffer<[f32; 4]>; 2],
    sides: Sides,
    /// Whether slip is fed back.
    pub feeds: bool,
    law: Buffer<[f32; 4]>,
    /// Cohesion of each law, N (n_laws).
    cohesion: Buffer<f32>,
    /// Whether there is any.
    pub coheres: bool,
}

/// The rows of the contacts.
enum Row {
    /// Of contacts whose arms lie along their normals.
    Along(Buffer<[u32; 12]>),
    /// Of any contacts.
    Any(Buffer<[u32; 16]>),
}

impl Row {
    fn new(device: &Device, narrow: Narrow, room: usize) -> Result<Row, GpuError> {
        Ok(match narrow {
            Narrow::Spheres => Row::Along(Buffer::zeros(device, "rows", room)?),
            Narrow::Any => Row::Any(Buffer::zeros(device, "rows", room)?),
        })
    }
}

struct ProblemKernels {
    rows: Kernel,
    response: Kernel,
    residual: Kernel,
    residual_sum: Kernel,
}

impl Problem {
    /// For the contacts of a collision.
    /// `feeds` tells that slip is fed back to the rates of gaps.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (model, method, feeds): (&Model, Method, bool),
        (collision, joints): (&Collision, Option<&Joints>),
    ) -> Result<Problem, Fault> {
        let (contact, n_contacts) = collision.columns();
        let (n_bodies, room) = (model.n_bodies(), contact.capacity());
        // Impacts one after another are over before the contacts are solved.
        let bounces = model.solver.impacts == Impacts::Simultaneous;
        let restitution = |l: &ContactLaw| if bounces { l.restitution } else { 0.0 };
        let law = |l: &ContactLaw| [l.friction, restitution(l), l.rolling, l.spinning].map(|x| x as f32);
        let law: Vec<[f32; 4]> = model.laws.iter().map(law).collect();
        let cohesion: Vec<f32> = model.laws.iter().map(|l| l.cohesion as f32).collect();
        let [_, place] = collision.of_pairs();
        let rolling = if collision.bodies.layout.rolls { room } else { 1 };
        let bodies = &collision.bodies;
        let layout = bodies.layout;
        let spins = match (method, layout.narrow) {
            (Method::GaussSeidel, _) => 1,
            (_, Narrow::Spheres) => room,
            (_, Narrow::Any) => 2 * room,
        };
        let get = |name, text| kernel_of(layout, device, kernels, (name, text));
        Ok(Problem {
            n_bodies,
            n_contacts: n_contacts.clone(),
            layout,
            contact: contact.clone(),
            arms: collision.arms().clone(),
            free: Buffer::zeros(device, "free", n_bodies)?,
            gamma: Buffer::zeros(device, "gamma", room)?,
            spin: Buffer::zeros(device, "spin", spins)?,
            motion: Buffer::zeros(device, "motion", n_bodies)?,
            scalars: Buffer::zeros(device, "scalars", 1)?,
            work: Buffer::zeros(device, "work", 5)?,
            of_contacts: Buffer::zeros(device, "sums of contacts", room.div_ceil(ROWS))?,
            of_bodies: Buffer::zeros(device, "sums of bodies", n_bodies.div_ceil(ROWS) + 1)?,
            worst: Buffer::zeros(device, "worst", 1)?,
            slip: Buffer::zeros(device, "slip", if feeds { room } else { 1 })?,
            feeds,
            roll: Buffer::zeros(device, "rolling impulses", rolling)?,
            roll_row: Buffer::zeros(device, "rolling rows", rolling)?,
            kernels: ProblemKernels {
                rows: get("solve_rows", include_str!("solve_rows.wgsl"))?,
                response: get("response", include_str!("response.wgsl"))?,
                residual: get("residual", include_str!("residual.wgsl"))?,
                residual_sum: get("residual_sum", include_str!("residual_sum.wgsl"))?,
            },
            contact_groups: Groups::new(device, kernels, ROWS)?,
            row: Row::new(device, layout.narrow, room)?,
            inertia: match joints {
                None => [bodies.mass.clone(), bodies.orientation.clone()],
                Some(_) => [
                    Buffer::zeros(device, "masses of the step", n_bodies)?,
                    Buffer::zeros(device, "principal frames of the step", n_bodies)?,
                ],
            },
            joints: joints.cloned(),
            sides: Sides::new(device, kernels, (collision.pair_sides(), place), (n_bodies, room))?,
            law: Buffer::of(device, "law", &law)?,
            coheres: coheres(model),
            cohesion: Buffer::of(device, "cohesion", &cohesion)?,
        })
    }

    /// Record what does not change during a solve.
    pub fn record(&self, device: &Device, commands: &mut Commands, model: &Model, bodies: &Bodies) {
        let n = &self.n_contacts;
        commands.clear(&self.worst);
        self.contact_groups.record(device, commands, n);
        let columns = [self.contact.bind(), bodies.mass.bind(), bodies.velocity.bind(), self.law.bind()];
        let rest = [self.gamma.bind(), self.row(), self.worst.bind(), n.n.bind()];
        let of_any = [
            self.arms.bind(),
            bodies.orientation.bind(),
            bodies.spin.bind(),
            self.slip.bind(),
            self.roll.bind(),
            self.roll_row.bind(),
            self.cohesion.bind(),
        ];
        let bound: Vec<Bound> = columns.into_iter().chain(rest).chain(of_any).collect();
        let (h, g, settings) = (model.step, model.gravity.length(), &model.solver);
        let least_speed = 1e-3f64.max(2.0 * g * h);
        let speeds = [settings.recovery_speed, g * h];
        let [a, b, c, d, e, f, s] =
            [h, 1.0 / h, least_speed, settings.rest_gap, g * h * h, speeds[0], speeds[1]].map(bits);
        let params = [a, b, c, d, e, f, s, self.feeds as u32, bits(model.envelope)];
        commands.dispatch(device, &self.kernels.rows, &bound, &params, self.contacts());
        self.sides.record(device, commands, n);
        self.record_response(device, commands);
    }

    /// Record the velocities with the impulses.
    pub fn record_response(&self, device: &Device, commands: &mut Commands) {
        let [gamma, free, side, start] = self.sums_of_bodies();
        let [mass, orientation] = self.inertia();
        let bound = [self.row(), gamma, free, side, start, self.motion.bind(), mass, orientation, self.roll.bind()];
        commands.dispatch(device, &self.kernels.response, &bound, &[], self.bodies());
        if let Some(joints) = &self.joints {
            joints.record_response(device, commands, &self.of_joints(), false);
        }
    }

    /// Record the masses and principal frames of the step, before those of bodies on joints.
    pub fn record_inertia(&self, commands: &mut Commands, bodies: &Bodies) {
        if self.joints.is_some() {
            commands.copy(&bodies.mass, &self.inertia[0], self.n_bodies);
            commands.copy(&bodies.orientation, &self.inertia[1], self.n_bodies);
        }
    }

    /// What the joints have a part in.
    pub fn of_joints(&self) -> Solve<'_> {
        Solve {
            motion: self.motion.bind(),
            free: self.free.bind(),
            scalars: self.scalars.bind(),
            groups: self.work.bind(),
            of_bodies: self.of_bodies.bind(),
            inertia: self.inertia(),
            n_bodies: self.n_bodies,
        }
    }

    /// The number of bodies whose workgroups have the sums over bodies; those on joints have one to themselves.
    pub fn n_sums(&self) -> u32 {
        match self.joints {
            None => self.n_bodies as u32,
            Some(_) => (self.n_bodies.div_ceil(ROWS) * ROWS + 1) as u32,
        }
    }

    /// Record the residual of the solution.
    pub fn record_residual(&self, device: &Device, commands: &mut Commands) {
        let n = self.n_contacts.n.bind();
        let [roll, roll_row] = self.rolling();
        let bound = [self.row(), self.motion.bind(), self.gamma.bind(), self.of_contacts.bind(), n, roll, roll_row];
        commands.dispatch(device, &self.kernels.residual, &bound, &[], self.contacts());
        let bound = [self.of_contacts.bind(), self.scalars.bind(), n];
        commands.dispatch(device, &self.kernels.residual_sum, &bound, &[], Work::Groups(1));
    }

    /// The workgroups of a kernel over contacts, after [`Problem::record`].
    pub fn contacts(&self) -> Work<'_> {
        self.contact_groups.of_level(&self.n_contacts, 0)
    }

    /// The workgroups of a kernel over contacts of which each takes one block after the other, however many there are, while the solve goes on.
    /// A dispatch whose workgroups the host knows begins sooner than one whose workgroups the device does, as the many of a solve.
    pub fn any_contacts(&self) -> Work<'static> {
        /// Enough to fill any device.
        const MOST: usize = 2048;
        Work::Groups(self.gamma.capacity().div_ceil(ROWS).min(MOST) as u32)
    }

    /// The workgroups of a kernel over bodies.
    pub fn bodies(&self) -> Work<'static> {
        groups(self.n_bodies)
    }

    /// The rows of the contacts.
    pub fn row(&self) -> Bound<'_> {
        match &self.row {
            Row::Along(rows) => rows.bind(),
            Row::Any(rows) => rows.bind(),
        }
    }

    /// Masses, and orientations at the step's start.
    pub fn inertia(&self) -> [Bound<'_>; 2] {
        self.inertia.each_ref().map(Buffer::bind)
    }

    /// Impulses and rolling impulses.
    pub fn impulses(&self) -> [&Buffer<[f32; 4]>; 2] {
        [&self.gamma, &self.roll]
    }

    /// Rolling impulses, and the rows of their blocks.
    pub fn rolling(&self) -> [Bound<'_>; 2] {
        [self.roll.bind(), self.roll_row.bind()]
    }

    /// The contacts of each body: sides, starts.
    pub fn sides(&self) -> [Bound<'_>; 2] {
        self.sides.bind()
    }

    /// What a kernel that sums over the contacts of bodies binds beside what turns them: impulses, free velocities, sides, starts.
    pub fn sums_of_bodies(&self) -> [Bound<'_>; 4] {
        let [side, start] = self.sides();
        [self.gamma.bind(), self.free.bind(), side, start]
    }
}
