//! Places and orientations, and columns of them.

use glam::{DQuat, DVec3};
use std::collections::HashMap;

/// A place and an orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position, m.
    pub position: DVec3,
    /// Orientation, unit.
    pub orientation: DQuat,
}

impl Pose {
    /// A pose given in this one's frame, in the frame that this one is given in.
    #[inline]
    pub fn place(&self, local: &Pose) -> Pose {
        Pose {
            position: self.position + self.orientation * local.position,
            orientation: self.orientation * local.orientation,
        }
    }

    /// The inverse: this pose's outer frame, in its own.
    pub fn inverse(&self) -> Pose {
        let orientation = self.orientation.inverse();
        Pose { position: orientation * -self.position, orientation }
    }
}

/// A column of poses of which most are alike, as those of the grains of a bed are: a row names one of the distinct ones.
#[derive(Clone, Debug, Default)]
pub struct PoseColumn {
    distinct: Vec<Pose>,
    /// So many rows, from the first, have the first pose.
    alike: usize,
    /// Which pose each of the others has.
    row: Vec<u32>,
    known: HashMap<[u64; 7], u32>,
}

impl PoseColumn {
    /// Add a row.
    pub fn push(&mut self, pose: Pose) {
        let (p, q) = (pose.position, pose.orientation);
        let name = [p.x, p.y, p.z, q.x, q.y, q.z, q.w].map(f64::to_bits);
        let next = self.distinct.len() as u32;
        let row = *self.known.entry(name).or_insert(next);
        if row == next {
            self.distinct.push(pose);
        }
        if row == 0 && self.row.is_empty() {
            self.alike += 1;
        } else {
            self.row.push(row);
        }
    }
}

impl std::ops::Index<usize> for PoseColumn {
    type Output = Pose;

    #[inline]
    fn index(&self, row: usize) -> &Pose {
        let which = if row < self.alike { 0 } else { self.row[row - self.alike] };
        &self.distinct[which as usize]
    }
}
