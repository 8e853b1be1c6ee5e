//! The ordered list of stages, and the columns between them.
//!
//! A step is the stages of [`Stage::ALL`], one after the other. Each back end has a file per stage, `cpu/<stage>.rs`, whose head
//! names its input and output columns; [`COLUMNS`] is the whole table, against which [`check`] validates a step in debug builds.
//! Ragged data is in compressed rows: a column of starts, which begins with 0, never decreases and ends with the number of items,
//! and a column of items.

use crate::contacts::Arms;
use crate::joint::Row;
use crate::model::Model;
use crate::plan::{Narrow, StepPlan};
use crate::state::State;
use crate::twist::Twist;
use bytemuck::NoUninit;
use glam::{DQuat, DVec3};
use std::borrow::Cow;
use std::mem::size_of;

/// How far apart the bodies of two back ends may be after twenty steps from one state, or of runs of which some stages are one back end's and
/// some the other's, m.
pub const PARITY: f64 = 1e-4;

/// A stage of the step, in the order in which a step runs them.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Margins and fat AABBs of the shapes.
    Bounds,
    /// Pairs of a bin and a shape, for every bin that the shape's box overlaps.
    BinEmit,
    /// Sort of the pairs by bin.
    BinSort,
    /// Range of each bin with more than one shape.
    BinStart,
    /// Broad phase: candidate pairs of shapes whose boxes overlap, by tiles.
    PairWrite,
    /// Narrow phase: contacts of the candidate pairs.
    ContactWrite,
    /// Initial impulses of the contacts.
    WarmStart,
    /// Velocities at the step's end without contacts and joints.
    Force,
    /// Rows of joints, motors, springs and limits.
    JointWrite,
    /// Impulses of contacts and joints, and the velocities at the step's end with these impulses.
    ContactSolve,
    /// Integration of the poses, and the states of joints and springs.
    Integrate,
}

impl Stage {
    /// All stages, in the order in which a step runs them.
    pub const ALL: [Stage; 11] = [
        Stage::Bounds,
        Stage::BinEmit,
        Stage::BinSort,
        Stage::BinStart,
        Stage::PairWrite,
        Stage::ContactWrite,
        Stage::WarmStart,
        Stage::Force,
        Stage::JointWrite,
        Stage::ContactSolve,
        Stage::Integrate,
    ];

    /// Name, as in the files of the back ends, reports and timers.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Bounds => "bounds",
            Stage::BinEmit => "bin_emit",
            Stage::BinSort => "bin_sort",
            Stage::BinStart => "bin_start",
            Stage::PairWrite => "pair_write",
            Stage::ContactWrite => "contact_write",
            Stage::WarmStart => "warm_start",
            Stage::Force => "force",
            Stage::JointWrite => "joint_write",
            Stage::ContactSolve => "contact_solve",
            Stage::Integrate => "integrate",
        }
    }
}

/// The number of rows of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// One row per body.
    Bodies,
    /// One row per shape.
    Shapes,
    /// One row per joint, and one more.
    JointStarts,
    /// The length of another column.
    As(Column),
    /// Any number of rows, found by the stage that writes the column.
    Found,
}

/// The condition on a column's values that [`check`] verifies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Finite numbers.
    Finite,
    /// Finite numbers, verified by the [`watch`](crate::watch) over the run instead.
    Watched,
    /// Starts of the rows of a column of items: from 0, never decreasing, to the number of items.
    StartsOf(Column),
    /// Ids of bodies.
    Bodies,
    /// Ids of shapes.
    Shapes,
    /// Indices into [`Model::laws`].
    Laws,
    /// No condition.
    Any,
}

/// An entry of the table of columns.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// The column.
    pub column: Column,
    /// Name in the heads of the stages' files.
    pub name: &'static str,
    /// Size of a row, bytes.
    pub width: usize,
    /// Unit of the values; empty for values without a unit.
    pub unit: &'static str,
    /// Number of rows.
    pub length: Length,
    /// Condition on the values.
    pub values: Values,
    /// Stages that write the column.
    pub writers: &'static [Stage],
    /// Stages that read the column, in the same step or in the next.
    pub readers: &'static [Stage],
}

