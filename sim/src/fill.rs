//! Packings of spheres in a region, repeatable by their seed.

use glam::DVec3;

/// The splitmix64 pseudo-random generator (Steele, Lea, Flood 2014): the same sequence for a seed on every machine.
pub struct SplitMix64(
    /// State of the generator; at the start the seed.
    pub u64,
);

impl SplitMix64 {
    /// The next number, uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 * 2f64.powi(-53)
    }

    /// The next number, uniform in [lo, hi).
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.uniform()
    }

    /// The next whole number, uniform below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }

    /// A random rotation, uniform over SO(3).
    pub fn rotation(&mut self) -> glam::DQuat {
        let (u, v, w) =
            (self.uniform(), self.between(0.0, std::f64::consts::TAU), self.between(0.0, std::f64::consts::TAU));
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        glam::DQuat::from_xyzw(a * v.cos(), b * w.sin(), b * w.cos(), a * v.sin()).normalize()
    }
}

/// A region to fill: a box, or the part of it within a vertical cylinder about its middle.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Minimum corner, m.
    pub min: DVec3,
    /// Maximum corner, m.
    pub max: DVec3,
    /// Radius of the cylinder, m.
    pub within: Option<f64>,
}

impl Region {
    /// Whether spheres of a radius, m, have more sites here than are tried one by one.
    pub fn has_too_many_sites(&self, radius: f64) -> bool {
        (self.max - self.min).element_product() / radius.powi(3) > MAX_SITES
    }

    /// Whether a sphere at a position lies inside the region.
    fn contains(&self, p: DVec3, radius: f64) -> bool {
        let inside = (p - radius).cmpge(self.min - 1e-12).all() && (p + radius).cmple(self.max + 1e-12).all();
        let middle = 0.5 * (self.min + self.max);
        inside && self.within.is_none_or(|r| (p - middle).truncate().length() + radius <= r + 1e-12)
    }
}

/// Whether spheres of a lattice lie at one side of their region: they are less than half of its lowest layer.
pub fn is_one_sided(sites: &[DVec3], region: &Region) -> bool {
    /// Number of spheres below which it hardly matters.
    const MANY: usize = 20;
    let (lo, hi) = sites.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    let (covered, extent) = (hi - lo, region.max - region.min);
    sites.len() >= MANY && covered.z < 0.5 * covered.truncate().max_element() && covered.y < 0.5 * extent.y
}

/// The number of spheres of a fill.
#[derive(Clone, Copy, Debug)]
pub enum Count {
    /// A given number; a fill with fewer sites returns `Err` with the number that fits.
    Exactly(usize),
    /// The number that fits.
    AllThatFit,
}

impl Count {
    fn take(self, sites: Vec<DVec3>) -> Result<Vec<DVec3>, usize> {
        match self {
            Count::AllThatFit => Ok(sites),
            Count::Exactly(n) if n <= sites.len() => Ok(sites[..n].to_vec()),
            Count::Exactly(_) => Err(sites.len()),
        }
    }
}

/// Limit of the number of sites.
const MAX_SITES: f64 = 5e7;

/// Centres of spheres of at most `radius`, m: a cubic lattice from the bottom up with a random jitter of each site, too small for
/// spheres to overlap.
pub fn lattice(region: &Region, radius: f64, count: Count, random: &mut SplitMix64) -> Result<Vec<DVec3>, usize> {
    const SLACK: f64 = 0.1;
    let cell = 2.0 * radius * (1.0 + SLACK);
    let extent = region.max - region.min;
    let n = (extent / cell + 1e-9).floor().max(DVec3::ZERO);
    let free = extent - n * cell;
    let max = match count {
        Count::Exactly(max) => max,
        Count::AllThatFit => usize::MAX,
    };
    let (nx, ny, nz) = (n.x as u64, n.y as u64, n.z as u64);
    let mut sites = vec![];
    let jitter = radius * SLACK;
    let all = if n.element_product() > MAX_SITES { MAX_SITES as u64 } else { nx * ny * nz };
    for i in 0..all {
        if sites.len() >= max {
            break;
        }
        let site = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / (nx * ny)) as f64);
        let centre = region.min + DVec3::new(free.x, free.y, 0.0) * 0.5 + (site + 0.5) * cell;
        let mut shift = || random.between(-jitter, jitter);
        let shift = DVec3::new(shift(), shift(), shift());
        if region.within.is_none() || region.contains(centre, radius + jitter) {
            sites.push(centre + shift);
        }
    }
    if sites.len() < max && matches!(count, Count::Exactly(_)) { Err(sites.len()) } else { Ok(sites) }
}

