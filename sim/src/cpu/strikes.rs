//! How far apart the contact points of two shapes may be in a step. The margins of shapes bound how far each of them goes; but shapes that fall
//! side by side, or lie beside each other at rest, need no contacts for that. A pair has those that its relative motion may close
//! within the step; and where one of its bodies may be struck, those that it or the other may close from then on, whichever of them stops.
//!
//! Strikes follow each other within a step: what falls on a body that comes to rest is struck as well, somewhat later. Their earliest times are
//! the shortest paths over the pairs, found by relaxation (Bellman 1958), the same whatever the order.

use super::collide::Way;
use super::collide::point::Placed;
use super::collide::rolling::is_curved;
use crate::model::Model;
use crate::shape::ShapeKind;
use crate::state::State;
use glam::{DVec3, Vec3};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Time to which motion is foreseen, over the step: velocities change within it.
const HORIZON: f32 = 1.25;

/// Share of the margins of two shapes at rest within which they have contacts whatever they do.
const ALWAYS: f32 = 0.1;

/// A shape with its margin, in single precision: a ball about it, by which most pairs of a dense pile are told apart, and how it moves.
#[derive(Clone, Copy, Default)]
pub struct Moving {
    centre: Vec3,
    /// Radius of the ball, m, rounded up.
    radius: f32,
    /// Velocity of its centre, m/s.
    velocity: Vec3,
    /// Angular velocity, rad/s, world.
    angular_velocity: Vec3,
    /// Maximum speed of its surface about its centre, m/s.
    spin: f32,
    /// Whether it may roll.
    is_curved: bool,
}

impl Moving {
    /// A placed shape of a model, with its margin, m.
    pub fn of((model, state): (&Model, &State), s: usize, placed: &Placed, margin: f32) -> Moving {
        // The rounding of two centres, and of the radius.
        let rounding = 2.5e-7 * placed.position.abs().max_element();
        let body = model.shape_body[s] as usize;
        let twist = state.twist(body);
        let size = if placed.kind == ShapeKind::Sphere { 0.0 } else { placed.size.length() };
        Moving {
            centre: placed.position.as_vec3(),
            radius: ((placed.extent + margin as f64) * (1.0 + 1e-6) + rounding) as f32,
            velocity: (twist.v + twist.w.cross(placed.position - state.position[body])).as_vec3(),
            angular_velocity: twist.w.as_vec3(),
            spin: (twist.w.length() * size) as f32,
            is_curved: is_curved(placed.kind),
        }
    }

    /// Whether the balls may overlap.
    #[inline(always)]
    pub fn is_near(&self, other: &Moving) -> bool {
        let reach = self.radius + other.radius;
        self.centre.distance_squared(other.centre) <= reach * reach
    }

    /// How two shapes of these bodies move in a step.
    pub fn way((model, state): (&Model, &State), bodies: [u32; 2], shapes: [&Moving; 2]) -> Way {
        Way {
            velocity: shapes.map(|moving| moving.velocity.as_dvec3()),
            spin: shapes.map(|moving| if moving.is_curved { DVec3::ZERO } else { moving.angular_velocity.as_dvec3() }),
            fall: bodies.map(|b| if state.moves(b as usize) { model.gravity * model.step } else { DVec3::ZERO }),
            step: model.step,
        }
    }

    /// A gap that two shapes with margins, whose sum is `full`, m, have at least, m.
    pub fn gap(&self, other: &Moving, full: f32) -> f32 {
        self.centre.distance(other.centre) - (self.radius + other.radius) + full
    }

    /// Speed at which two shapes may approach each other, m/s.
    fn approach(&self, other: &Moving) -> f32 {
        self.velocity.distance(other.velocity) + self.spin + other.spin
    }

    /// Speed at which one of two shapes may run into the other, if either stops, m/s.
    fn speed(&self, other: &Moving) -> f32 {
        self.velocity.length().max(other.velocity.length()) + self.spin + other.spin
    }
}

/// A pair of shapes with overlapping margins.
#[derive(Clone, Copy)]
pub struct Near {
    /// Index of the pair within its part.
    pub k: u32,
    /// The sum of the margins, m.
    pub full: f32,
    /// A gap that the shapes have at least, m.
    pub gap: f32,
    /// The gap up to which they have contacts if neither is struck, m.
    reach: f32,
}

