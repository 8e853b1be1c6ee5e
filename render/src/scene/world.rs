//! The scene between `WorldBegin` and `WorldEnd`: its sources, spaces, textures and lights, and what shaders ask of it.

use crate::scene::area::AreaLight;
use crate::scene::attributes::Attributes;
use crate::scene::camera::Camera;
use crate::scene::shape::Shape;
use crate::scene::solid::Solids;
use crate::scene::source::{Item, ItemView, Source, SourceShape, instance_color, unscaled};
use crate::texture::Textures;
use crate::warnings::{Spot, Warnings};
use glam::{Mat4, Vec3};
use ri::Fit;
use sl::ir::{Ask, Program};
use sl::machine::Answer;
use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

/// The scene.
#[derive(Default)]
pub struct Scene {
    /// Primitives.
    pub sources: Vec<Source>,
    /// Count of the patches of subdivision meshes.
    pub n_subdivided: usize,
    /// Count of the items that were given ids, and of the primitives that they are parts of: those that are not kept have theirs, too.
    pub n_items: usize,
    /// The same of primitives.
    pub n_wholes: u32,
    /// What solids are made of.
    pub solids: Solids,
    /// Named coordinate systems, to world.
    pub spaces: HashMap<String, Mat4>,
    /// Camera to world.
    pub camera_to_world: Mat4,
    /// Options for shaders that ask, by `group:name` and by their own names.
    pub options: Vec<(String, Answer)>,
    /// When the shutter opens and closes.
    pub shutter: [f32; 2],
    /// Near and far, for shaders that ask.
    pub clipping: [f32; 2],
    /// Images that shaders look up.
    pub textures: Textures,
    /// Lights that have an area.
    pub area_lights: Vec<AreaLight>,
    /// Warnings about the scene.
    pub warnings: Warnings,
    /// Bytes that shaders have printed.
    pub printed: AtomicUsize,
    /// What is wrong with a shader whose loops did not end, and the source that it ran on, if it did.
    pub stopped: OnceLock<(String, Option<u32>)>,
    /// Points to which a shader gave colours that are no finite numbers, by the shader as it is named, and the first source.
    pub unfinite: Mutex<BTreeMap<String, (usize, u32)>>,
    /// The same of opacities below 0 or above 1.
    pub beyond: Mutex<BTreeMap<String, (usize, u32)>>,
    /// What is said of shaders, and the first source that is shaded so.
    pub said: Mutex<BTreeMap<String, u32>>,
    /// Of each place of a shader whose index is out of its range, the least such index, and what is said of it.
    pub outside: Mutex<BTreeMap<String, (f32, String)>>,
    /// Displacement bounds that are needed, by shader, each with the source that needs it.
    pub bounds: Mutex<BTreeMap<String, (f32, u32)>>,
    /// Of each displacement that moves points to places that are not finite, as it is named, the first source.
    pub lost: Mutex<BTreeMap<String, u32>>,
}

static WHOLE_SPHERE: Shape = Shape::Sphere;

impl Scene {
    /// Print what a shader prints, up to a length in all: a scene must not fill a disk with it.
    pub fn print(&self, text: &str) {
        const MOST: usize = 16 << 20;
        let before = self.printed.fetch_add(text.len(), Ordering::Relaxed);
        if before < MOST {
            // That nobody reads it stops no shader.
            let _ = std::io::stderr().write_all(guard::text::terminal(text).as_bytes());
        } else {
            self.warn("shaders print more than 16 MiB: the rest is left out".into());
        }
    }

    /// Take that the loops of a shader do not end: nothing more is rendered.
    pub fn stop(&self, source: Option<u32>, message: &str) {
        let _ = self.stopped.set((message.into(), source));
    }

    /// What is said of the shader whose loops did not end, if there is one.
    pub fn stopped(&self) -> Option<&str> {
        self.stopped.get().map(|(message, _)| message.as_str())
    }

