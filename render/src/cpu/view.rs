//! The scene as shaders see it from one primitive: its lights, spaces, maps, and what rays find.
//!
//! Rays that ask for colour are followed together, from layer to layer of what is translucent: the points of a layer where they
//! meet one primitive are shaded in one run, with its surface shader and the lights that shine on it; where a shader looks at
//! neighbouring points, which rays have not, each is a run of its own. Rays that such a shader sends are followed as far as `Option "trace" "maxdepth"` says, and those that are
//! many from one point, which gather light from all around, as far as `"maxdiffusedepth"`. A ray that asks how opaque a surface is runs
//! what of the surface shader Oi depends on; where that asks `occlusion` in turn, beyond this depth nothing is hidden.

mod scene;

use crate::cpu::globals::{fill_velocity, surface_globals};
use crate::cpu::met::{Hit, Met, flat_normal, meet, meet_displaced};
use crate::cpu::rays::{BEFORE_END, ROUNDING, Rays};
use crate::cpu::volumes::Leg;
use crate::scene::attributes::Attributes;
use crate::scene::source::{Item, ItemView};
use crate::scene::world::Scene;
use glam::{Mat4, Vec3};
use sl::Global;
use sl::ir::{Ask, Lookup};
use sl::machine::{Answer, BoundShader, Machine, MapQuery, Points};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// How deep rays are followed if no option says: single ones, and those that are many from one point.
const MAX_DEPTH: [u32; 2] = [4, 1];

/// Translucent surfaces that a ray passes before it is stopped.
const MAX_LAYERS: usize = 64;

/// Surfaces whose shaders are asked for their opacity one from within another: the rays of their lights may meet others.
const MAX_NESTED: u32 = 2;

/// How far a ray from a flat surface is lifted off that, twice, and begun earlier, once, in parts of how near its start others may not count.
const LIFT: f32 = 0.05;

/// The cosine to the normal of a flat surface from which on all that a ray passes as it is lifted is looked for.
const LEAST_SLOPE: f32 = 0.05;

/// The scene from one primitive.
pub struct View<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What rays meet.
    pub rays: &'a Rays<'a>,
    /// The primitive that is shaded.
    pub item: Item,
    /// Object space to world.
    pub object_to_world: Mat4,
    /// The space in which the shape has unit size, to world.
    pub shape_to_world: Mat4,
    /// The space of the shader that runs, to world.
    pub shader_to_world: Mat4,
    /// Lights that shine on it.
    pub lights: &'a [Arc<BoundShader>],
    /// How near the start of a ray a surface does not count: others, and its own.
    pub bias: [f32; 2],
    /// Its normal, if it is flat.
    pub flat: Option<Vec3>,
    /// Its attributes.
    pub attributes: &'a Attributes,
    /// Rays between the camera and here.
    pub depth: u32,
    /// The last of them was one of many.
    pub diffuse: bool,
    /// How many of them asked for an opacity alone.
    pub asked: u32,
}

/// What a ray asks of a surface.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    /// Colour and opacity, for a ray of its own or one of many from a point.
    Color { many: bool },
    /// The opacity alone.
    Opacity,
}

thread_local! {
    /// Machines for what rays meet, one for each ray that is followed at once.
    static SPARE: RefCell<Vec<(Machine, Points)>> = const { RefCell::new(vec![]) };
}