impl Near {
    /// The pair `k`, which has all contacts within its margins, whose sum is `full`, m.
    pub fn whole(k: u32, full: f32) -> Near {
        Near { k, full, gap: f32::NEG_INFINITY, reach: full }
    }

    /// Whether it has no contacts if neither shape is struck.
    pub fn is_beyond(&self) -> bool {
        self.gap > self.reach
    }
}

/// When in a step bodies may be struck, and how fast they may be then.
#[derive(Default)]
pub struct Strikes {
    /// Earliest times, s, as the bits of numbers that are not negative (n_bodies).
    time: Vec<AtomicU32>,
    /// What strikes may change velocities by, m/s, likewise; infinite where nothing is known (n_bodies).
    change: Vec<AtomicU32>,
    /// The round in which there was news of a body, or none (n_bodies): [`LOOK`](Strikes::LOOK), and those in which strikes follow each other.
    news: Vec<AtomicU32>,
    /// Share of that which a body that is struck hands on.
    share: f32,
    /// The margins of two shapes at rest, m.
    at_rest: f32,
    /// The change of velocity that a body of which nothing is foreseen hands on as if it had it, m/s: its neighbours have contacts within their margins.
    unforeseen: f32,
    /// Whether contacts bounce: what is struck has its new velocity for all of the step, then.
    bounces: bool,
    /// Time to which motion is foreseen, s.
    horizon: f32,
    /// The gap within which pairs have contacts whatever they do, m.
    always: f32,
}

impl Strikes {
    /// The round in which pairs are looked at; the next ones let strikes follow each other.
    pub const LOOK: u32 = 1;

    /// Begin a step. Of bodies that joints, springs or loads move, and of those of spheres, whose pairs among each other are not asked for, nothing is
    /// foreseen.
    pub fn begin(&mut self, model: &Model, state: &State, has_sphere_pairs: bool) {
        let step = model.step as f32;
        let falls = model.gravity.length() as f32 * step * step;
        let restitution = model.laws.iter().fold(0.0, |most: f64, law| most.max(law.restitution));
        self.share = 0.5 * (1.0 + restitution as f32);
        self.bounces = restitution > 0.0;
        self.horizon = HORIZON * step;
        self.at_rest = 2.0 * model.envelope as f32;
        self.always = 2.0 * falls + model.solver.rest_gap as f32 + ALWAYS * self.at_rest;
        self.unforeseen = self.at_rest / (self.share * self.horizon);
        let none = [(&mut self.time, f32::INFINITY.to_bits()), (&mut self.change, 0), (&mut self.news, 0)];
        for (column, none) in none {
            column.clear();
            column.resize_with(model.n_bodies(), || AtomicU32::new(none));
        }
        let jointed = model.joints.iter().map(|joint| joint.bodies).chain(model.springs.iter().map(|s| s.bodies));
        let loaded = model.loads.iter().map(|load| load.body);
        let spheres = (0..model.n_shapes())
            .filter(|s| has_sphere_pairs && model.shape_kind[*s] == ShapeKind::Sphere)
            .map(|s| model.shape_body[s]);
        for body in jointed.flatten().chain(loaded).chain(spheres) {
            self.strike(state, Strikes::LOOK, body, (0.0, f32::INFINITY));
        }
    }

    /// Note in a round that a body may be struck at a time, s, and its velocity change by so much, m/s. Returns whether that is news.
    fn strike(&self, state: &State, round: u32, body: u32, (time, change): (f32, f32)) -> bool {
        let (time, change) = (if self.bounces { 0 } else { time.to_bits() }, change.to_bits());
        let (own_time, own_change) = (&self.time[body as usize], &self.change[body as usize]);
        if !state.moves(body as usize) {
            return false;
        }
        // Most is known.
        let is_earlier = time < own_time.load(Relaxed) && time < own_time.fetch_min(time, Relaxed);
        let is_harder = change > own_change.load(Relaxed) && change > own_change.fetch_max(change, Relaxed);
        let is_news = is_earlier | is_harder;
        if is_news {
            self.news[body as usize].store(round, Relaxed);
        }
        is_news
    }

    /// [`strike`](Strikes::strike) two bodies.
    fn strike_both(&self, state: &State, round: u32, bodies: [u32; 2], (time, change): (f32, f32)) -> bool {
        bodies.map(|body| self.strike(state, round, body, (time, change))).contains(&true)
    }