/// Make the enum of columns and their table from one list.
macro_rules! columns {
    ($($(#[$doc:meta])* $column:ident $name:literal: $type:ty, $length:expr, $values:expr, $unit:literal,
        [$($writer:ident),*] => [$($reader:ident),*];)*) => {
        /// A column between stages. Width, unit, length, writers and readers are in its entry of [`COLUMNS`] ([`Column::spec`]).
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Column {
            $($(#[$doc])* $column,)*
        }

        /// The columns between stages, in the order of [`Column`].
        pub const COLUMNS: &[Spec] = &[$(Spec {
            column: Column::$column,
            name: $name,
            width: size_of::<$type>(),
            unit: $unit,
            length: $length,
            values: $values,
            writers: &[$(Stage::$writer),*],
            readers: &[$(Stage::$reader),*],
        },)*];
    };
}

columns! {
    /// Positions of the centres of mass, world.
    Position "position": DVec3, Length::Bodies, Values::Watched, "m",
        [Integrate] => [Bounds, PairWrite, ContactWrite, Force, JointWrite, ContactSolve, Integrate];
    /// Orientations of the principal frames.
    Orientation "orientation": DQuat, Length::Bodies, Values::Watched, "",
        [Integrate] => [Bounds, PairWrite, ContactWrite, Force, JointWrite, ContactSolve, Integrate];
    /// Velocities, world.
    Velocity "velocity": DVec3, Length::Bodies, Values::Watched, "m/s",
        [Integrate] => [Bounds, ContactWrite, Force, ContactSolve];
    /// Angular velocities, principal frame.
    AngularVelocity "angular_velocity": DVec3, Length::Bodies, Values::Watched, "rad/s",
        [Integrate] => [Bounds, ContactWrite, Force, ContactSolve];
    /// Distance from a shape's surface within which contacts are generated.
    Margin "margin": f32, Length::Shapes, Values::Finite, "m", [Bounds] => [ContactWrite];
    /// Tight AABBs, grown by the margin, where the plan has [`Narrow::Any`].
    TightAabb "tight_aabb": crate::aabb::Aabb, Length::Shapes, Values::Any, "m", [Bounds] => [ContactWrite];
    /// Spheres (centre, world, and radius) with their bodies and materials, where the plan has [`Narrow::Spheres`].
    Sphere "sphere": crate::sphere::Sphere, Length::Shapes, Values::Finite, "m", [Bounds] => [ContactWrite];
    /// Fat AABBs, grown by a margin for motion; a plane's is unbounded.
    FatAabb "fat_aabb": crate::aabb::Aabb, Length::Shapes, Values::Any, "m", [Bounds] => [BinEmit, PairWrite];
    /// Level of the bins of a shape.
    BinLevel "bin_level": u8, Length::Shapes, Values::Any, "", [BinEmit] => [PairWrite];
    /// Bin coordinates of the minimum corner of a shape's box.
    BinLow "bin_low": glam::UVec3, Length::Shapes, Values::Any, "", [BinEmit] => [PairWrite];
    /// Index of the bin of each pair of a bin and a shape.
    Bin "bin": u32, Length::Found, Values::Any, "", [BinEmit, BinSort] => [BinSort, BinStart, PairWrite];
    /// Id of the shape of each pair of a bin and a shape.
    BinShape "bin_shape": u32, Length::As(Column::Bin), Values::Shapes, "", [BinEmit, BinSort] => [BinSort, PairWrite];
    /// First pair and end of the pairs of each bin with more than one shape.
    BinStart "bin_start": [u32; 2], Length::Found, Values::Any, "", [BinStart] => [PairWrite];
    /// First pair of spheres of each tile and of the pairs in no tile, and the end.
    SpherePairStart "sphere_pair_start": u32, Length::Found, Values::StartsOf(Column::SpherePair), "",
        [PairWrite] => [ContactWrite];
    /// Candidate pairs of spheres, the lower id first.
    SpherePair "sphere_pair": [u32; 2], Length::Found, Values::Shapes, "", [PairWrite] => [ContactWrite];
    /// First pair other than of spheres of each tile and of the pairs in no tile, and the end.
    OtherPairStart "other_pair_start": u32, Length::As(Column::SpherePairStart), Values::StartsOf(Column::OtherPair), "",
        [PairWrite] => [ContactWrite];
    /// Candidate pairs other than of spheres, the lower id first, and the triangle where one is a mesh or a height field.
    OtherPair "other_pair": [u32; 3], Length::Found, Values::Any, "", [PairWrite] => [ContactWrite];
    /// First contact of each tile and of the contacts in no tile, and the end.
    ContactStart "contact_start": u32, Length::As(Column::SpherePairStart), Values::StartsOf(Column::ContactBodies), "",
        [ContactWrite] => [WarmStart, ContactSolve];
    /// Bodies A and B of a contact, the lower id first.
    ContactBodies "contact_bodies": [u32; 2], Length::Found, Values::Bodies, "", [ContactWrite] => [Force, ContactSolve];
    /// Identity of a contact from step to step: its shapes and feature id.
    ContactKey "contact_key": [u32; 3], Length::As(Column::ContactBodies), Values::Any, "",
        [ContactWrite] => [WarmStart, ContactSolve];
    /// Index of a contact's sphere pair within its tile; `u32::MAX` for other contacts.
    ContactPair "contact_pair": u32, Length::As(Column::ContactBodies), Values::Any, "", [ContactWrite] => [WarmStart];
    /// Unit normals, out of A, world.
    ContactNormal "contact_normal": DVec3, Length::As(Column::ContactBodies), Values::Finite, "",
        [ContactWrite] => [Force, ContactSolve];
    /// Arms from the centres of mass of A and B to the contact point, world, where the plan has [`Narrow::Any`].
    ContactArms "contact_arms": [DVec3; 2], Length::As(Column::ContactBodies), Values::Finite, "m",
        [ContactWrite] => [WarmStart, Force, ContactSolve];
    /// Lengths of the arms along the normal, where the plan has [`Narrow::Spheres`].
    ContactReach "contact_reach": [f64; 2], Length::As(Column::ContactBodies), Values::Finite, "m",
        [ContactWrite] => [WarmStart, Force, ContactSolve];
    /// Gaps Φ, negative in overlap.
    ContactGap "contact_gap": f64, Length::As(Column::ContactBodies), Values::Finite, "m", [ContactWrite] => [Force, ContactSolve];
    /// Contact law, an index into [`Model::laws`].
    ContactLaw "contact_law": u32, Length::As(Column::ContactBodies), Values::Laws, "", [ContactWrite] => [Force, ContactSolve];
    /// Impulses on B, world.
    Impulse "impulse": DVec3, Length::As(Column::ContactBodies), Values::Watched, "N s",
        [WarmStart, ContactSolve] => [WarmStart, ContactSolve];
    /// Rolling and spinning impulses on B, world, where the plan has [`StepPlan::rolls`].
    RollingImpulse "rolling_impulse": DVec3, Length::As(Column::ContactBodies), Values::Watched, "N m s",
        [WarmStart, ContactSolve] => [WarmStart, ContactSolve];
    /// Velocities at the step's end without contacts and joints, world, where the plan has [`StepPlan::has_free_column`].
    Free "free": Twist, Length::Bodies, Values::Finite, "m/s, rad/s", [Force, JointWrite] => [JointWrite, ContactSolve];
    /// Inverse inertia tensor and inertia tensor of each body with anisotropic inertia, world.
    Tensor "tensor": [glam::DMat3; 2], Length::Found, Values::Finite, "1/(kg m²), kg m²", [Force, JointWrite] => [JointWrite, ContactSolve];
    /// First joint row of each joint, and of the implicit springs.
    JointStart "joint_start": u32, Length::JointStarts, Values::Any, "", [JointWrite] => [ContactSolve, Integrate];
    /// Rows of joints, motors, limits that may be met in the step, and implicit springs.
    JointRow "joint_row": Row, Length::Found, Values::Finite, "", [JointWrite] => [ContactSolve, Integrate];
    /// What the step leaves of Ψ of the joint rows.
    JointKept "joint_kept": f64, Length::As(Column::JointRow), Values::Finite, "m, rad", [JointWrite] => [ContactSolve];
    /// Bias (Ψ − kept)/h − rate of the joint rows, and the terms of springs.
    JointBias "joint_bias": f64, Length::As(Column::JointRow), Values::Finite, "m/s, rad/s", [JointWrite, ContactSolve] => [ContactSolve];
    /// Velocities at the step's end with contacts and joints, world.
    Motion "motion": Twist, Length::Bodies, Values::Watched, "m/s, rad/s", [ContactSolve] => [Integrate];
    /// Displacements over the step size that recover overlaps, world; no rows where nothing overlaps.
    Displacement "displacement": Twist, Length::Found, Values::Finite, "m/s, rad/s", [ContactSolve] => [Integrate];
    /// Multipliers of the joint rows.
    JointImpulse "joint_impulse": f64, Length::As(Column::JointRow), Values::Watched, "N s, N m s",
        [ContactSolve] => [Integrate];
}

impl Column {
    /// Entry of the column in the table.
    pub fn spec(self) -> &'static Spec {
        &COLUMNS[self as usize]
    }

    /// Whether the plan has the column.
    fn is_planned(self, plan: &StepPlan) -> bool {
        match self {
            Column::Sphere | Column::ContactReach => plan.narrow == Narrow::Spheres,
            Column::ContactArms | Column::TightAabb => plan.narrow == Narrow::Any,
            Column::RollingImpulse => plan.rolls,
            Column::Free => plan.has_free_column,
            _ => true,
        }
    }
}

/// A view of a column for [`check`].
pub struct View<'a> {
    rows: usize,
    width: usize,
    numbers: Numbers<'a>,
}

/// A column's numbers, row after row.
enum Numbers<'a> {
    U32(&'a [u32]),
    F32(&'a [f32]),
    F64(Cow<'a, [f64]>),
    Opaque,
}

impl<'a> View<'a> {
    /// A column of ids and indices.
    pub fn of_u32<T: NoUninit>(column: &'a [T]) -> View<'a> {
        View { rows: column.len(), width: size_of::<T>(), numbers: Numbers::U32(bytemuck::cast_slice(column)) }
    }

    /// A column of numbers in single precision.
    pub fn of_f32(column: &'a [f32]) -> View<'a> {
        View { rows: column.len(), width: size_of::<f32>(), numbers: Numbers::F32(column) }
    }

    /// A column of rows of numbers in double precision.
    pub fn of_f64<T: NoUninit>(column: &'a [T]) -> View<'a> {
        View { rows: column.len(), width: size_of::<T>(), numbers: Numbers::F64(bytemuck::cast_slice(column).into()) }
    }

    /// A column of records, of which the numbers that `numbers` returns are checked.
    pub fn of_rows<T, const K: usize>(column: &'a [T], numbers: impl Fn(&T) -> [f64; K]) -> View<'a> {
        let numbers: Vec<f64> = column.iter().flat_map(numbers).collect();
        View { rows: column.len(), width: size_of::<T>(), numbers: Numbers::F64(numbers.into()) }
    }

    /// A column of which the length alone is checked.
    pub fn of_any<T>(column: &'a [T]) -> View<'a> {
        View { rows: column.len(), width: size_of::<T>(), numbers: Numbers::Opaque }
    }

    /// A column of the state; none for a column that a back end keeps.
    pub fn of_state(state: &'a State, column: Column) -> Option<View<'a>> {
        let c = &state.contacts;
        Some(match (column, &c.arms) {
            (Column::Position, _) => View::of_f64(&state.position),
            (Column::Orientation, _) => View::of_f64(&state.orientation),
            (Column::Velocity, _) => View::of_f64(&state.velocity),
            (Column::AngularVelocity, _) => View::of_f64(&state.angular_velocity),
            (Column::FatAabb, _) => View::of_any(state.fat_aabb.as_deref().unwrap_or_default()),
            (Column::ContactStart, _) => View::of_u32(&c.tiles.start),
            (Column::ContactBodies, _) => View::of_u32(&c.bodies),
            (Column::ContactKey, _) => View::of_u32(&c.key),
            (Column::ContactPair, _) => View::of_u32(&c.pair),
            (Column::ContactNormal, _) => View::of_f64(&c.normal),
            (Column::ContactArms, Arms::Any(arms)) => View::of_f64(arms),
            (Column::ContactReach, Arms::Along(reach)) => View::of_f64(reach),
            // Contacts have one layout or the other.
            (Column::ContactArms, _) => View::of_f64::<[DVec3; 2]>(&[]),
            (Column::ContactReach, _) => View::of_f64::<[f64; 2]>(&[]),
            (Column::ContactGap, _) => View::of_f64(&c.gap),
            (Column::ContactLaw, _) => View::of_u32(&c.law),
            (Column::Impulse, _) => View::of_f64(&c.impulse),
            (Column::RollingImpulse, _) => View::of_f64(&c.rolling_impulse),
            _ => return None,
        })
    }
}

/// Check the columns that a stage has written against the table.
///
/// # Errors
/// The first fault: a column of the wrong width or length, starts that decrease, an id out of range, a value that is not finite; or
/// tiles of one round with a moving body in common.
pub fn check<'a>(
    after: Stage,
    model: &Model,
    plan: &StepPlan,
    state: &State,
    view: impl Fn(Column) -> View<'a>,
) -> Result<(), String> {
    for spec in COLUMNS.iter().filter(|s| s.writers.contains(&after) && s.column.is_planned(plan)) {
        let found = check_column(spec, model, &view(spec.column), &view);
        found.map_err(|fault| format!("after `{}`: column `{}` {fault}", after.name(), spec.name))?;
    }
    if after == Stage::ContactWrite { check_tiles(state) } else { Ok(()) }
}

fn check_column<'a>(
    spec: &Spec,
    model: &Model,
    column: &View,
    view: &impl Fn(Column) -> View<'a>,
) -> Result<(), String> {
    let View { rows, width, .. } = *column;
    if width != spec.width {
        return Err(format!("has rows of {width} bytes, expected {}", spec.width));
    }
    let expected = match spec.length {
        Length::Bodies => model.n_bodies(),
        Length::Shapes => model.n_shapes(),
        Length::JointStarts => model.joints.len() + 1,
        Length::As(other) => view(other).rows,
        Length::Found => rows,
    };
    if rows != expected {
        return Err(format!("has {rows} rows, expected {expected}"));
    }
    let below = |n: usize| match &column.numbers {
        Numbers::U32(ids) => match ids.iter().position(|id| *id as usize >= n) {
            Some(k) => Err(format!("has {} where ids are below {n} ({k} of {})", ids[k], ids.len())),
            None => Ok(()),
        },
        _ => Err("has no ids".into()),
    };
    match spec.values {
        Values::Any | Values::Watched => Ok(()),
        Values::Bodies => below(model.n_bodies()),
        Values::Shapes => below(model.n_shapes()),
        Values::Laws => below(model.laws.len()),
        Values::StartsOf(items) => match column.numbers {
            Numbers::U32(starts) => check_starts(starts, view(items).rows),
            _ => Err("has no starts".into()),
        },
        Values::Finite => {
            let bad = match &column.numbers {
                Numbers::F64(numbers) => numbers.iter().position(|x| !x.is_finite()),
                Numbers::F32(numbers) => numbers.iter().position(|x| !x.is_finite()),
                _ => return Err("has no real numbers".into()),
            };
            bad.map_or(Ok(()), |k| Err(format!("has a value that is not finite at index {k}")))
        }
    }
}

fn check_starts(starts: &[u32], n_items: usize) -> Result<(), String> {
    if starts.first() != Some(&0) || starts.last().map(|end| *end as usize) != Some(n_items) {
        return Err(format!("does not go from 0 to {n_items}"));
    }
    match starts.windows(2).position(|ends| ends[0] > ends[1]) {
        Some(k) => Err(format!("decreases after row {k}")),
        None => Ok(()),
    }
}

/// Check that no two tiles of a round, which are solved in parallel, have contacts of one moving body.
fn check_tiles(state: &State) -> Result<(), String> {
    const NONE: usize = usize::MAX;
    for round in state.contacts.tiles.rounds() {
        let mut tile_of = vec![NONE; state.position.len()];
        for (tile, ends) in round.windows(2).enumerate() {
            for contact in ends[0] as usize..ends[1] as usize {
                for body in state.contacts.bodies[contact].map(|b| b as usize).into_iter().filter(|b| state.moves(*b)) {
                    if tile_of[body] != tile && tile_of[body] != NONE {
                        return Err(format!("after `contact_write`: body {body} has contacts in two tiles of a round"));
                    }
                    tile_of[body] = tile;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
