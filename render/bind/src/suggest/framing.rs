//! Framing of a whole animation: the box that its things are in, and a camera that sees it.

use super::survey::{Survey, Thing};
use crate::metadata::CameraSpec;
use glam::Vec3;
use std::collections::BTreeMap;

/// Number of alike rows of a frame from which on the outermost of them are strays.
const MANY: usize = 30;

/// Share of alike rows that are strays on each side of each axis.
const STRAYS: f32 = 0.03;

/// The box of all frames; none if no row has a finite position. Terrain is looked at only where there is nothing else.
pub(super) fn extent(surveys: &[Survey<'_>]) -> Option<[Vec3; 2]> {
    let around = |of: for<'a> fn(&'a Survey<'_>) -> &'a [Thing]| {
        let boxes = surveys.iter().filter_map(|survey| without_strays(of(survey)));
        boxes.reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)])
    };
    around(|survey| &survey.things).or_else(|| around(|survey| &survey.terrain))
}

/// Classes whose box has a large part of the grains in it, as a drum or a hopper has: opaque, they would hide what they hold.
pub(super) fn containers<'a>(surveys: &[Survey<'a>]) -> Vec<&'a str> {
    /// Share of the grains in a container.
    const HELD: f32 = 0.3;
    let mut found = vec![];
    for survey in surveys.iter().filter(|survey| !survey.classes.is_empty()) {
        let mut classes: BTreeMap<u32, Vec<&Thing>> = BTreeMap::new();
        survey.things.iter().for_each(|thing| classes.entry(thing.class).or_default().push(thing));
        let (grains, others): (Vec<_>, Vec<_>) = classes.into_iter().partition(|(_, things)| things.len() >= MANY);
        let grains: Vec<Vec3> = grains.iter().flat_map(|(_, grains)| grains.iter().map(|g| g.center())).collect();
        for (class, things) in others {
            let lo = things.iter().map(|t| t.lo).fold(Vec3::INFINITY, Vec3::min);
            let hi = things.iter().map(|t| t.hi).fold(Vec3::NEG_INFINITY, Vec3::max);
            let n_inside = grains.iter().filter(|g| g.cmpgt(lo).all() && g.cmplt(hi).all()).count();
            let name = survey.classes[class as usize].as_str();
            if !grains.is_empty() && n_inside as f32 > HELD * grains.len() as f32 && !found.contains(&name) {
                found.push(name);
            }
        }
    }
    found
}

/// A machine that is small in what is seen of the whole, and moves: the camera goes with it.
pub(super) struct Subject<'a> {
    /// Class of its largest body, which every frame has.
    pub(super) class: &'a str,
    /// The box to show, from the mean position of that class, m.
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
}

/// The box of a class in a frame, the mean of its rows' places, and its largest half length, m.
#[derive(Clone, Copy)]
struct ClassBox {
    lo: Vec3,
    hi: Vec3,
    mean: Vec3,
    size: f32,
}

/// The boxes of the classes of a frame that have few rows, but for containers.
fn machines<'a>(survey: &Survey<'a>, containers: &[&str]) -> BTreeMap<&'a str, ClassBox> {
    let mut classes: BTreeMap<u32, Vec<&Thing>> = BTreeMap::new();
    survey.things.iter().for_each(|thing| classes.entry(thing.class).or_default().push(thing));
    let named = classes.into_iter().filter_map(|(class, things)| {
        let name = survey.classes.get(class as usize)?.as_str();
        let is_machine = things.len() < MANY && !containers.contains(&name);
        is_machine.then(|| {
            let lo = things.iter().map(|t| t.lo).fold(Vec3::INFINITY, Vec3::min);
            let hi = things.iter().map(|t| t.hi).fold(Vec3::NEG_INFINITY, Vec3::max);
            let mean = things.iter().map(|t| t.center()).sum::<Vec3>() / things.len() as f32;
            (name, ClassBox { lo, hi, mean, size: things.iter().map(|t| t.size).fold(0.0, f32::max) })
        })
    });
    named.collect()
}

