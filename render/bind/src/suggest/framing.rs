//! Framing of a whole animation: the box that its things are in, and a camera that sees it.

use super::inside::Points;
use super::survey::{Survey, Thing};
use crate::metadata::CameraSpec;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Number of alike bodies of a frame from which on they are grains, and the outermost of them are strays.
pub(super) const MANY: usize = 30;

/// Share of alike rows that may be strays on each side of each axis.
const STRAYS: f32 = 0.03;

/// What they stick out by, over the extent of the others, from which on they are: the top of a pyramid is none.
const FAR: f32 = 0.25;

/// The box around boxes; none if there are none.
fn union(boxes: impl Iterator<Item = [Vec3; 2]>) -> Option<[Vec3; 2]> {
    boxes.reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)])
}

/// The box around things.
fn around<'a>(things: impl IntoIterator<Item = &'a Thing>) -> Option<[Vec3; 2]> {
    union(things.into_iter().map(|thing| [thing.lo, thing.hi]))
}

/// All things of a class in a frame.
struct Class<'a> {
    things: Vec<&'a Thing>,
    lo: Vec3,
    hi: Vec3,
    /// Mean of the rows' places.
    mean: Vec3,
    /// Largest half length, m.
    size: f32,
}

impl Class<'_> {
    /// Whether they are many bodies, as grains are.
    fn is_grains(&self) -> bool {
        self.things.iter().filter(|thing| thing.is_body).count() >= MANY
    }
}

/// The classes of an animation, frame by frame, by their names; one without a name in tables without classes.
pub(super) struct Classes<'a> {
    frames: Vec<BTreeMap<&'a str, Class<'a>>>,
}