impl<'a> View<'a> {
    /// The view from an item, as its surface shader has it.
    pub fn new(scene: &'a Scene, rays: &'a Rays<'a>, item: Item, view: &ItemView<'a>, bias: [f32; 2]) -> View<'a> {
        let attributes = view.attributes;
        View {
            scene,
            rays,
            item,
            object_to_world: view.object_to_world,
            shape_to_world: view.to_world,
            shader_to_world: attributes.surface_space,
            lights: &attributes.light_list,
            bias,
            flat: flat_normal(view).filter(|_| !rays.meets_displaced(item)),
            attributes,
            depth: 0,
            diffuse: false,
            asked: 0,
        }
    }

    /// The colours and opacities of an item where rays meet it, one a hit.
    fn shade(&self, item: Item, hits: &[Hit], wanted: Wanted) -> Vec<[[f32; 3]; 2]> {
        let view = self.scene.view(item);
        let (mut machine, mut points) = SPARE.with(|s| s.borrow_mut().pop()).unwrap_or_default();
        let met: Vec<Met> = hits.iter().map(|hit| self.meet(item, &view, hit)).collect();
        let is_alone = view.attributes.reads_neighbours() || reads_displaced_neighbours(view.attributes);
        let mut answers = Vec::with_capacity(hits.len());
        let mut first = 0;
        for run in met.chunk_by(|a, b| !is_alone && a.has_uniform_of(b)) {
            let hits = &hits[first..first + run.len()];
            first += run.len();
            self.shade_run(item, &view, (hits, run), wanted, (&mut machine, &mut points));
            let n = run.len();
            let triple = |global: Global, k: usize| match points.get(global) {
                Some(&[r, g, b]) => [r, g, b],
                Some(v) if v.len() == 3 * n => [v[k], v[n + k], v[2 * n + k]],
                _ => [0.0; 3],
            };
            answers.extend((0..n).map(|k| view.repeated([triple(Global::Ci, k), triple(Global::Oi, k)])));
        }
        SPARE.with(|s| s.borrow_mut().push((machine, points)));
        answers
    }

    /// Shade points of an item that have its uniform variables in common.
    fn shade_run(
        &self,
        item: Item,
        view: &ItemView<'a>,
        (hits, met): (&[Hit], &[Met]),
        wanted: Wanted,
        (machine, points): (&mut Machine, &mut Points),
    ) {
        let a = view.attributes;
        // What is asked for its opacity makes no colours.
        let surface = if wanted == Wanted::Opacity { a.surface.of_opacity() } else { &a.surface };
        (points.nu, points.nv) = (met.len(), 1);
        points.orientation = if a.reversed != (view.to_world.determinant() < 0.0) { -1.0 } else { 1.0 };
        view.fill_variables(points);
        fill_patch_variables(points, met);
        view.to_current(points);
        fill_triples(points, Global::I, hits.iter().map(|hit| hit.dir * hit.distance));
        let numbers: [(Global, fn(&Met) -> f32); 4] =
            [(Global::U, |m| m.uv[0]), (Global::V, |m| m.uv[1]), (Global::S, |m| m.st[0]), (Global::T, |m| m.st[1])];
        for (global, of) in numbers {
            points.refill(global).extend(met.iter().map(of));
        }
        view.set_coordinates(points);
        self.displace(item, view, (surface, met), (machine, points));
        let side = if a.reversed { -1.0 } else { 1.0 };
        fill_triples(points, Global::P, met.iter().map(|m| m.place));
        fill_triples(points, Global::N, met.iter().map(|m| m.normal * side));
        fill_triples(points, Global::Ng, met.iter().map(|m| m.geometric * side));
        let moves = !view.source.moves.is_empty() || view.shift != Vec3::ZERO;
        let moment = moves.then(|| view.source.moves.first().map_or(1.0, |(time, _)| *time));
        fill_velocity(points, view, moment, None, self.scene.shutter);
        surface_globals(points, view, Vec3::ZERO, 0.0);
        if surface.program.global(Global::E).is_some() {
            fill_triples(points, Global::E, hits.iter().map(|hit| hit.from));
        }
        let scene = View {
            depth: self.depth + 1,
            diffuse: wanted == Wanted::Color { many: true },
            asked: self.asked + (wanted == Wanted::Opacity) as u32,
            ..View::new(self.scene, self.rays, item, view, self.bias)
        };
        machine.run_with(surface, &view.attached.surface, points, &scene);
    }

    /// Run the displacement shader of an item where rays meet it, if the surface shader asks what it leaves.
    fn displace(
        &self,
        item: Item,
        view: &ItemView<'a>,
        (surface, met): (&BoundShader, &[Met]),
        (machine, points): (&mut Machine, &mut Points),
    ) {
        let a = view.attributes;
        let Some(displacement) = a.displacement.as_ref().filter(|_| surface.program.asks_displacement) else {
            return;
        };
        let side = if a.reversed { -1.0 } else { 1.0 };
        fill_triples(points, Global::P, met.iter().map(|m| m.before[0]));
        fill_triples(points, Global::N, met.iter().map(|m| m.before[1] * side));
        fill_triples(points, Global::Ng, met.iter().map(|m| m.before[2] * side));
        let own = View::new(self.scene, self.rays, item, view, self.bias);
        // What it traces itself is found once, as the surface is displaced, and not at each ray.
        let scene = View { depth: u32::MAX, shader_to_world: a.displacement_space, ..own };
        machine.run_with(displacement, &view.attached.displacement, points, &scene);
        machine.tell(Ask::Displacement, displacement, points);
    }

    /// Where a ray starts. From a flat surface it is lifted off a little, and begun a little earlier, so that in a corner it meets
    /// the other wall, and at an edge passes the other side; unless it would be lifted over what it meets first.
    fn start(&self, from: Vec3, dir: Vec3) -> Vec3 {
        let Some(n) = self.flat else { return from };
        let off = LIFT * self.bias[0];
        let along = n.dot(dir).abs();
        let passed = off * (2.0 - along) / along.max(LEAST_SLOPE);
        if self.rays.meets_within(self.item, from, dir, passed, self.bias) {
            return from;
        }
        from + (2.0 * n * n.dot(dir).signum() - dir) * off
    }

    /// An item where a ray meets it.
    fn meet(&self, item: Item, view: &ItemView<'a>, hit: &Hit) -> Met<'a> {
        let spot = self.rays.spot(item, hit.from, hit.dir, hit.distance);
        spot.map_or_else(|| meet(view, hit), |spot| meet_displaced(view, hit, &spot))
    }

    /// How much light gets from one point to another.
    fn light_along(&self, from: Vec3, to: Vec3) -> [f32; 3] {
        if self.rays.blocked(self.item, from, to, self.bias) {
            return [0.0; 3];
        }
        if self.rays.any_translucent() { self.light_through(from, to) } else { [1.0; 3] }
    }

    /// How much light gets to a place from a light, whose `blur` is the radius of its disc by its distance.
    fn light_from(&self, query: &MapQuery, from: Vec3) -> f32 {
        let at = Vec3::from(query.at);
        let blur = query.blur[0].max(query.blur[1]);
        if !(blur > 0.0) {
            return self.light_along(at, from)[0];
        }
        let way = from - at;
        let (across, up) = way.normalize_or(Vec3::Z).any_orthonormal_pair();
        let radius = blur * way.length();
        let n = query.samples.clamp(1.0, 256.0) as usize;
        let ray = |k: usize| {
            let [r, turn] = sl::spread(k, query.at);
            let (s, c) = (turn * std::f32::consts::TAU).sin_cos();
            self.light_along(at, from + (across * c + up * s) * (radius * r.sqrt()))[0]
        };
        (0..n).map(ray).sum::<f32>() / n as f32
    }

    /// Four channels of a map at a place.
    fn look_up(&self, query: &MapQuery) -> [f32; 4] {
        match (query.how, query.light) {
            // Whatever map is named, shadows are traced: along the light's ray, which ends at the place asked for.
            (Lookup::Shadow, Some(from)) => [1.0 - self.light_from(query, from.into()); 4],
            (Lookup::Shadow, None) => [0.0; 4],
            _ => self.scene.textures.look_up(query),
        }
    }

    /// How much light gets from one point to another through what is translucent, of which each surface that is met keeps its
    /// opacity.
    fn light_through(&self, from: Vec3, to: Vec3) -> [f32; 3] {
        let length = (to - from).length();
        self.open_along(from, (to - from) / length, length * BEFORE_END)
    }

    /// The same along a direction within a length.
    fn open_along(&self, from: Vec3, dir: Vec3, length: f32) -> [f32; 3] {
        let mut open = [1.0f32; 3];
        for (distance, item) in self.rays.layers(self.scene, self.item, from, dir, length, self.bias, |t| self.step(t))
        {
            let opacity = self.opacity_at(item, from, dir, distance);
            (0..3).for_each(|c| open[c] *= (1.0 - opacity[c]).clamp(0.0, 1.0));
            if nearly_none(open) {
                return [0.0; 3];
            }
        }
        open
    }

    /// How far on from a surface at a distance a ray may meet the same thing again.
    fn step(&self, distance: f32) -> f32 {
        self.bias[0].max(1e-5 * distance)
    }

    /// Let a ray pass an item at a distance. Whether it goes on.
    fn pass(&self, path: &mut Path<'_>, (distance, item): (f32, Item), opacity: [f32; 3]) -> bool {
        (0..3).for_each(|c| path.open[c] *= (1.0 - opacity[c]).clamp(0.0, 1.0));
        // What is in one place is met once.
        path.least = distance + ROUNDING * (distance.abs() + path.from.abs().max_element());
        path.last = Some((distance + self.step(distance), self.scene.whole_of(item)));
        !nearly_none(path.open)
    }

    /// The next that a ray meets; of what it passed last, nothing that is met too soon.
    fn next_along(&self, path: &Path<'_>) -> Option<(f32, Item)> {
        let mut least = path.least;
        for _ in 0..MAX_LAYERS {
            let (distance, item) = self.rays.nearest(self.item, path.from, path.dir, least, self.bias)?;
            let is_same = |(until, whole)| distance < until && self.scene.whole_of(item) == whole;
            if !path.last.is_some_and(is_same) {
                return Some((distance, item));
            }
            least = distance;
        }
        None
    }

    /// What comes along a ray from where it meets an item, through the volume before that; the ray has then passed the item.
    fn through_volume(&self, path: &mut Path<'a>, item: Item, hit: &Hit, light: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
        let attributes = self.scene.attributes(item);
        let to = hit.from + hit.dir * hit.distance;
        let within = attributes.has_volumes() && self.goes_outwards(item, hit);
        let leg = Leg { from: path.begin, to, outwards: path.outwards, within, attributes: [path.passed, attributes] };
        let light = leg.pass(light, |space| View { shader_to_world: space, ..*self });
        (path.passed, path.begin, path.outwards) = (attributes, to, within);
        light
    }

    /// Whether a ray where it meets an item goes to the side that the normal of its surface points to.
    fn goes_outwards(&self, item: Item, hit: &Hit) -> bool {
        let view = self.scene.view(item);
        let side = if view.attributes.reversed { -1.0 } else { 1.0 };
        self.meet(item, &view, hit).geometric.dot(hit.dir) * side > 0.0
    }

    /// Whether a ray from a place on the own surface leaves it outwards: by the normal there, which does not depend on where beside
    /// the surface the ray is begun.
    fn leaves_outwards(&self, place: Vec3, dir: Vec3) -> bool {
        let back = self.bias[0].max(1e-3);
        self.goes_outwards(self.item, &Hit { from: place - dir * back, dir, distance: back })
    }

    /// The opacity of an item where a ray meets it; its shader is asked if it has a say.
    fn opacity_at(&self, item: Item, from: Vec3, dir: Vec3, distance: f32) -> [f32; 3] {
        let attributes = self.scene.attributes(item);
        if self.scene.sources[item.source as usize].shadow_is_known() || self.depth >= MAX_NESTED {
            return self.scene.view(item).repeated([[0.0; 3], attributes.opacity])[1];
        }
        self.rays.tally.opacities.fetch_add(1, Ordering::Relaxed);
        let [[_, opacity]] = self.shade(item, &[Hit { from, dir, distance }], Wanted::Opacity)[..] else {
            unreachable!("an answer a hit")
        };
        opacity
    }

    /// How deep rays are followed.
    fn max_depth(&self, many: bool) -> u32 {
        let name = if many { "trace:maxdiffusedepth" } else { "trace:maxdepth" };
        match self.scene.ask(Ask::Option, &[name]) {
            Some(Answer::Numbers(v)) if !v.is_empty() => v[0].clamp(0.0, 100.0) as u32,
            _ => MAX_DEPTH[many as usize],
        }
    }
}

