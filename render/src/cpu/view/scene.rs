//! What shaders ask of the scene, answered as it is from one primitive.

use super::{MAX_LAYERS, Path, View, Wanted};
use crate::cpu::met::Hit;
use crate::scene::source::Item;
use glam::Vec3;
use sl::ir::{Ask, Lookup};
use sl::machine::{Answer, BoundShader, Emitter, MapQuery, Open, OpenPlace, Ray, Segment};
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl sl::machine::Scene for View<'_> {
    fn lights(&self) -> &[Arc<BoundShader>] {
        self.lights
    }

    fn shutter(&self) -> [f32; 2] {
        self.scene.shutter
    }

    fn eye(&self) -> [f32; 3] {
        self.scene.camera_to_world.transform_point3(Vec3::ZERO).to_array()
    }

    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]> {
        self.scene.matrix(from, to, &|space| match space {
            "object" => Some(self.object_to_world),
            "shape" => Some(self.shape_to_world),
            "shader" => Some(self.shader_to_world),
            _ => None,
        })
    }

    fn transmission(&self, segments: &[Segment], light: &mut [[f32; 3]]) {
        segments.iter().zip(light).for_each(|(s, light)| *light = self.light_along(s.from.into(), s.to.into()));
    }

    fn map_number(&self, how: Lookup, name: &str) -> u32 {
        if how == Lookup::Shadow || name.is_empty() { 0 } else { self.scene.textures.number(name) }
    }

    fn print(&self, text: &str) {
        self.scene.print(text);
    }

    fn stop(&self, message: &str) {
        self.scene.stop(Some(self.item.source), message);
    }

    fn warn(&self, message: String) {
        self.scene.warn_of(self.item.source, message);
    }

    fn map_fault(&self, how: Lookup, name: &str, along_ray: bool) -> Option<String> {
        match how {
            Lookup::Shadow if along_ray => None,
            Lookup::Shadow => {
                Some("shadow() is answered in light shaders alone; elsewhere nothing is in shadow".into())
            }
            _ => self.scene.textures.fault(name),
        }
    }

    fn outside(&self, place: &str, index: f32, message: String) {
        self.scene.outside(place, index, message);
    }

    fn is_stopped(&self) -> bool {
        self.scene.stopped().is_some()
    }

    fn hit(&self, rays: &[Ray], distances: &mut [Option<f32>]) {
        for (ray, distance) in rays.iter().zip(distances) {
            let dir = Vec3::from(ray.direction);
            let place = Vec3::from(ray.from);
            let start = self.start(place, dir);
            let found = self.rays.nearest(self.item, start, dir, 0.0, self.bias);
            // From the place itself, not from where the ray starts beside it.
            *distance = found.map(|(t, _)| (t + (start - place).dot(dir)).max(0.0));
        }
    }

    fn hidden(&self, rays: &[Ray], hidden: &mut [f32]) {
        // A surface that is asked for its opacity by a ray of many asks as many in turn, as deep as these are followed.
        if self.asked > 0 && self.asked >= self.max_depth(true) {
            return hidden.fill(0.0);
        }
        self.rays.tally.occlusion.fetch_add(rays.len() as u64, Ordering::Relaxed);
        for (ray, hidden) in rays.iter().zip(hidden) {
            let dir = Vec3::from(ray.direction);
            let from = self.start(ray.from.into(), dir);
            let meets = self.rays.meets(self.item, from, dir, self.bias);
            *hidden = match meets && self.rays.any_translucent() {
                true => 1.0 - self.open_along(from, dir, f32::INFINITY).iter().sum::<f32>() / 3.0,
                false => meets as u8 as f32,
            };
        }
    }

    fn emitter(&self, light: usize, n: usize, place: &dyn Fn(usize) -> [f32; 3]) -> Option<Emitter> {
        let (area, sample) = self.attributes.emitters.get(light).copied().flatten()?;
        let light = &self.scene.area_lights[area as usize];
        let (mut points, mut normals) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
        for k in 0..n {
            let at = sl::spread(sample as usize, place(k));
            let (p, m) = light.area.point(at).unwrap_or_default();
            for c in 0..3 {
                (points[c * n + k], normals[c * n + k]) = (p[c], m[c]);
            }
        }
        Some(Emitter { points, normals, part: 1.0 / light.samples as f32 })
    }

    fn openness(&self, places: &[OpenPlace], open: &mut [Open]) {
        self.rays.surroundings(self.scene).open(self.item, self.scene.whole_of(self.item), places, open);
    }

    fn traces(&self, many: bool) -> bool {
        self.depth < self.max_depth(many)
    }

    fn trace(&self, rays: &[Ray], many: bool, colors: &mut [[f32; 3]]) {
        if !self.traces(many) {
            return colors.fill([0.0; 3]);
        }
        colors.fill([0.0; 3]);
        let start = |ray: &Ray| {
            let dir = Vec3::from(ray.direction);
            Path {
                from: self.start(ray.from.into(), dir),
                dir,
                open: [1.0; 3],
                least: 0.0,
                last: None,
                passed: self.attributes,
                begin: ray.from.into(),
                outwards: self.attributes.exterior.is_some() && self.leaves_outwards(ray.from.into(), dir),
            }
        };
        let mut paths: Vec<Path<'_>> = rays.iter().map(start).collect();
        let mut alive: Vec<usize> = (0..rays.len()).collect();
        for _ in 0..MAX_LAYERS {
            let nearest = |ray: &usize| {
                let (distance, item) = self.next_along(&paths[*ray])?;
                let Path { from, dir, .. } = paths[*ray];
                (distance < f32::INFINITY).then_some((item, *ray, Hit { from, dir, distance }))
            };
            let mut layer: Vec<(Item, usize, Hit)> = alive.iter().filter_map(nearest).collect();
            layer.sort_by_key(|(item, ray, _)| (item.source, item.index, *ray));
            alive.clear();
            for of_item in layer.chunk_by(|a, b| a.0 == b.0) {
                let hits: Vec<Hit> = of_item.iter().map(|(_, _, hit)| *hit).collect();
                let shaded = self.shade(of_item[0].0, &hits, Wanted::Color { many });
                for ((item, ray, hit), light) in of_item.iter().zip(shaded) {
                    let path = &mut paths[*ray];
                    // `Points` are disks before the ray.
                    let is_left = self.scene.leaves_particle(*item, hit.from + hit.dir * hit.distance, hit.dir);
                    let light = if is_left { [[0.0; 3]; 2] } else { light };
                    let [ci, oi] = self.through_volume(path, *item, hit, light);
                    (0..3).for_each(|c| colors[*ray][c] += path.open[c] * ci[c]);
                    if self.pass(path, (hit.distance, *item), oi) {
                        alive.push(*ray);
                    }
                }
            }
            if alive.is_empty() {
                break;
            }
        }
    }

    fn map(&self, queries: &[MapQuery<'_>], values: &mut [[f32; 4]]) {
        queries.iter().zip(values).for_each(|(query, value)| *value = self.look_up(query));
    }

    fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        let a = self.attributes;
        let numbers = |v: &[f32]| Some(Answer::Numbers(v.to_vec()));
        match (what, names) {
            (Ask::Surface, [name]) => a.surface.parameter(name),
            (Ask::Displacement, [name]) => a.displacement.as_ref()?.parameter(name),
            (Ask::Atmosphere, [name]) => a.atmosphere.as_ref()?.parameter(name),
            (Ask::Incident, [name]) => a.exterior.as_ref()?.0.parameter(name),
            (Ask::Opposite, [name]) => a.interior.as_ref()?.0.parameter(name),
            (Ask::ShaderName, [kind]) => Some(Answer::Text(self.shader(kind)?.program.name.clone())),
            (Ask::Attribute, ["ShadingRate"]) => numbers(&[a.shading_rate]),
            (Ask::Attribute, ["Sides"]) => numbers(&[if a.two_sided { 2.0 } else { 1.0 }]),
            (Ask::Attribute, ["Matte"]) => numbers(&[a.matte as u8 as f32]),
            (Ask::Attribute, ["Color"]) => numbers(&a.color),
            (Ask::Attribute, ["Opacity"]) => numbers(&a.opacity),
            (Ask::Attribute, [name]) => a.user.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone()),
            (Ask::RayInfo, ["depth"]) => numbers(&[self.depth as f32]),
            (Ask::RayInfo, ["type"]) => {
                let kind = if self.diffuse { "diffuse" } else { "specular" };
                Some(Answer::Text(if self.depth == 0 { "camera" } else { kind }.into()))
            }
            _ => self.scene.ask(what, names),
        }
    }
}