impl<'a> Classes<'a> {
    pub(super) fn of(surveys: &'a [Survey<'a>]) -> Classes<'a> {
        Classes { frames: surveys.iter().map(classes).collect() }
    }

    /// Classes whose things move, or come and go.
    pub(super) fn moving(&self) -> BTreeSet<&'a str> {
        let moves = |name: &str| {
            let all: Vec<_> = self.frames.iter().map(|frame| frame.get(name)).collect();
            let has_moved = |a: &Class<'_>, b: &Class<'_>| {
                let ways = [a.mean - b.mean, a.lo - b.lo, a.hi - b.hi];
                // What turns in its place has parts that move.
                let part_has_moved = |(p, q): (&&Thing, &&Thing)| p.center().distance(q.center()) > 0.25 * a.size;
                let turns = a.things.len() == b.things.len() && a.things.iter().zip(&b.things).any(part_has_moved);
                turns || ways.iter().any(|way| way.length() > 0.25 * a.size)
            };
            all.windows(2).any(|w| w[0].is_some() != w[1].is_some())
                || all[0].is_some_and(|first| all.iter().flatten().any(|class| has_moved(first, class)))
        };
        let names: BTreeSet<&str> = self.frames.iter().flat_map(|frame| frame.keys().copied()).collect();
        names.into_iter().filter(|name| moves(name)).collect()
    }

    /// Classes whose box has a large part of the grains in it, as a drum or a hopper has: opaque, they would hide what they hold.
    pub(super) fn containers(&self) -> BTreeSet<&'a str> {
        /// Share of the grains in a container.
        const HELD: f32 = 0.3;
        /// Size of the largest of several bodies that make a container, as walls do, over its own.
        const WALL: f32 = 0.8;
        let mut found = BTreeSet::new();
        for frame in &self.frames {
            let grains = frame.values().filter(|class| class.is_grains());
            let grains = Points::new(grains.flat_map(|c| c.things.iter().map(|t| t.center())).collect());
            let most = |lo, hi| grains.count(lo, hi) as f32 > HELD * grains.len() as f32;
            for (name, class) in frame.iter().filter(|(name, class)| !class.is_grains() && !name.is_empty()) {
                // Wheels and boulders that stand about hold nothing.
                let is_one = class.things.iter().filter(|thing| thing.is_body).count() == 1;
                // A ramp has grains in its box, but in front of it.
                let is_board = class.things.len() == 1 && class.things[0].is_plate;
                let has_walls = class.things.iter().any(|thing| thing.is_plate);
                let is_around = class.size > WALL * 0.5 * (class.hi - class.lo).max_element();
                let is_vessel = if is_one { !is_board } else { has_walls && is_around };
                if is_vessel && !found.contains(name) && most(class.lo, class.hi) {
                    found.insert(*name);
                }
            }
            // Walls with names of their own hold the grains together; a floor under these hides nothing.
            let bottom = grains.lo().z;
            let is_wall = |class: &Class<'_>| {
                !class.is_grains()
                    && class.things.iter().all(|t| t.is_plate)
                    && 0.5 * (class.lo.z + class.hi.z) > bottom
            };
            let walls: Vec<_> = frame.iter().filter(|(name, class)| is_wall(class) && !name.is_empty()).collect();
            if walls.iter().map(|(_, class)| class.things.len()).sum::<usize>() < 2 {
                continue;
            }
            let Some([lo, hi]) = union(walls.iter().map(|(_, class)| [class.lo, class.hi])) else { continue };
            if most(lo, hi) {
                let is_large = |class: &Class<'_>| class.size > 0.3 * 0.5 * (hi - lo).max_element();
                found.extend(walls.iter().filter(|(_, class)| is_large(class)).map(|(name, _)| **name));
            }
        }
        found
    }

    /// The box of what moves in an animation, with what holds it and what stands in it; none if nothing moves.
    fn scene_of_action(&self, containers: &BTreeSet<&str>) -> Option<[Vec3; 2]> {
        /// Growth of the box in which standing things belong to it, over its size.
        const MARGIN: f32 = 0.1;
        /// Largest part of a mechanism over what moves of it.
        const MECHANISM: f32 = 8.0;
        let moving = self.moving();
        let is_of = |name: &str| moving.contains(name) || containers.contains(name);
        let [mut lo, mut hi] = union(self.frames.iter().filter_map(|frame| {
            let things =
                frame.iter().filter(|(name, _)| is_of(name)).flat_map(|(_, class)| class.things.iter().copied());
            without_strays(things)
        }))?;
        let first = self.frames.first()?;
        let standing = first.iter().filter(|(name, _)| !is_of(name)).flat_map(|(_, class)| &class.things);
        let standing: Vec<&Thing> = standing.copied().collect();
        let n_bodies = first.values().flat_map(|c| &c.things).filter(|thing| thing.is_body).count();
        // What is larger than the action goes on out of the image; but of few bodies those that hang together are a mechanism, of
        // which one may have begun to move.
        let (larger, rounds) = if n_bodies < MANY { (MECHANISM, n_bodies) } else { (1.0, 1) };
        for _ in 0..rounds {
            // A mechanism may be flat: what bears it stands beside it.
            let size = if n_bodies < MANY { Vec3::splat((hi - lo).max_element()) } else { hi - lo };
            let margin = MARGIN * size;
            let is_near = |thing: &&Thing| thing.lo.cmple(hi + margin).all() && thing.hi.cmpge(lo - margin).all();
            let is_part = |thing: &&Thing| (thing.hi - thing.lo).length() < larger * (hi - lo).length();
            let Some([a, b]) = around(standing.iter().copied().filter(is_near).filter(is_part)) else { break };
            (lo, hi) = (lo.min(a), hi.max(b));
        }
        Some([lo, hi])
    }

    /// The machine of an animation whose extent is `lo` to `hi`, if a camera that saw all would show it as a few pixels.
    pub(super) fn subject(&self, containers: &BTreeSet<&str>, [lo, hi]: [Vec3; 2]) -> Option<Subject<'a>> {
        /// Largest diagonal of such a machine over that of the whole.
        const SMALL: f32 = 0.06;
        /// What is shown over the machine's size.
        const CONTEXT: f32 = 4.0;
        let is_machine = |name: &str, class: &Class<'_>| !class.is_grains() && !containers.contains(name);
        let mut moving = self.moving();
        moving.retain(|name| self.frames.iter().flat_map(|f| f.get(name)).all(|class| is_machine(name, class)));
        let first = self.frames.first()?;
        let (class, _) = first
            .iter()
            .filter(|(name, _)| moving.contains(*name) && self.frames.iter().all(|f| f.contains_key(*name)))
            .max_by(|a, b| a.1.size.total_cmp(&b.1.size))?;
        // The machine as seen from its largest body.
        let [a, b] = union(self.frames.iter().flat_map(|f| {
            let from = f[class].mean;
            let own = f.iter().filter(|(name, _)| moving.contains(*name));
            own.map(move |(_, class)| [class.lo - from, class.hi - from])
        }))?;
        let (center, half) = (0.5 * (a + b), 0.5 * CONTEXT * (b - a));
        (a.distance(b) < SMALL * lo.distance(hi)).then_some(Subject { class, lo: center - half, hi: center + half })
    }
}