    /// The lesser number of two bodies in a column first.
    fn of(column: &[AtomicU32], bodies: [u32; 2]) -> [f32; 2] {
        let [a, b] = bodies.map(|b| f32::from_bits(column[b as usize].load(Relaxed)));
        [a.min(b), a.max(b)]
    }

    /// The pair `k` of two shapes with margins, whose sum is `full`, m, and a gap of at least `gap`, m. What is curved rolls, and touches with another
    /// point at each moment: such pairs have all contacts within the margins of rest.
    pub fn near(&self, k: u32, [a, b]: [&Moving; 2], (full, gap): (f32, f32)) -> Near {
        let always = if a.is_curved || b.is_curved { self.at_rest + self.always } else { self.always };
        let reach = always + self.horizon * a.approach(b);
        Near { k, full, gap, reach: reach.min(full) }
    }

    /// Strike the bodies of a pair where their relative motion closes the gap, and where they had an overlap, m, by which they will be pushed apart.
    pub fn look(&self, state: &State, near: &Near, bodies: [u32; 2], [a, b]: [&Moving; 2], overlap: f32) {
        let approach = a.approach(b);
        if near.gap <= near.reach && self.horizon * approach > self.always {
            self.strike_both(state, Strikes::LOOK, bodies, (near.gap.max(0.0) / approach, 2.0 * self.share * approach));
        }
        if overlap > self.always {
            self.strike_both(state, Strikes::LOOK, bodies, (0.0, overlap / self.horizon));
        }
    }

    /// Whether any body may be struck.
    pub fn are_any(&self) -> bool {
        self.time.iter().any(|time| f32::from_bits(time.load(Relaxed)) < self.horizon)
    }

    /// Whether there was news of one of two bodies in the round before this one, or in this one.
    #[inline]
    pub fn have_news(&self, round: u32, bodies: [u32; 2]) -> bool {
        bodies.iter().any(|body| self.news[*body as usize].load(Relaxed) + 1 >= round)
    }

    /// Let a strike of a body of a pair follow that of the other: it is run into by what was struck, or runs into it. Returns whether this is news, which
    /// it can only be where the bodies [have news](Strikes::have_news).
    pub fn follow(&self, state: &State, round: u32, near: &Near, bodies: [u32; 2], [a, b]: [&Moving; 2]) -> bool {
        let [time, later] = Strikes::of(&self.time, bodies);
        if time >= self.horizon {
            return false;
        }
        let (left, gap) = (self.horizon - time, near.gap.max(0.0));
        let after = |speed: f32| time + if gap > 0.0 { gap / speed } else { 0.0 };
        let [_, change] = Strikes::of(&self.change, bodies);
        let change = if change < f32::INFINITY { change } else { self.unforeseen };
        let handed = self.share * change;
        let is_pushed = handed * self.horizon > self.always && gap <= self.always + change * left;
        let is_news = is_pushed && self.strike_both(state, round, bodies, (after(change), handed));
        if time >= later {
            return is_news;
        }
        let speed = a.speed(b);
        let way = speed * left;
        let runs_in = way > self.always && gap <= way;
        is_news | (runs_in && self.strike_both(state, round, bodies, (after(speed), 0.0)))
    }

