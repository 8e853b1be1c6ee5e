//! The contacts of a step as columns, ordered by tiles.

use crate::twist::Twist;
use glam::DVec3;
use std::ops::Range;

/// The contacts of a step as columns (n_contacts each), ordered by tiles. Body A of a contact is the one with the lower id.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Contacts {
    /// Ids of bodies A and B.
    pub bodies: Vec<[u32; 2]>,
    /// Identity of a contact from step to step: the ids of the shapes of A and B, and the feature id.
    pub key: Vec<[u32; 3]>,
    /// Index of the contact's pair within its tile: among the pairs of spheres, which come first, or `OTHER` and that among the other pairs;
    /// `NO_PAIR` of contacts that do not know it.
    #[serde(skip)]
    pub pair: Vec<u32>,
    /// Unit normal, out of A, world.
    pub normal: Vec<DVec3>,
    /// Contact arms, from the centres of mass of A and B to the contact point, m, world.
    pub arms: Arms,
    /// Gap Φ, m; negative where the bodies overlap.
    pub gap: Vec<f64>,
    /// Contact law, an index into [`Model::laws`](crate::Model::laws).
    pub law: Vec<u32>,
    /// Impulse on B, N s, world: A_p γ, with the contact frame A_p of [`Contacts::gamma`].
    pub impulse: Vec<DVec3>,
    /// Rolling and spinning impulse on B, N m s, world (empty where no material has rolling or spinning friction).
    pub rolling_impulse: Vec<DVec3>,
    /// Partition of the contacts into tiles.
    #[serde(skip)]
    pub tiles: Tiles,
}

/// What `pair` has beyond the index of a pair that is not one of spheres.
pub const OTHER: u32 = 1 << 31;

/// The entry of [`Contacts::pair`] for a contact that was read from a file or from a device.
pub const NO_PAIR: u32 = u32::MAX;

/// The partition of the contacts into tiles, the contacts of neighbouring bodies, which are solved in parallel: the tiles of one round
/// have no moving body in common. The second round has the contacts between tiles of the first; the contacts in no tile come last.
#[derive(Clone, Debug, Default)]
pub struct Tiles {
    /// First contact of each tile and of the contacts in no tile, and the end (n_tiles + 2; empty before the first step).
    pub start: Vec<u32>,
    /// Number of tiles of the first round.
    pub n_first: usize,
    /// Where each body lies in columns in which those of a tile are neighbours, in cache lines of their own (n_bodies; empty where it is not
    /// known: columns of `n_places` rows).
    pub place: Vec<u32>,
    /// Length of these columns.
    pub n_places: usize,
}

impl Tiles {
    /// The places of the bodies, or their numbers where these are not known; returns the length of columns by them.
    pub fn places(&self, n_bodies: usize, out: &mut Vec<u32>) -> usize {
        out.clear();
        if self.place.len() == n_bodies {
            out.extend_from_slice(&self.place);
            return self.n_places;
        }
        out.extend(0..n_bodies as u32);
        n_bodies
    }

    /// The tiles of each round: the first contact of each tile, and the end of the last one.
    pub fn rounds(&self) -> [&[u32]; 2] {
        rounds_of(&self.start, self.n_first)
    }

    /// The range of the contacts in no tile.
    pub fn rest(&self) -> Range<u32> {
        rest_of(&self.start)
    }
}

/// The starts of the tiles of each round, and the end of the last one, of starts like those of [`Tiles`].
pub fn rounds_of(start: &[u32], n_first: usize) -> [&[u32]; 2] {
    match start.len() {
        0 => [&[], &[]],
        n => [&start[..=n_first], &start[n_first..n - 1]],
    }
}

/// The range in no tile, of starts like those of [`Tiles`].
pub fn rest_of(start: &[u32]) -> Range<u32> {
    match start[..] {
        [.., first, end] => first..end,
        _ => 0..0,
    }
}

/// Contact arms: from the centres of mass of A and B to the contact point, m, world (n_contacts). The arms of bodies that are held in
/// place are not used.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum Arms {
    /// Arms as vectors on A and B, for any shapes.
    Any(Vec<[DVec3; 2]>),
    /// Lengths of the arms on A and B along the normal, for spheres about their bodies' centres of mass; zero for a body that is held
    /// in place.
    Along(Vec<[f64; 2]>),
}

impl Default for Arms {
    fn default() -> Arms {
        Arms::Any(vec![])
    }
}

impl Contacts {
    /// Have all impulses grow by a factor, as those of a step of another length.
    pub(crate) fn scale(&mut self, factor: f64) {
        if factor != 1.0 {
            let all = [&mut self.impulse, &mut self.rolling_impulse].into_iter().flatten();
            all.for_each(|impulse| *impulse *= factor);
        }
    }