    /// Where the first primitive stands that such a shader runs on.
    pub fn stopped_at(&self) -> Option<Spot> {
        let (_, source) = self.stopped.get()?;
        let found = self.sources.get((*source)? as usize)?;
        let has_its_shaders = |other: &&Source| other.attributes.has_shaders_of(&found.attributes);
        self.sources.iter().find(has_its_shaders).unwrap_or(found).spot
    }

    /// All items, in order, but for those that are as others before them.
    pub fn items(&self) -> impl Iterator<Item = Item> + '_ {
        self.sources.iter().enumerate().flat_map(|(s, source)| {
            let parts = if source.repeats.is_empty() { 1 } else { source.len() / source.repeats.len() };
            let is_seen = move |i: &usize| source.repeats.get(*i / parts) != Some(&0);
            (0..source.len()).filter(is_seen).map(move |i| Item { source: s as u32, index: i as u32 })
        })
    }

    /// Names the primitive that an item is a part of, as a mesh of its faces.
    pub fn whole_of(&self, item: Item) -> u32 {
        let source = &self.sources[item.source as usize];
        let i = item.index as usize;
        match &source.shape {
            SourceShape::One(_) | SourceShape::Spheres(_) => source.wholes.of_instance(i),
            SourceShape::Objects(_, parts) => {
                source.wholes.of_instance(i / parts.len()).wrapping_add(parts[i % parts.len()].whole)
            }
        }
    }

    /// The same, if others may be parts of it, too.
    pub fn shared_whole_of(&self, item: Item) -> Option<u32> {
        self.sources[item.source as usize].wholes.shared.then(|| self.whole_of(item))
    }

    /// Whether an item is one of `Points`.
    pub fn is_particle(&self, item: Item) -> bool {
        let source = &self.sources[item.source as usize];
        match &source.shape {
            SourceShape::Objects(_, parts) => parts[item.index as usize % parts.len()].particle,
            SourceShape::One(_) | SourceShape::Spheres(_) => source.particles,
        }
    }

    /// Whether a ray that meets one of `Points` leaves it: it is a disk before each ray, and counts where it is entered.
    pub fn leaves_particle(&self, item: Item, place: Vec3, dir: Vec3) -> bool {
        self.is_particle(item) && {
            let m = self.place(item).1.inverse();
            m.transform_point3(place).dot(m.transform_vector3(dir)) > 0.0
        }
    }

    /// The id of an item, from 1: that of primitives behind others in their place counts, whether they are kept or not.
    pub fn id_of(&self, item: Item) -> usize {
        self.sources[item.source as usize].first_id + item.index as usize
    }

    /// Whether anything moves while the shutter is open.
    pub fn moves(&self, camera: &Camera) -> bool {
        let deforms = |shape: &Shape| match shape {
            Shape::Patches(patches, _) => patches.iter().any(|p| !p.moves.is_empty()),
            Shape::Sphere => false,
        };
        !camera.moves.is_empty()
            || self.sources.iter().any(|source| {
                !source.moves.is_empty()
                    || source.attributes.fades()
                    || match &source.shape {
                        SourceShape::One(shape) => deforms(shape),
                        SourceShape::Spheres(columns) => columns.moved.is_some(),
                        SourceShape::Objects(columns, parts) => {
                            columns.moved.is_some() || parts.iter().any(|part| deforms(&part.shape))
                        }
                    }
            })
    }

    /// The whole solid that an item is of, if it is of one.
    pub fn root(&self, item: Item) -> Option<u32> {
        self.sources[item.source as usize].attributes.solid.map(|leaf| self.solids.root(leaf))
    }

    /// The attributes of an item.
    pub fn attributes(&self, item: Item) -> &Attributes {
        &self.sources[item.source as usize].attributes
    }

    /// Look an item up.
    pub fn view(&self, item: Item) -> ItemView<'_> {
        let source = &self.sources[item.source as usize];
        let i = item.index as usize;
        let attributes = &*source.attributes;
        let part = match &source.shape {
            SourceShape::Objects(_, parts) => i % parts.len(),
            SourceShape::One(_) | SourceShape::Spheres(_) => 0,
        };
        let (shape, place, (declared, fit), instance) = match &source.shape {
            SourceShape::One(shape) => (shape, Mat4::IDENTITY, (Mat4::IDENTITY, Fit::NONE), None),
            SourceShape::Spheres(columns) => {
                let own = if source.shares_space { Mat4::IDENTITY } else { unscaled(columns, i) };
                let fit = Fit { size: Vec3::ONE, ..columns.fit(i) };
                (&WHOLE_SPHERE, columns.matrix(i), (own, fit), Some((columns, i)))
            }
            SourceShape::Objects(columns, parts) => {
                let (k, part) = (i / parts.len(), &parts[part]);
                let object = columns.matrix(k);
                let declared = (object * part.space, columns.fit(k).of(part.fit));
                (&part.shape, object * part.place, declared, Some((columns, k)))
            }
        };
        let color = instance.and_then(|(columns, i)| instance_color(columns, i)).unwrap_or(attributes.color);
        let (to_world, declared_to_world) = (source.to_world * place, source.to_world * declared);
        let object_to_world = attributes.fit.of(fit).object_of(declared_to_world);
        let shift = instance.and_then(|(columns, i)| {
            let (_, to) = columns.moved.as_ref()?;
            Some(Vec3::from(to[i]) - Vec3::from(columns.position[i]))
        });
        let shift = shift.unwrap_or(Vec3::ZERO);
        let attached = &*source.attached[part];
        let (particle, repeats) = (self.is_particle(item), source.repeats_of(i));
        ItemView {
            shape,
            to_world,
            declared_to_world,
            object_to_world,
            attributes,
            color,
            source,
            attached,
            instance,
            shift,
            particle,
            repeats,
        }
    }

    /// The place of an item for shadows and bounds alone: shape and its matrix to world.
    pub fn place(&self, item: Item) -> (&Shape, Mat4) {
        let source = &self.sources[item.source as usize];
        let i = item.index as usize;
        match &source.shape {
            SourceShape::One(shape) => (shape, source.to_world),
            SourceShape::Spheres(columns) => (&WHOLE_SPHERE, source.to_world * columns.matrix(i)),
            SourceShape::Objects(columns, parts) => {
                let part = &parts[i % parts.len()];
                (&part.shape, source.to_world * columns.matrix(i / parts.len()) * part.place)
            }
        }
    }

    /// The matrix from one named space to another, if both are known; `own` knows those of who asks.
    pub fn matrix(&self, from: &str, to: &str, own: &dyn Fn(&str) -> Option<Mat4>) -> Option<[f32; 16]> {
        let to_world = |space: &str| match space {
            "current" | "world" => Some(Mat4::IDENTITY),
            "camera" | "eye" => Some(self.camera_to_world),
            named => own(named).or_else(|| self.spaces.get(named).copied()),
        };
        Some((to_world(to)?.inverse() * to_world(from)?).to_cols_array())
    }

    /// What shaders ask of the whole image.
    pub fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        let numbers = |v: &[f32]| Some(Answer::Numbers(v.to_vec()));
        match (what, names) {
            (Ask::Option, ["Clipping"]) => numbers(&self.clipping),
            (Ask::Option, [name]) => self.options.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone()),
            (Ask::TextureInfo, [texture, what]) => match *what {
                "resolution" => numbers(&self.textures.size(texture)?.0),
                "exists" => numbers(&[self.textures.exists(texture)? as u8 as f32]),
                "channels" => numbers(&[self.textures.size(texture)?.1]),
                "type" if self.textures.exists(texture)? => Some(Answer::Text(self.textures.kind(texture).into())),
                _ => None,
            },
            _ => None,
        }
    }

    /// Note how far a displacement shader moves a point of a source beyond its bound, as the bound that it needs in object units.
    pub fn needs_bound(&self, shader: &str, bound: f32, source: u32) {
        let mut needed = self.bounds.lock().unwrap_or_else(|e| e.into_inner());
        let known = needed.entry(shader.into()).or_insert((bound, source));
        let is_more = bound.total_cmp(&known.0).then(known.1.cmp(&source)).is_gt();
        *known = if is_more { (bound, source) } else { *known };
    }

    /// Note a displacement, as it is named, that moves points of a source to places that are not finite.
    pub fn loses_points(&self, displacement: String, source: u32) {
        let mut known = self.lost.lock().unwrap_or_else(|e| e.into_inner());
        let first = known.entry(displacement).or_insert(source);
        *first = source.min(*first);
    }

    /// Note points to which a shader gave colours that are no finite numbers.
    pub fn not_finite(&self, shader: &Program, n: usize, source: u32) {
        note_points(&self.unfinite, shader, n, source);
    }

    /// Note points to which a shader gave opacities below 0 or above 1.
    pub fn not_opacities(&self, shader: &Program, n: usize, source: u32) {
        note_points(&self.beyond, shader, n, source);
    }

    /// Add a warning about a shader that runs on a source: it is said once, with the place of the first.
    pub fn warn_of(&self, source: u32, message: String) {
        let mut known = self.said.lock().unwrap_or_else(|e| e.into_inner());
        let first = known.entry(message).or_insert(source);
        *first = source.min(*first);
    }

    /// Note an index that is out of its range at a place of a shader: each place is warned of once.
    pub fn outside(&self, place: &str, index: f32, message: String) {
        let mut known = self.outside.lock().unwrap_or_else(|e| e.into_inner());
        let least = known.entry(place.into()).or_insert_with(|| (index, message.clone()));
        if index.total_cmp(&least.0).is_lt() {
            *least = (index, message);
        }
    }

    /// The warnings about the scene, which are removed.
    pub fn take_warnings(&self) -> Vec<String> {
        let spot = |source: u32| self.sources.get(source as usize).and_then(|source| source.spot);
        for (displacement, source) in std::mem::take(&mut *self.lost.lock().unwrap_or_else(|e| e.into_inner())) {
            let lost = "moves points to places that are not finite: these are not drawn";
            self.warnings.add_at(spot(source), format!("{displacement} {lost}"));
        }
        for (shader, (bound, source)) in std::mem::take(&mut *self.bounds.lock().unwrap_or_else(|e| e.into_inner())) {
            let bound = (bound * 1.01 * 1e4).ceil() / 1e4;
            self.warnings.add_at(
                spot(source),
                format!(
                    "displacement `{shader}` reaches farther than its bound, so that some of it may be missing: it needs {bound}, in the unit of object space (in a metadata file `displacement: {{bound: {bound}}}`, m; in RIB `Attribute \"displacementbound\" \"sphere\" [{bound}]`)"
                ),
            );
        }
        for (message, source) in std::mem::take(&mut *self.said.lock().unwrap_or_else(|e| e.into_inner())) {
            self.warnings.add_at(spot(source), message);
        }
        for (_, (_, message)) in std::mem::take(&mut *self.outside.lock().unwrap_or_else(|e| e.into_inner())) {
            self.warn(message);
        }
        let lost = [
            (&self.unfinite, "colours that are no finite numbers", ""),
            (&self.beyond, "opacities below 0 or above 1", ": they count as 0 and 1"),
        ];
        for (noted, what, then) in lost {
            for (shader, (n, source)) in std::mem::take(&mut *noted.lock().unwrap_or_else(|e| e.into_inner())) {
                self.warnings.add_at(spot(source), format!("{shader} gives {what}, at {n} points{then}"));
            }
        }
        self.warnings.take()
    }

    /// Add a warning, once.
    pub fn warn(&self, message: String) {
        self.warnings.add(message);
    }
}

/// Note points to which a shader gave what it should not, by the shader as it is named, and the first source.
fn note_points(noted: &Mutex<BTreeMap<String, (usize, u32)>>, shader: &Program, n: usize, source: u32) {
    let mut known = noted.lock().unwrap_or_else(|e| e.into_inner());
    let (count, first) = known.entry(format!("{}: the shader `{}`", shader.file, shader.name)).or_insert((0, source));
    (*count, *first) = (*count + n, source.min(*first));
}