/// Centres of spheres in hexagonal layers, ABAB, from the bottom up, m: the densest packing of equal spheres, with gaps of a
/// millionth of their diameter.
pub fn hexagonal(region: &Region, radius: f64, count: Count) -> Result<Vec<DVec3>, usize> {
    let d = 2.0 * radius * (1.0 + 1e-6);
    let (row, layer) = (d * 0.75f64.sqrt(), d * (2.0f64 / 3.0).sqrt());
    let extent = region.max - region.min;
    let n = DVec3::new(extent.x / d, extent.y / row, extent.z / layer).floor() + 1.0;
    let mut sites = vec![];
    if n.element_product() > MAX_SITES {
        return Err(0);
    }
    for k in 0..n.z as u64 {
        for j in 0..n.y as u64 {
            for i in 0..n.x as u64 {
                let shift = DVec3::new(
                    if (j + k) % 2 == 1 { 0.5 * d } else { 0.0 },
                    if k % 2 == 1 { row / 3.0 } else { 0.0 },
                    0.0,
                );
                let p = region.min + radius + shift + DVec3::new(i as f64 * d, j as f64 * row, k as f64 * layer);
                if region.contains(p, radius) {
                    sites.push(p);
                }
            }
        }
    }
    count.take(sites)
}

/// Random centres of spheres at distances of at least two radii, m: Poisson-disk sampling in three dimensions (Bridson 2007).
pub fn poisson_disk(region: &Region, radius: f64, count: Count, random: &mut SplitMix64) -> Result<Vec<DVec3>, usize> {
    const TRIES: usize = 30;
    let d = 2.0 * radius * (1.0 + 1e-9);
    let cell = d / 3f64.sqrt();
    let extent = region.max - region.min;
    let n = (extent / cell).ceil().max(DVec3::ONE);
    if n.element_product() > MAX_SITES || extent.min_element() < 2.0 * radius {
        return Err(0);
    }
    let n = n.as_usizevec3();
    let mut grid = vec![u32::MAX; n.x * n.y * n.z];
    let bin = |p: DVec3| ((p - region.min) / cell).as_usizevec3().min(n - 1);
    let mut sites: Vec<DVec3> = vec![];
    let mut open: Vec<u32> = vec![];
    let try_place = |p: DVec3, sites: &mut Vec<DVec3>, grid: &mut Vec<u32>| {
        if !region.contains(p, radius) {
            return false;
        }
        let here = bin(p);
        let (lo, hi) = (here.saturating_sub(glam::USizeVec3::splat(2)), (here + 2).min(n - 1));
        for z in lo.z..=hi.z {
            for y in lo.y..=hi.y {
                for x in lo.x..=hi.x {
                    let other = grid[x + n.x * (y + n.y * z)];
                    if other != u32::MAX && (sites[other as usize] - p).length_squared() < d * d {
                        return false;
                    }
                }
            }
        }
        grid[here.x + n.x * (here.y + n.y * here.z)] = sites.len() as u32;
        sites.push(p);
        true
    };
    for _ in 0..10_000 {
        let p = DVec3::new(
            random.between(region.min.x, region.max.x),
            random.between(region.min.y, region.max.y),
            random.between(region.min.z, region.max.z),
        );
        if try_place(p, &mut sites, &mut grid) {
            open.push(0);
            break;
        }
    }
    while let Some(&k) = open.last() {
        let from = sites[k as usize];
        let mut found = false;
        for _ in 0..TRIES {
            let way = random.rotation() * DVec3::Z;
            let p = from + way * random.between(d, 1.6 * d);
            if try_place(p, &mut sites, &mut grid) {
                open.push(sites.len() as u32 - 1);
                found = true;
                break;
            }
        }
        if !found {
            open.pop();
        }
    }
    // From the bottom up, so that a smaller number fills the lower part of the region.
    sites.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y)));
    count.take(sites)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fills_keep_spheres_apart_and_inside() {
        let region = Region { min: DVec3::ZERO, max: DVec3::new(1.0, 0.8, 0.6), within: Some(0.38) };
        let radius = 0.03;
        let fills = [
            lattice(&region, radius, Count::AllThatFit, &mut SplitMix64(1)).unwrap(),
            hexagonal(&region, radius, Count::AllThatFit).unwrap(),
            poisson_disk(&region, radius, Count::AllThatFit, &mut SplitMix64(2)).unwrap(),
        ];
        for sites in &fills {
            assert!(sites.len() > 400, "{}", sites.len());
            for (i, p) in sites.iter().enumerate() {
                assert!(region.contains(*p, radius));
                assert!(sites[..i].iter().all(|q| (*p - *q).length() >= 2.0 * radius));
            }
        }
        assert!(fills[1].len() > fills[0].len() && fills[0].len() > fills[2].len());
        assert_eq!(hexagonal(&region, radius, Count::Exactly(1_000_000)).unwrap_err(), fills[1].len());
    }
}