impl View<'_> {
    /// The primitive's shader of a type, as `shadername` names them.
    fn shader(&self, kind: &str) -> Option<Arc<BoundShader>> {
        let a = self.attributes;
        let of_volume = |volume: &Option<(Arc<BoundShader>, Mat4)>| Some(volume.as_ref()?.0.clone());
        match kind {
            "surface" => Some(a.surface.clone()),
            "displacement" => a.displacement.clone(),
            "atmosphere" => a.atmosphere.clone(),
            "interior" => of_volume(&a.interior),
            "exterior" => of_volume(&a.exterior),
            "lightsource" => None,
            other => {
                let expected = "surface, displacement, atmosphere, interior, exterior or lightsource";
                let source = self.item.source;
                self.scene
                    .warn_of(source, format!("shadername(\"{other}\") names no type of shader, expected {expected}"));
                None
            }
        }
    }
}

/// Whether what a displacement shader leaves to a surface shader that asks depends on the points beside.
fn reads_displaced_neighbours(a: &Attributes) -> bool {
    let displacement = a.displacement.as_ref().filter(|_| a.surface.program.asks_displacement);
    displacement.is_some_and(|shader| shader.program.reads_neighbours)
}

/// Whether too little is left of a ray to follow it.
fn nearly_none(open: [f32; 3]) -> bool {
    open.iter().all(|o| *o < 1e-3)
}