    /// The gap up to which a pair has contacts, m.
    pub fn reach(&self, near: &Near, bodies: [u32; 2], [a, b]: [&Moving; 2]) -> f32 {
        let [time, _] = Strikes::of(&self.time, bodies);
        if time >= self.horizon {
            return near.reach;
        }
        let [_, change] = Strikes::of(&self.change, bodies);
        let left = self.horizon - time;
        (near.reach.max(self.always + a.speed(b) * left) + change * left).min(near.full)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ModelBuilder;
    use crate::fill::SplitMix64;
    use crate::model_file::ShapeFile;

    /// Boxes of 0.2 m at places along x, m, with velocities along it, m/s, that fall in steps of 5 ms.
    fn row(places: &[(f64, f64)], restitution: f64) -> (Model, State) {
        let mut builder = ModelBuilder::new("row");
        builder.file.step = 5e-3;
        builder.material("stone", 1000.0, 0.5).restitution = restitution;
        for (k, (x, speed)) in places.iter().enumerate() {
            let body = builder.body(&format!("box{k}"), "stone", ShapeFile::cuboid([0.2; 3]));
            (body.position, body.velocity) = ([*x, 0.0, 0.0], [*speed, 0.0, 0.0]);
        }
        let sim = builder.into_simulation().unwrap();
        (sim.model, sim.state)
    }

    /// The reaches, m, of the pairs of neighbours in a row, relaxed in an order.
    fn reaches((model, state): &(Model, State), order: &[usize]) -> Vec<f32> {
        const MARGIN: f32 = 10.0;
        let moving: Vec<Moving> = (0..model.n_shapes())
            .map(|s| Moving::of((model, state), s, &Placed::of(model, state.shape_pose(model, s), s), MARGIN))
            .collect();
        let mut strikes = Strikes::default();
        strikes.begin(model, state, false);
        let pair = |k: usize| ([k as u32, k as u32 + 1], [&moving[k], &moving[k + 1]]);
        let mut near = vec![Near::whole(0, 0.0); order.len()];
        for k in order.iter().copied() {
            let (bodies, moving) = pair(k);
            let gap = state.position[k + 1].x - state.position[k].x - 0.2;
            near[k] = strikes.near(k as u32, moving, (2.0 * MARGIN, gap as f32));
            strikes.look(state, &near[k], bodies, moving, 0.0);
        }
        let mut round = Strikes::LOOK;
        let mut follow = || {
            round += 1;
            let follow = |k: usize| {
                let (bodies, moving) = pair(k);
                let have_news = strikes.have_news(round, bodies);
                let is_news = strikes.follow(state, round, &near[k], bodies, moving);
                assert!(have_news || !is_news);
                is_news
            };
            order.iter().fold(false, |any, k| follow(*k) | any)
        };
        while strikes.are_any() && follow() {}
        near.iter().map(|near| strikes.reach(near, pair(near.k as usize).0, pair(near.k as usize).1)).collect()
    }

    #[test]
    fn what_moves_together_has_no_contacts_but_next_to_each_other() {
        let row = row(&[(0.0, 30.0), (0.25, 30.0), (0.5, 30.0)], 0.0);
        assert!(reaches(&row, &[0, 1]).iter().all(|reach| *reach < 3e-3));
    }

    #[test]
    fn what_falls_on_what_is_stopped_is_struck() {
        // The first stands; the others come to it, one behind the other, and each is in reach of the one before it while there is time.
        let row = row(&[(0.0, 0.0), (0.21, -10.0), (0.42, -10.0), (0.63, -10.0), (1.63, -10.0)], 0.0);
        let reaches = reaches(&row, &[3, 2, 1, 0]);
        assert!(reaches[..3].iter().zip([0.06, 0.05, 0.04]).all(|(reach, least)| *reach > least), "{reaches:?}");
        assert!(reaches[3] < 0.05, "{reaches:?}");
    }

    #[test]
    fn blows_are_handed_on_and_wear_off_unless_they_bounce() {
        let places: Vec<(f64, f64)> =
            [(-0.21, 10.0)].into_iter().chain((0..20).map(|k| (0.205 * k as f64, 0.0))).collect();
        let order: Vec<usize> = (0..20).collect();
        let [plastic, elastic] = [0.0, 1.0].map(|e| reaches(&row(&places, e), &order));
        assert!(plastic[..4].iter().all(|reach| *reach > 5e-3) && plastic[19] < 5e-3, "{plastic:?}");
        assert!(elastic.iter().all(|reach| *reach > 5e-2), "{elastic:?}");
    }

    #[test]
    fn strikes_do_not_depend_on_the_order_of_the_pairs() {
        let mut random = SplitMix64(4);
        let mut struck = 0;
        for restitution in [0.0, 0.3] {
            for _ in 0..200 {
                let mut x = 0.0;
                let places: Vec<(f64, f64)> = (0..30)
                    .map(|_| {
                        x += 0.2 + random.between(-1e-3, 0.03);
                        (x, random.between(-1.0, 1.0).powi(3) * 15.0)
                    })
                    .collect();
                let row = row(&places, restitution);
                let forwards: Vec<usize> = (0..29).collect();
                let backwards: Vec<usize> = (0..29).rev().collect();
                let mixed: Vec<usize> = (0..29).map(|k| k * 12 % 29).collect();
                let first = reaches(&row, &forwards);
                assert!([backwards, mixed].iter().all(|order| reaches(&row, order) == first));
                struck += first.iter().filter(|reach| **reach > 0.01).count();
            }
        }
        assert!(struck > 1_000, "{struck}");
    }
}