/// A machine that is small in what is seen of the whole, and moves: the camera goes with it.
pub(super) struct Subject<'a> {
    /// Class of its largest body, which every frame has.
    pub(super) class: &'a str,
    /// The box to show, from the mean position of that class, m.
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
}

/// The classes of a frame.
fn classes<'a>(survey: &'a Survey<'a>) -> BTreeMap<&'a str, Class<'a>> {
    let mut all: BTreeMap<&str, Vec<&Thing>> = BTreeMap::new();
    for thing in &survey.things {
        all.entry(survey.classes.get(thing.class as usize).map_or("", String::as_str)).or_default().push(thing);
    }
    let boxed = all.into_iter().filter_map(|(name, things)| {
        let [lo, hi] = around(things.iter().copied())?;
        let mean = things.iter().map(|t| t.center()).sum::<Vec3>() / things.len() as f32;
        let size = things.iter().map(|t| t.size).fold(0.0, f32::max);
        Some((name, Class { things, lo, hi, mean, size }))
    });
    boxed.collect()
}

/// The box of all frames: of what moves, if they have classes, else of all; none if no row has a finite position. Terrain is looked at
/// only where there is nothing else.
pub(super) fn extent(surveys: &[Survey<'_>], classes: &Classes<'_>, containers: &BTreeSet<&str>) -> Option<[Vec3; 2]> {
    let all = |of: for<'a> fn(&'a Survey<'_>) -> &'a [Thing]| {
        union(surveys.iter().filter_map(|survey| without_strays(of(survey))))
    };
    let has_classes = surveys.iter().any(|survey| !survey.classes.is_empty());
    let action = has_classes.then(|| classes.scene_of_action(containers)).flatten();
    action.or_else(|| all(|survey| &survey.things)).or_else(|| all(|survey| &survey.terrain))
}

/// Radius of spheres that stand for points: half the usual distance of a point to the nearest other, m. None where all are in one
/// place.
pub(super) fn radius_by_spacing(surveys: &[Survey<'_>], [lo, hi]: [Vec3; 2]) -> Option<f32> {
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
    Some((0.5 * usual).min(MAX * lo.distance(hi)))
}

/// The usual size of many things and how far they lie apart at most, m, if they are larger than that.
pub(super) fn too_large(surveys: &[Survey<'_>]) -> Option<(f32, f32)> {
    let things = &surveys.iter().max_by_key(|survey| survey.things.len())?.things;
    let mut sizes: Vec<f32> = things.iter().map(|thing| thing.size).collect();
    sizes.sort_by(f32::total_cmp);
    let usual = *sizes.get(sizes.len() / 2)?;
    let centers = things.iter().map(|thing| [thing.center(); 2]);
    let [lo, hi] = union(centers)?;
    let apart = lo.distance(hi);
    (things.len() > 9 && usual > apart && apart > 0.0).then_some((usual, apart))
}

/// The box around things, without the outermost of many alike, as stray grains are. What is larger than most of its class is never
/// left out, nor is a class of few: a vehicle among stones is no stray.
fn without_strays<'a>(things: impl IntoIterator<Item = &'a Thing>) -> Option<[Vec3; 2]> {
    let things: Vec<&Thing> = things.into_iter().collect();
    let mut sizes: BTreeMap<u32, Vec<f32>> = BTreeMap::new();
    things.iter().filter(|t| t.is_body).for_each(|t| sizes.entry(t.class).or_default().push(t.size));
    let median = |sizes: &mut Vec<f32>| {
        let half = sizes.len() / 2;
        *sizes.select_nth_unstable_by(half, f32::total_cmp).1
    };
    let limit: BTreeMap<u32, f32> =
        sizes.iter_mut().filter(|(_, s)| s.len() >= MANY).map(|(class, s)| (*class, 2.0 * median(s))).collect();
    let is_one_of_many = |t: &&Thing| limit.get(&t.class).is_some_and(|limit| t.size <= *limit);
    let (grains, others): (Vec<&Thing>, Vec<&Thing>) = things.into_iter().partition(is_one_of_many);
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
        let (lo, hi) = (corner(&|t| t.lo, skip), corner(&|t| t.hi, last));
        let [all_lo, all_hi] = [corner(&|t| t.lo, 0), corner(&|t| t.hi, grains.len() - 1)];
        let far = FAR * (hi - lo);
        [Vec3::select((lo - all_lo).cmpgt(far), lo, all_lo), Vec3::select((all_hi - hi).cmpgt(far), hi, all_hi)]
    });
    union([core, around(others)].into_iter().flatten())
}