/// The machine of an animation whose extent is `lo` to `hi`, if a camera that saw all would show it as a few pixels.
pub(super) fn subject<'a>(surveys: &[Survey<'a>], containers: &[&str], [lo, hi]: [Vec3; 2]) -> Option<Subject<'a>> {
    /// Largest diagonal of such a machine over that of the whole.
    const SMALL: f32 = 0.06;
    /// What is shown over the machine's size.
    const CONTEXT: f32 = 4.0;
    let frames: Vec<_> = surveys.iter().map(|survey| machines(survey, containers)).collect();
    let moves = |name: &str, first: &ClassBox| {
        frames.iter().filter_map(|f| f.get(name)).any(|b| b.mean.distance(first.mean) > 0.5 * first.size)
    };
    let first = frames.first()?;
    let moving: BTreeMap<_, _> = first.iter().filter(|(name, b)| moves(name, b)).collect();
    let (class, _) = moving
        .iter()
        .filter(|(name, _)| frames.iter().all(|f| f.contains_key(**name)))
        .max_by(|a, b| a.1.size.total_cmp(&b.1.size))?;
    // The machine as seen from its largest body.
    let boxes = frames.iter().flat_map(|f| {
        let from = f[*class].mean;
        f.iter().filter(|(name, _)| moving.contains_key(name)).map(move |(_, b)| [b.lo - from, b.hi - from])
    });
    let [a, b] = boxes.reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)])?;
    let (center, half) = (0.5 * (a + b), 0.5 * CONTEXT * (b - a));
    (a.distance(b) < SMALL * lo.distance(hi)).then_some(Subject { class, lo: center - half, hi: center + half })
}

