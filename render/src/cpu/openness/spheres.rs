//! Spheres and ellipsoids as they close cones: those within some radii of a point.

use crate::cpu::openness::cones::{Cap, Cones, Packed, Tint, axes, smooth};
use crate::cpu::tree::Tree;
use crate::scene::shape::Shape;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::{Mat4, Vec3};
use sl::machine::OpenPlace;

/// Radii from a sphere's middle at which it no longer counts, and from which on it fades.
const REACH: f32 = 5.0;
const FADES: f32 = 3.0;

/// The depth of a sphere's middle under the plane of a surface, in radii, from which on it does not count: what touches that from below, as
/// the round end of a tube does, is not over it, but for rounding.
const TOUCHED: f32 = 0.9999;

/// A sphere, or an ellipsoid by its half axes.
#[derive(Clone, Copy)]
pub struct Round {
    pub item: Item,
    pub center: Vec3,
    pub radius: f32,
    /// Index of the axes of an ellipsoid.
    pub axes: Option<u32>,
    pub color: Packed,
}

/// All of a scene.
pub struct Spheres {
    pub tree: Tree,
    pub rounds: Vec<Round>,
    /// Half axes, world space.
    pub axes: Vec<[Vec3; 3]>,
}

/// Those near some places, in a fixed order.
pub struct Near<'a> {
    all: &'a Spheres,
    rounds: Vec<Round>,
}

impl Spheres {
    /// Of some items of a scene.
    pub fn new(scene: &Scene, items: &[Item]) -> Spheres {
        let (mut rounds, mut axes) = (vec![], vec![]);
        for item in items {
            let (shape, to_world) = scene.place(*item);
            if let Shape::Sphere = shape {
                let own = half_axes(to_world);
                let lengths = own.map(Vec3::length);
                let radius = lengths.into_iter().fold(0.0, f32::max);
                let even = lengths.iter().all(|length| (length - radius).abs() <= 1e-4 * radius);
                let center = to_world.w_axis.truncate();
                if radius > 0.0 && radius.is_finite() && center.is_finite() {
                    let (axes_at, color) = ((!even).then_some(axes.len() as u32), Packed::new(scene.view(*item).color));
                    rounds.push(Round { item: *item, center, radius, axes: axes_at, color });
                    axes.extend((!even).then_some(own));
                }
            }
        }
        let reach = |round: &Round| (round.center - REACH * round.radius, round.center + REACH * round.radius);
        let (tree, order) = Tree::alone(rounds.iter().map(reach));
        let rounds = order.iter().map(|k| rounds[*k as usize]).collect();
        Spheres { tree, rounds, axes }
    }

    /// Those that may count at some places on an item, but for the item itself.
    pub fn near(&self, own: Item, places: &[OpenPlace]) -> Near<'_> {
        let box_of = |(lo, hi): (Vec3, Vec3), p: &OpenPlace| (lo.min(p.at.into()), hi.max(p.at.into()));
        let (lo, hi) = places.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), box_of);
        let middle = 0.5 * (lo + hi);
        let half = 0.5 * (hi - lo).length();
        let mut rounds = vec![];
        self.tree.meeting(lo, hi, |leaf| {
            let counts = |r: &&Round| r.item != own && (r.center - middle).length() < REACH * r.radius + half;
            rounds.extend(self.rounds[leaf].iter().filter(counts));
        });
        Near { all: self, rounds }
    }
}

fn half_axes(m: Mat4) -> [Vec3; 3] {
    [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate())
}

impl Near<'_> {
    /// Close the cones of a point, and add the colours of what does.
    pub fn close(&self, at: Vec3, normal: Vec3, open: &mut Cones, tint: &mut Tint) {
        let cones = axes();
        for round in &self.rounds {
            let to = round.center - at;
            let (d2, r) = (to.length_squared(), round.radius);
            if d2 >= REACH * REACH * r * r || to.dot(normal) <= -TOUCHED * r {
                continue;
            }
            let d = d2.sqrt();
            let way = to / d.max(1e-30);
            let r2 = round.axes.map_or(r * r, |k| silhouette2(&self.all.axes[k as usize], way));
            let fade = 1.0 - smooth(((d / r - FADES) / (REACH - FADES)).clamp(0.0, 1.0));
            let sin2 = (r2 / d2.max(1e-30)).min(1.0);
            tint.add(round.color, fade * sin2 * way.dot(normal).max(0.0));
            let covers = Cap::new(way, sin2, fade).covers(cones);
            open.0.iter_mut().zip(covers).for_each(|(open, cover)| *open *= 1.0 - cover);
        }
    }
}

/// The radius squared of the disc that has the area of an ellipsoid's silhouette from a direction.
fn silhouette2([a, b, c]: &[Vec3; 3], way: Vec3) -> f32 {
    [a.cross(*b), b.cross(*c), c.cross(*a)].map(|n| n.dot(way).powi(2)).iter().sum::<f32>().sqrt()
}
