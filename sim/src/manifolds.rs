//! Manifolds that are kept from step to step: the contact points of two convex shapes, held in the frames of both, which are carried along
//! with the shapes while these hardly move against each other (`cpu/recycle.rs` has how).

use glam::{DQuat, DVec3};

/// The number of a corner of a convex shape, from 1 on; 0 is none, of a curved surface.
pub type Corner = u16;

/// The corners of two shapes that their nearest points lie between, pair by pair; zeros after the last.
pub type Corners = [[Corner; 2]; 3];

/// The kept manifolds of all pairs, by parts of the candidate pairs.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Manifolds {
    /// The manifolds of each part, which is some pairs of a tile (`contact_write`).
    pub parts: Vec<PartManifolds>,
}

/// The kept manifolds of a part.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct PartManifolds {
    /// The manifolds, in the order of their pairs.
    pub kept: Vec<Kept>,
    /// Points of all manifolds, one manifold after the other.
    pub points: Vec<KeptPoint>,
}

/// A kept manifold.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Kept {
    /// Index of the pair within its part, in the step that it was last used in.
    pub pair: u32,
    /// End of its points.
    pub end: u32,
    /// Ids of the two shapes.
    pub shapes: [u32; 2],
    /// Position of the second shape in the frame of the first when the points were found, m.
    pub position: DVec3,
    /// Orientation of the second shape in the frame of the first when the points were found.
    pub orientation: DQuat,
    /// Axis along which the shapes were farthest apart when the points were found, from the first to the second, in the frame of the
    /// first.
    pub axis: DVec3,
    /// Corners of the shapes that the nearest points lay between.
    pub corners: Corners,
    /// Gap up to which points were looked for, m.
    pub reach: f64,
    /// Gap that the shapes had at least when they were, m; negative in overlap.
    pub gap: f64,
    /// Relative motion up to which the points may be carried along, m.
    pub slack: f64,
}

/// A point of a kept manifold. On a capsule it is the one on its axis.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct KeptPoint {
    /// Point on the first shape, m, in its frame.
    pub on_first: DVec3,
    /// Point on the second shape, m, in its frame.
    pub on_second: DVec3,
    /// Unit normal from the first to the second, in the frame of the shape whose face it is across, or whose feature is the reference.
    pub normal: DVec3,
    /// Feature id.
    pub feature: u32,
    /// Whether that is the second shape.
    pub is_of_second: bool,
}

impl PartManifolds {
    /// The points of a manifold.
    pub fn points_of(&self, k: usize) -> &[KeptPoint] {
        let first = if k == 0 { 0 } else { self.kept[k - 1].end };
        &self.points[first as usize..self.kept[k].end as usize]
    }

    /// Let go of all manifolds.
    pub fn clear(&mut self) {
        self.kept.clear();
        self.points.clear();
    }
}

impl Manifolds {
    /// Check that manifolds, as a file gives them, are of shapes of a model with this number of them.
    ///
    /// # Errors
    /// What does not fit, for a message.
    pub(crate) fn fit(&self, n_shapes: usize) -> Result<(), String> {
        let is_sound = |part: &PartManifolds| {
            let n_points = part.kept.last().map_or(0, |k| k.end as usize);
            let ascend = part.kept.windows(2).all(|k| k[0].end <= k[1].end && k[0].pair < k[1].pair);
            let numbers = |k: &Kept| {
                k.shapes.iter().all(|s| (*s as usize) < n_shapes)
                    && k.position.is_finite()
                    && k.orientation.is_normalized()
                    && (k.axis == DVec3::ZERO || k.axis.is_normalized())
                    && k.reach.is_finite()
                    && k.gap.is_finite()
                    && k.slack.is_finite()
            };
            let place = |p: &KeptPoint| p.on_first.is_finite() && p.on_second.is_finite() && p.normal.is_normalized();
            ascend && n_points == part.points.len() && part.kept.iter().all(numbers) && part.points.iter().all(place)
        };
        match self.parts.iter().position(|part| !is_sound(part)) {
            Some(part) => Err(format!("has manifolds of part {part} of no shapes of the model")),
            None => Ok(()),
        }
    }
}