/// A camera from the front, a little to the side and above, near enough that the box fills the image.
pub(super) fn camera(lo: Vec3, hi: Vec3) -> CameraSpec {
    /// Share of the image that the box may fill.
    const FILL: f32 = 0.84;
    let mut center = 0.5 * (lo + hi);
    let fov = 35.0f32;
    let back = Vec3::new(-0.45, -1.0, 0.5).normalize();
    let right = back.cross(Vec3::Z).normalize() * -1.0;
    let up = back.cross(right);
    let half_height = (fov.to_radians() * 0.5).tan() * FILL;
    let half_width = half_height * 16.0 / 9.0;
    let corner = |k: usize| Vec3::new([lo.x, hi.x][k & 1], [lo.y, hi.y][k >> 1 & 1], [lo.z, hi.z][k >> 2]);
    // A corner at depth d + p·back is in the image if its offset is at most this share of that depth.
    let needed = |p: Vec3| p.dot(back) + (p.dot(up).abs() / half_height).max(p.dot(right).abs() / half_width);
    let distance = |center: Vec3| (0..8).map(|k| needed(corner(k) - center)).fold(1e-12, f32::max);
    // What is near is larger: the middle of the image is not that of the box.
    for _ in 0..6 {
        let far = distance(center);
        let middle = |across: Vec3| {
            let places = (0..8).map(|k| corner(k) - center).map(|p| p.dot(across) / (far - p.dot(back)));
            let (a, b) = places.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            0.5 * (a + b) * far
        };
        let (aside, above) = (middle(right), middle(up));
        center += right * aside + up * above;
    }
    let distance = distance(center);
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
        Thing { lo: at - size, hi: at + size, size, class, is_body: true, is_plate: false }
    }

    #[test]
    fn a_board_or_posts_among_grains_hold_nothing() {
        let names = ["stones", "other"].map(String::from);
        let is_container = |others: Vec<Thing>| {
            let grain = |k: usize| thing([0.1 * (k % 5) as f32 - 0.2, 0.1 * (k / 5) as f32 - 0.4, 0.5], 0.04, 0);
            let things = (0..40).map(grain).chain(others).collect();
            let surveys = [Survey { things, terrain: vec![], kinds: vec![], classes: &names }];
            !Classes::of(&surveys).containers().is_empty()
        };
        let plate = |at: [f32; 3], half: [f32; 3]| {
            let (at, half) = (Vec3::from_array(at), Vec3::from_array(half));
            Thing { lo: at - half, hi: at + half, size: half.max_element(), class: 1, is_body: true, is_plate: true }
        };
        // The box of an inclined ramp is as high as it is.
        assert!(!is_container(vec![plate([0.0, 0.0, 0.5], [0.6, 0.6, 0.5])]), "a ramp");
        let corners = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
        let post = |[x, y]: [f32; 2]| {
            let (at, half) = (Vec3::new(x, y, 0.5), Vec3::new(0.05, 0.05, 0.6));
            Thing { lo: at - half, hi: at + half, size: 0.6, class: 1, is_body: true, is_plate: false }
        };
        assert!(!is_container(corners.map(post).to_vec()), "posts");
        let walls = [plate([-0.6, 0.0, 0.6], [0.02, 0.6, 0.6]), plate([0.6, 0.0, 0.6], [0.02, 0.6, 0.6])];
        assert!(is_container(walls.to_vec()), "walls");
    }

    #[test]
    fn the_top_of_a_pyramid_is_no_stray() {
        let rows = (0..40).flat_map(|row| (0..40 - row).map(move |k| [0.5 * row as f32 + k as f32, 0.0, row as f32]));
        let things: Vec<Thing> = rows.map(|at| thing(at, 0.5, 0)).collect();
        let [lo, hi] = without_strays(&things).unwrap();
        assert_eq!([lo, hi], [Vec3::splat(-0.5), Vec3::new(39.5, 0.5, 39.5)]);
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
