//! Contacts as columns, by tiles.

use crate::twist::Twist;
use glam::DVec3;
use std::ops::Range;

/// Contacts as columns (n_contacts each). Body A is the one with the lower index.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Contacts {
    /// Bodies A and B.
    pub bodies: Vec<[u32; 2]>,
    /// Shapes of A and B and the feature where they touch: what a contact is known by from step to step.
    pub key: Vec<[u32; 3]>,
    /// The pair of spheres, in its tile, that the contact is of, or [`NOT_OF_SPHERES`]; those of spheres come first in a tile.
    #[serde(skip)]
    pub pair: Vec<u32>,
    /// Unit normal, out of A, world.
    pub normal: Vec<DVec3>,
    /// From the bodies' centres to the contact point.
    pub arms: Arms,
    /// Gap Φ, m; negative where the bodies overlap.
    pub gap: Vec<f64>,
    /// Which of the model's laws holds.
    pub law: Vec<u32>,
    /// Impulse on B, N s, world: A_p γ.
    pub impulse: Vec<DVec3>,
    /// Rolling and spinning impulse on B, N m s, world (none where no material has rolling or spinning friction).
    pub rolling_impulse: Vec<DVec3>,
    /// How they lie by tiles.
    #[serde(skip)]
    pub tiles: Tiles,
}

/// The pair of a contact that is not between two spheres.
pub const NOT_OF_SPHERES: u32 = u32::MAX;

/// Contacts lie tile by tile: the tiles of a round share no moving body. The second round has what the first cuts, and the last
/// row has the contacts in no tile.
#[derive(Clone, Debug, Default)]
pub struct Tiles {
    /// First contact of each tile and of those in none, and their end (n_tiles + 2; empty before the first step).
    pub start: Vec<u32>,
    /// Tiles of the first round.
    pub n_first: usize,
}

impl Tiles {
    /// Where the tiles of each round begin, and after the last where it ends.
    pub fn rounds(&self) -> [&[u32]; 2] {
        match self.start.len() {
            0 => [&[], &[]],
            n => [&self.start[..=self.n_first], &self.start[self.n_first..n - 1]],
        }
    }

    /// The contacts in no tile.
    pub fn rest(&self) -> Range<u32> {
        match self.start[..] {
            [.., first, end] => first..end,
            _ => 0..0,
        }
    }
}

/// From the centres of A and B to the contact point, m, world (n_contacts). Of a body that is held in place nobody asks it.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum Arms {
    /// Of any bodies.
    Any(Vec<[DVec3; 2]>),
    /// Of spheres about their own centres: along the normal, the lengths alone; zero for a body that is held in place.
    Along(Vec<[f64; 2]>),
}

impl Default for Arms {
    fn default() -> Arms {
        Arms::Any(vec![])
    }
}

impl Contacts {
    /// The arms of a contact, m, world.
    #[inline]
    pub fn arms(&self, i: usize) -> [DVec3; 2] {
        match &self.arms {
            Arms::Any(arms) => arms[i],
            Arms::Along(reach) => [self.normal[i] * reach[i][0], self.normal[i] * -reach[i][1]],
        }
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether nothing touches.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Greatest overlap, m; zero where nothing overlaps.
    pub fn worst_penetration(&self) -> f64 {
        self.gap.iter().fold(0.0, |worst: f64, gap| worst.max(-gap))
    }

    /// The multipliers γ = (γ_n, γ_u, γ_w) of a contact, N s, in its frame A_p = [n u w].
    pub fn gamma(&self, i: usize) -> DVec3 {
        let (u, w) = tangents(self.normal[i]);
        DVec3::new(self.impulse[i].dot(self.normal[i]), self.impulse[i].dot(u), self.impulse[i].dot(w))
    }

    /// The velocity of B against A at a contact, m/s, world, for the velocities of the bodies.
    pub fn velocity(&self, i: usize, of: impl Fn(usize) -> Twist) -> DVec3 {
        let [a, b] = self.bodies[i].map(|b| of(b as usize));
        let [arm_a, arm_b] = self.arms(i);
        b.v + b.w.cross(arm_b) - a.v - a.w.cross(arm_a)
    }
}

/// The contact frame A_p = [n u w]: two tangents to a unit normal (Duff et al. 2017), smooth but for n_z = 0.
#[inline]
pub fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}