/// A ray on its way through what it meets.
struct Path<'a> {
    from: Vec3,
    dir: Vec3,
    /// What is left of it.
    open: [f32; 3],
    /// How far it has come.
    least: f32,
    /// The primitive that it passed last, and how far it does not meet that again.
    last: Option<(f32, u32)>,
    /// Attributes of the surface that it started from or passed last, where that was, and whether it left that outwards.
    passed: &'a Attributes,
    begin: Vec3,
    outwards: bool,
}

/// Fill a global with a vector a point.
fn fill_triples(points: &mut Points, global: Global, vectors: impl Iterator<Item = Vec3> + Clone) {
    let buffer = points.refill(global);
    (0..3).for_each(|axis| buffer.extend(vectors.clone().map(|v| v[axis])));
}

/// Fill the next slots of the variables: those of the patches that were met, which have their uniform ones in common.
fn fill_patch_variables(points: &mut Points, met: &[Met]) {
    let Some((first, _)) = met[0].on else { return };
    for values in &first.uniform {
        points.next_variable().extend_from_slice(values);
    }
    for (slot, variable) in first.varying.iter().enumerate() {
        let buffer = points.next_variable();
        for c in 0..variable.width() {
            let on = met.iter().filter_map(|m| m.on);
            buffer.extend(on.map(|(patch, [u, v])| patch.varying[slot].at(c, u, v)));
        }
    }
}
