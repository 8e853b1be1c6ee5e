//! Seeded, repeatable fills of a region with spheres.

use glam::DVec3;

/// The splitmix64 generator: the same numbers from the same seed everywhere.
pub struct SplitMix64(pub u64);

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

    /// A number between two others.
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.uniform()
    }

    /// A rotation, uniform among all.
    pub fn rotation(&mut self) -> glam::DQuat {
        let (u, v, w) =
            (self.uniform(), self.between(0.0, std::f64::consts::TAU), self.between(0.0, std::f64::consts::TAU));
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        glam::DQuat::from_xyzw(a * v.cos(), b * w.sin(), b * w.cos(), a * v.sin()).normalize()
    }
}

/// Places for `count` spheres of at most `radius` between two corners: a lattice from the bottom up, each site moved at random
/// within what keeps the spheres apart. `Err` is the number that fits.
pub fn lattice(
    min: DVec3,
    max: DVec3,
    radius: f64,
    count: usize,
    random: &mut SplitMix64,
) -> Result<Vec<DVec3>, usize> {
    const SLACK: f64 = 0.1;
    let cell = 2.0 * radius * (1.0 + SLACK);
    let n = ((max - min) / cell).floor().max(DVec3::ZERO).as_u64vec3();
    let fits = n.x.saturating_mul(n.y).saturating_mul(n.z) as usize;
    if fits < count {
        return Err(fits);
    }
    let free = (max - min) - n.as_dvec3() * cell;
    let jitter = radius * SLACK;
    Ok((0..count as u64)
        .map(|i| {
            let site = glam::U64Vec3::new(i % n.x, i / n.x % n.y, i / (n.x * n.y)).as_dvec3();
            let shift = DVec3::new(
                random.between(-jitter, jitter),
                random.between(-jitter, jitter),
                random.between(-jitter, jitter),
            );
            min + DVec3::new(free.x, free.y, 0.0) * 0.5 + (site + 0.5) * cell + shift
        })
        .collect())
}
