//! Poses, and columns of poses.

use glam::{DQuat, DVec3};
use std::collections::HashMap;

/// A pose: position and orientation of a frame in an outer frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position of the frame's origin, m, in the outer frame.
    pub position: DVec3,
    /// Orientation, frame to outer frame, unit.
    pub orientation: DQuat,
}

impl Pose {
    /// Composition of poses: the pose in the outer frame of a pose `local` that is given in this pose's frame.
    #[inline]
    pub fn place(&self, local: &Pose) -> Pose {
        Pose {
            position: self.position + self.orientation * local.position,
            orientation: self.orientation * local.orientation,
        }
    }

    /// The inverse pose: the outer frame in this pose's frame.
    pub fn inverse(&self) -> Pose {
        let orientation = self.orientation.inverse();
        Pose { position: orientation * -self.position, orientation }
    }
}

/// A column of poses, read as `column[row]`, that stores each distinct pose once: most rows are equal, as those of the grains of a bed.
#[derive(Clone, Debug, Default)]
pub struct PoseColumn {
    distinct: Vec<Pose>,
    /// Number of leading rows with the first pose.
    n_leading: usize,
    /// Index into `distinct` of each further row.
    row: Vec<u32>,
    known: HashMap<[u64; 7], u32>,
}

impl PoseColumn {
    /// Append a row.
    pub fn push(&mut self, pose: Pose) {
        let (p, q) = (pose.position, pose.orientation);
        let bits = [p.x, p.y, p.z, q.x, q.y, q.z, q.w].map(f64::to_bits);
        let next = self.distinct.len() as u32;
        let row = *self.known.entry(bits).or_insert(next);
        if row == next {
            self.distinct.push(pose);
        }
        if row == 0 && self.row.is_empty() {
            self.n_leading += 1;
        } else {
            self.row.push(row);
        }
    }
}

impl std::ops::Index<usize> for PoseColumn {
    type Output = Pose;

    #[inline]
    fn index(&self, row: usize) -> &Pose {
        let index = if row < self.n_leading { 0 } else { self.row[row - self.n_leading] };
        &self.distinct[index as usize]
    }
}