/// Radius of spheres that stand for points: half the usual distance of a point to the nearest other, m. None where all are in one
/// place.
pub(super) fn radius_by_spacing(surveys: &[Survey<'_>]) -> Option<f32> {
    /// Distances to compute in all.
    const WORK: usize = 1 << 26;
    /// Largest radius over the diagonal of the box, for few points.
    const MAX: f32 = 0.04;
    let things = &surveys.iter().max_by_key(|survey| survey.things.len())?.things;
    let n = (WORK / things.len().max(1)).clamp(16, 512).min(things.len());
    let nearest = |at: usize| {
        let center = things[at].center();
        let distances = things.iter().map(|other| other.center().distance_squared(center));
        // Points in the same place are parts of one body, or doubled.
        distances.filter(|d| *d > 0.0).min_by(f32::total_cmp)
    };
    let mut spacings: Vec<f32> = (0..n).filter_map(|k| nearest(k * things.len() / n)).collect();
    spacings.sort_by(f32::total_cmp);
    let usual = spacings.get(spacings.len() / 2)?.sqrt();
    let [lo, hi] = extent(surveys)?;
    Some((0.5 * usual).min(MAX * lo.distance(hi)))
}

/// The box around things, without the outermost of many alike, as stray grains are. What is larger than most of its class is never
/// left out, nor is a class of few: a vehicle among stones is no stray.
fn without_strays(things: &[Thing]) -> Option<[Vec3; 2]> {
    let mut sizes: BTreeMap<u32, Vec<f32>> = BTreeMap::new();
    things.iter().for_each(|t| sizes.entry(t.class).or_default().push(t.size));
    let median = |sizes: &mut Vec<f32>| {
        let half = sizes.len() / 2;
        *sizes.select_nth_unstable_by(half, f32::total_cmp).1
    };
    let limit: BTreeMap<u32, f32> =
        sizes.iter_mut().filter(|(_, s)| s.len() >= MANY).map(|(class, s)| (*class, 2.0 * median(s))).collect();
    let is_one_of_many = |t: &&Thing| limit.get(&t.class).is_some_and(|limit| t.size <= *limit);
    let (grains, others): (Vec<&Thing>, Vec<&Thing>) = things.iter().partition(is_one_of_many);
    let around = |things: &[&Thing]| {
        let lo = things.iter().map(|t| t.lo).reduce(Vec3::min)?;
        Some([lo, things.iter().map(|t| t.hi).reduce(Vec3::max)?])
    };
    let skip = (grains.len() as f32 * STRAYS) as usize;
    let core = (!grains.is_empty()).then(|| {
        let nth = |end: &dyn Fn(&Thing) -> f32, k: usize| {
            let mut ends: Vec<f32> = grains.iter().map(|t| end(t)).collect();
            *ends.select_nth_unstable_by(k, f32::total_cmp).1
        };
        let last = grains.len() - 1 - skip;
        let corner = |end: &dyn Fn(&Thing) -> Vec3, k: usize| {
            Vec3::new(nth(&|t| end(t).x, k), nth(&|t| end(t).y, k), nth(&|t| end(t).z, k))
        };
        [corner(&|t| t.lo, skip), corner(&|t| t.hi, last)]
    });
    match (core, around(&others)) {
        (Some([lo, hi]), Some([a, b])) => Some([lo.min(a), hi.max(b)]),
        (core, others) => core.or(others),
    }
}

/// A camera from the front, a little to the side and above, near enough that the box fills the image.
pub(super) fn camera(lo: Vec3, hi: Vec3) -> CameraSpec {
    /// Share of the image that the box may fill.
    const FILL: f32 = 0.8;
    let center = 0.5 * (lo + hi);
    let fov = 35.0f32;
    let back = Vec3::new(-0.45, -1.0, 0.5).normalize();
    let right = back.cross(Vec3::Z).normalize() * -1.0;
    let up = back.cross(right);
    let half_height = (fov.to_radians() * 0.5).tan() * FILL;
    let half_width = half_height * 16.0 / 9.0;
    let corner = |k: usize| Vec3::new([lo.x, hi.x][k & 1], [lo.y, hi.y][k >> 1 & 1], [lo.z, hi.z][k >> 2]) - center;
    // A corner at depth d + p·back is in the image if its offset is at most this share of that depth.
    let needed = |p: Vec3| p.dot(back) + (p.dot(up).abs() / half_height).max(p.dot(right).abs() / half_width);
    let distance = (0..8).map(|k| needed(corner(k))).fold(1e-3, f32::max);
    let eye = center + back * distance;
    // To a thousandth of the distance.
    let step = 10f64.powf((distance as f64).log10().floor() - 3.0);
    let on_grid = |x: f32| ((x as f64 / step).round() * step) as f32;
    CameraSpec {
        eye: Some(eye.to_array().map(on_grid)),
        look_at: Some(center.to_array().map(on_grid)),
        up: [0.0, 0.0, 1.0],
        fov,
        ..CameraSpec::default()
    }
}

/// Four figures are enough for a start.
pub(super) fn rounded(x: f32) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thing(at: [f32; 3], size: f32, class: u32) -> Thing {
        let at = Vec3::from_array(at);
        Thing { lo: at - size, hi: at + size, size, class }
    }

    #[test]
    fn strays_are_of_many_alike() {
        let mut things: Vec<Thing> = (0..1500).map(|k| thing([(k % 50) as f32 * 0.1, 0.0, 0.0], 0.05, 0)).collect();
        // Two stones that were thrown far away.
        things.push(thing([80.0, 0.0, 0.0], 0.05, 0));
        things.push(thing([-70.0, 0.0, 0.0], 0.04, 0));
        let [lo, hi] = without_strays(&things).unwrap();
        assert!(lo.x > -1.0 && hi.x < 6.0, "{lo} {hi}");
        // A vehicle at the side, in a class of its own or among the stones' rows, is seen.
        for class in [0, 1] {
            things.push(thing([12.0, 0.0, 0.0], 0.8, class));
            let [_, hi] = without_strays(&things).unwrap();
            assert!((hi.x - 12.8).abs() < 1e-5, "{hi}");
            things.pop();
        }
    }
}
