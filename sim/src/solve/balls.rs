//! Gauss–Seidel on contacts with friction alone between balls, four at a time.
//!
//! A ball's contact arm lies along the normal, so that `D_iᵀ v = v_b − v_a − (r_a ω_a + r_b ω_b) × n`, and N_ii is diagonal in the
//! contact's frame: a for the normal, b for the tangents. The block's problem is then a projection in the metric (a, b, b): in
//! tangents stretched by √(b/a) it is the projection onto the cone of μ√(b/a). All that a visit needs is laid out once a solve,
//! colour by colour, in groups of four contacts that share no body; a visit streams through it.

use super::bodies::BodyOperator;
use super::lanes::{LANES, Lane, Lane3, angular, each, linear, project};
use super::{Cells, Twist};
use glam::DVec3;

/// Four contacts of one colour.
#[derive(Clone, Copy, Default)]
pub struct Group {
    bodies: [[u32; 2]; LANES],
    normal: Lane3,
    gamma: Lane3,
    radius: [Lane; 2],
    inv_mass: [Lane; 2],
    /// Radius times reciprocal moment of inertia.
    lever: [Lane; 2],
    offset: Lane,
    /// 1/a and 1/b.
    along: Lane,
    across: Lane,
    stretch: Lane,
    /// μ times the stretch.
    friction: Lane,
    /// 1/η.
    trace: Lane,
}

/// All contacts by colours.
#[derive(Default)]
pub struct Packed {
    groups: Vec<Group>,
    /// First group of each colour (n_colors + 1).
    start: Vec<usize>,
}

impl Packed {
    /// Lay out the contacts; `start` and `order` are the colours.
    pub fn fill(&mut self, op: &BodyOperator, start: &[u32], order: &[u32], gamma: &[DVec3]) {
        self.groups.clear();
        self.start.clear();
        for ends in start.windows(2) {
            self.start.push(self.groups.len());
            for some in order[ends[0] as usize..ends[1] as usize].chunks(LANES) {
                // What a colour's last group has no contact for does nothing.
                let mut group = Group { stretch: [1.0; LANES], ..Group::default() };
                some.iter().enumerate().for_each(|(l, i)| group.put(l, op, *i as usize, gamma[*i as usize]));
                self.groups.push(group);
            }
        }
        self.start.push(self.groups.len());
    }

    /// The groups of each colour.
    pub fn colors(&mut self) -> impl Iterator<Item = &mut [Group]> {
        let mut rest = &mut self.groups[..];
        self.start.windows(2).map(move |ends| {
            let (color, after) = std::mem::take(&mut rest).split_at_mut(ends[1] - ends[0]);
            rest = after;
            color
        })
    }

    /// Read the impulses back.
    pub fn unpack(&self, start: &[u32], order: &[u32], gamma: &mut [DVec3]) {
        for (color, ends) in start.windows(2).enumerate() {
            for (k, i) in order[ends[0] as usize..ends[1] as usize].iter().enumerate() {
                let group = &self.groups[self.start[color] + k / LANES];
                let l = k % LANES;
                gamma[*i as usize] = DVec3::new(group.gamma.x[l], group.gamma.y[l], group.gamma.z[l]);
            }
        }
    }
}

impl Group {
    fn put(&mut self, l: usize, op: &BodyOperator, i: usize, gamma: DVec3) {
        let (c, masses) = (op.contacts, op.masses);
        let n = c.normal[i];
        let reach = [c.arm_a[i].dot(n), -c.arm_b[i].dot(n)];
        self.bodies[l] = c.bodies[i];
        let (mut a, mut b) = (0.0, 0.0);
        for side in 0..2 {
            let body = c.bodies[i][side] as usize;
            let (m, j) = (masses.inv_mass[body], masses.round[body]);
            // A body that is held in place has no ball's arm, and needs none.
            let r = if m > 0.0 { reach[side] } else { 0.0 };
            (self.inv_mass[side][l], self.radius[side][l], self.lever[side][l]) = (m, r, r * j);
            a += m;
            b += m + r * r * j;
        }
        let set = |v: &mut Lane3, x: DVec3| (v.x[l], v.y[l], v.z[l]) = (x.x, x.y, x.z);
        set(&mut self.normal, n);
        set(&mut self.gamma, gamma);
        self.offset[l] = op.offset[i];
        (self.along[l], self.across[l], self.stretch[l]) = (1.0 / a, 1.0 / b, (b / a).sqrt());
        self.friction[l] = op.friction[i] * self.stretch[l];
        self.trace[l] = 1.0 / op.eta[i];
    }
}

/// Visit groups of one colour; returns the sum of `|Δγ/η|²`.
pub fn visit(groups: &mut [Group], image: &Cells<Twist>, omega: f64) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { visit_avx2(groups, image, omega) };
    }
    visit_lanes(groups, image, omega)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn visit_avx2(groups: &mut [Group], image: &Cells<Twist>, omega: f64) -> f64 {
    visit_lanes(groups, image, omega)
}

#[inline(always)]
fn visit_lanes(groups: &mut [Group], image: &Cells<Twist>, omega: f64) -> f64 {
    let mut missed = [0.0; LANES];
    for g in groups {
        let side = |s: usize| {
            let b = |l: usize| image.get(g.bodies[l][s] as usize);
            [b(0), b(1), b(2), b(3)]
        };
        let (ta, tb) = (side(0), side(1));
        let (ta, tb) = ([&ta[0], &ta[1], &ta[2], &ta[3]], [&tb[0], &tb[1], &tb[2], &tb[3]]);
        let n = g.normal;
        let (va, wa, vb, wb) = (linear(ta), angular(ta), linear(tb), angular(tb));
        let rolling = wa.times(g.radius[0]).plus(wb.times(g.radius[1])).cross(n);
        let v = vb.minus(va).minus(rolling);
        let v_n = v.dot(n);
        let before_n = g.gamma.dot(n);
        let normal = each(|l| before_n[l] - (v_n[l] + g.offset[l]) * g.along[l]);
        let tangent = g.gamma.minus(n.times(before_n)).minus(v.minus(n.times(v_n)).times(g.across));
        let z = project(n.times(normal).plus(tangent.times(g.stretch)), n, g.friction);
        let kept = z.dot(n);
        let along = n.times(kept);
        let z = along.plus(z.minus(along).times(each(|l| 1.0 / g.stretch[l])));
        let d = z.minus(g.gamma).times([omega; LANES]);
        g.gamma = g.gamma.plus(d);
        let spin = n.cross(d);
        let (va, vb) = (va.minus(d.times(g.inv_mass[0])), vb.plus(d.times(g.inv_mass[1])));
        let (wa, wb) = (wa.minus(spin.times(g.lever[0])), wb.minus(spin.times(g.lever[1])));
        for l in 0..LANES {
            let at = |v: &Lane3| DVec3::new(v.x[l], v.y[l], v.z[l]);
            if g.inv_mass[0][l] > 0.0 {
                image.set(g.bodies[l][0] as usize, Twist { v: at(&va), w: at(&wa) });
            }
            if g.inv_mass[1][l] > 0.0 {
                image.set(g.bodies[l][1] as usize, Twist { v: at(&vb), w: at(&wb) });
            }
        }
        let square = d.dot(d);
        for l in 0..LANES {
            missed[l] += square[l] * g.trace[l] * g.trace[l];
        }
    }
    missed.iter().sum()
}