    /// Check that contacts, as a file gives them, are between bodies and shapes of a model with these counts.
    pub(crate) fn fit(&self, n_bodies: usize, n_shapes: usize, n_laws: usize) -> Result<(), String> {
        let (n, rolling) = (self.len(), self.rolling_impulse.len());
        let arms = match &self.arms {
            Arms::Any(arms) => arms.len(),
            Arms::Along(reach) => reach.len(),
        };
        let vectors = [&self.normal, &self.impulse].map(Vec::len);
        let columns = [self.key.len(), arms, self.gap.len(), self.law.len(), vectors[0], vectors[1]];
        if columns.iter().any(|l| *l != n) || (rolling != 0 && rolling != n) {
            return Err("has columns of contacts of different lengths".into());
        }
        let is_sound = |i: usize| {
            let ([a, b], [s, t, _]) = (self.bodies[i], self.key[i]);
            a < b
                && (b as usize) < n_bodies
                && (s.max(t) as usize) < n_shapes
                && (self.law[i] as usize) < n_laws
                && self.normal[i].is_normalized()
                && self.impulse[i].is_finite()
        };
        match (0..n).find(|i| !is_sound(*i)) {
            Some(i) => Err(format!("has a contact {i} of no bodies of the model")),
            None => Ok(()),
        }
    }

    /// The arms of contact `i` on A and B, m, world.
    #[inline]
    pub fn arms(&self, i: usize) -> [DVec3; 2] {
        match &self.arms {
            Arms::Any(arms) => arms[i],
            Arms::Along(reach) => [self.normal[i] * reach[i][0], self.normal[i] * -reach[i][1]],
        }
    }

    /// Add contact `i` of other contacts, between the bodies, with the key and the law of this model, its impulses times `factor`. The
    /// arms are vectors.
    pub fn carry(&mut self, from: &Contacts, i: usize, bodies: [u32; 2], key: [u32; 3], law: u32, factor: f64) {
        let Arms::Any(arms) = &mut self.arms else { unreachable!("carried contacts have arms as vectors") };
        arms.push(from.arms(i));
        self.push(from, i, (bodies, key, law), factor);
        self.rolling_impulse.push(from.rolling_impulse.get(i).map_or(DVec3::ZERO, |roll| *roll * factor));
    }

    /// Add contact `i` of other contacts of the same model.
    pub fn push_of(&mut self, from: &Contacts, i: usize) {
        if self.is_empty() {
            self.arms = match from.arms {
                Arms::Any(_) => Arms::Any(vec![]),
                Arms::Along(_) => Arms::Along(vec![]),
            };
        }
        let ([arm_a, arm_b], normal) = (from.arms(i), from.normal[i]);
        match &mut self.arms {
            Arms::Any(arms) => arms.push([arm_a, arm_b]),
            Arms::Along(reach) => reach.push([arm_a.dot(normal), -arm_b.dot(normal)]),
        }
        self.push(from, i, (from.bodies[i], from.key[i], from.law[i]), 1.0);
        self.rolling_impulse.extend(from.rolling_impulse.get(i));
    }

    /// Add contact `i` of other contacts but for its arms and its rolling impulse.
    fn push(&mut self, from: &Contacts, i: usize, (bodies, key, law): ([u32; 2], [u32; 3], u32), factor: f64) {
        self.bodies.push(bodies);
        self.key.push(key);
        self.pair.push(NO_PAIR);
        self.normal.push(from.normal[i]);
        self.gap.push(from.gap[i]);
        self.law.push(law);
        self.impulse.push(from.impulse[i] * factor);
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Maximum penetration, m; zero where nothing overlaps.
    pub fn worst_penetration(&self) -> f64 {
        self.gap.iter().fold(0.0, |worst: f64, gap| worst.max(-gap))
    }

    /// The multipliers γ = (γ_n, γ_u, γ_w) of contact `i`, N s, in the contact frame A_p = [n u w] of the normal n and two tangents.
    pub fn gamma(&self, i: usize) -> DVec3 {
        let (u, w) = tangents(self.normal[i]);
        DVec3::new(self.impulse[i].dot(self.normal[i]), self.impulse[i].dot(u), self.impulse[i].dot(w))
    }

    /// The velocity of B relative to A at contact `i`, m/s, world; `of` returns the velocity of a body by its id.
    pub fn velocity(&self, i: usize, of: impl Fn(usize) -> Twist) -> DVec3 {
        let [a, b] = self.bodies[i].map(|b| of(b as usize));
        let [arm_a, arm_b] = self.arms(i);
        b.v + b.w.cross(arm_b) - a.v - a.w.cross(arm_a)
    }
}

/// Tangents u and w of the contact frame A_p = [n u w] of a unit normal (Duff et al. 2017), discontinuous at n_z = 0 alone.
#[inline]
pub fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}
