//! Attributes of primitives (RISpec section 5).

use crate::film::display::SHOWN;
use crate::scene::area::Emitter;
use crate::scene::keys;
use glam::{Mat4, Vec3};
use ri::Fit;
use sl::Global;
use sl::ir::Kind;
use sl::machine::BoundShader;
use std::sync::Arc;

/// An attribute, or those that belong together, for [`SetAttributes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attribute {
    Color,
    Opacity,
    Surface,
    Displacement,
    DisplacementBound,
    Atmosphere,
    Interior,
    Exterior,
    User,
    TextureCorners,
    Lights,
    AreaLight,
    LightSamples,
    ShadingRate,
    Interpolation,
    Sides,
    Orientation,
    Matte,
    Visibility,
    Shadows,
    Detail,
    Solid,
}

/// Which attributes were set within an object, and the count of times that any was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetAttributes {
    which: u32,
    times: u64,
}

impl SetAttributes {
    /// Note that one is set; `time` is another one each time.
    pub fn note(&mut self, attribute: Attribute, time: u64) {
        self.which |= 1 << attribute as u32;
        self.times = time;
    }

    /// Note that all are that are in another state; `time` is another one each time.
    pub fn join(&mut self, other: &SetAttributes, time: u64) {
        self.which |= other.which;
        self.times = time;
    }

    /// Whether any is.
    pub fn any(&self) -> bool {
        self.which != 0
    }

    /// Whether none was set between this state and another.
    pub fn same(&self, other: &SetAttributes) -> bool {
        self == other
    }

    /// Whether one is.
    pub fn has(&self, attribute: Attribute) -> bool {
        self.which >> attribute as u32 & 1 == 1
    }
}

/// The greatest displacement of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DisplacementBound {
    /// In object units.
    Object(f32),
    /// In world units: it was given in a coordinate system.
    World(f32),
}

/// Attributes of a primitive.
#[derive(Clone)]
pub struct Attributes {
    /// Those that were set within the object that is open.
    pub set: SetAttributes,
    /// Colour, as the shutter opens.
    pub color: [f32; 3],
    /// Opacity, as the shutter opens.
    pub opacity: [f32; 3],
    /// Colours and opacities of a motion block, at its times; of a primitive in the scene, those after the shutter opens, by the
    /// part of the time that it is open.
    pub color_moves: Vec<(f32, [f32; 3])>,
    /// The same of opacities.
    pub opacity_moves: Vec<(f32, [f32; 3])>,
    /// Surface shader.
    pub surface: Arc<BoundShader>,
    /// The surface shader's space.
    pub surface_space: Mat4,
    /// Displacement shader.
    pub displacement: Option<Arc<BoundShader>>,
    /// The displacement shader's space.
    pub displacement_space: Mat4,
    /// Greatest displacement; if not given, a tenth of the primitive.
    pub displacement_bound: Option<DisplacementBound>,
    /// Where the current space stands in the object space of primitives: `Attribute "shape"` sets it.
    pub fit: Fit,
    /// Atmosphere shader.
    pub atmosphere: Option<Arc<BoundShader>>,
    /// The atmosphere shader's space.
    pub atmosphere_space: Mat4,
    /// Volume shaders of what is within and outside of the primitive, with their spaces, for rays that are traced.
    pub interior: Option<(Arc<BoundShader>, Mat4)>,
    /// The same outside.
    pub exterior: Option<(Arc<BoundShader>, Mat4)>,
    /// What `Attribute` set, by `group:name`, for shaders that ask.
    pub user: Arc<Vec<(String, sl::machine::Answer)>>,
    /// s and t of the corners of primitives that have no others (RISpec 5.1).
    pub texture_corners: [f32; 8],
    /// Lights that are on, by handle.
    pub lights: Vec<(String, Arc<BoundShader>)>,
    /// The same, as shading wants them.
    pub light_list: Arc<Vec<Arc<BoundShader>>>,
    /// Of each of them, which point of an area light it is; empty where none is.
    pub emitters: Arc<Vec<Emitter>>,
    /// The area light that primitives become, by its index.
    pub area_light: Option<usize>,
    /// Points that area lights are lit from.
    pub light_samples: usize,
    /// Pixels a micropolygon.
    pub shading_rate: f32,
    /// Colour is interpolated over a micropolygon.
    pub smooth: bool,
    /// Both sides are seen.
    pub two_sided: bool,
    /// The inside is out.
    pub reversed: bool,
    /// It hides what is behind and leaves a hole.
    pub matte: bool,
    /// It is seen by the camera.
    pub visible: bool,
    /// It casts shadows.
    pub casts_shadows: bool,
    /// Its shadows are whole, however much light gets through it.
    pub whole_shadows: bool,
    /// Its shadows are those of its opacity, whatever its surface shader makes of that.
    pub shadows_of_opacity: bool,
    /// Square pixels that the bound of `Detail` covers.
    pub detail: f32,
    /// The corners of that bound in current space, if one was given.
    pub detail_box: Option<[Vec3; 8]>,
    /// The range of square pixels in which primitives are seen: from none to all, and from all to none.
    pub detail_range: [f32; 4],
    /// The part of the samples, from 0 to 1, that see the level of detail: what fades in has the parts that what fades out leaves.
    pub seen: [f32; 2],
    /// The solid that primitives are a part of.
    pub solid: Option<u32>,
}

impl Attributes {
    /// Those that were set within an object over those that hold where it is instanced; `to_instance` brings spaces from where
    /// the object was made.
    pub fn over(&self, at: &Attributes, to_instance: Mat4) -> Attributes {
        let mut all = at.clone();
        let set = &self.set;
        macro_rules! take {
            ($($attribute:ident: $($field:ident)+;)*) => {
                $(if set.has(Attribute::$attribute) { $(all.$field.clone_from(&self.$field);)+ })*
            };
        }
        take! {
            Color: color color_moves;
            Opacity: opacity opacity_moves;
            Surface: surface surface_space;
            Displacement: displacement displacement_space;
            DisplacementBound: displacement_bound;
            Atmosphere: atmosphere atmosphere_space;
            Interior: interior;
            Exterior: exterior;
            User: user;
            TextureCorners: texture_corners;
            Lights: lights light_list;
            AreaLight: area_light;
            LightSamples: light_samples;
            ShadingRate: shading_rate;
            Interpolation: smooth;
            Sides: two_sided;
            Orientation: reversed;
            Matte: matte;
            Visibility: visible;
            Shadows: casts_shadows whole_shadows shadows_of_opacity;
            Detail: detail detail_box detail_range seen;
            Solid: solid;
        }
        let spaces = [
            (Attribute::Surface, &mut all.surface_space),
            (Attribute::Displacement, &mut all.displacement_space),
            (Attribute::Atmosphere, &mut all.atmosphere_space),
        ];
        spaces.into_iter().filter(|(which, _)| set.has(*which)).for_each(|(_, space)| *space = to_instance * *space);
        for (which, volume) in [(Attribute::Interior, &mut all.interior), (Attribute::Exterior, &mut all.exterior)] {
            if let Some((_, space)) = volume.as_mut().filter(|_| set.has(which)) {
                *space = to_instance * *space;
            }
        }
        if let Some(corners) = all.detail_box.as_mut().filter(|_| set.has(Attribute::Detail)) {
            corners.iter_mut().for_each(|p| *p = to_instance.transform_point3(*p));
        }
        all
    }

    /// Whether what has these attributes is seen, and lit, as what has others.
    pub fn is_as(&self, other: &Attributes) -> bool {
        fn shader(a: &Arc<BoundShader>, b: &Arc<BoundShader>) -> bool {
            a.is_as(b)
        }
        fn maybe<T>(a: &Option<T>, b: &Option<T>, is_as: impl Fn(&T, &T) -> bool) -> bool {
            matches!((a, b), (None, None)) || a.as_ref().zip(b.as_ref()).is_some_and(|(a, b)| is_as(a, b))
        }
        type Volume = Option<(Arc<BoundShader>, Mat4)>;
        let volume = |a: &Volume, b: &Volume| maybe(a, b, |a, b| shader(&a.0, &b.0) && a.1 == b.1);
        macro_rules! are_same {
            ($($field:ident)*) => {{
                // All are named, so that none that comes later is forgotten.
                let Attributes {
                    $($field: _,)* set: _, surface: _, displacement: _, atmosphere: _, interior: _, exterior: _, lights: _,
                    light_list: _,
                } = self;
                true $(&& self.$field == other.$field)*
            }};
        }
        let are_same = are_same! {
            color opacity color_moves opacity_moves surface_space displacement_space displacement_bound fit atmosphere_space user
            texture_corners emitters area_light light_samples shading_rate smooth two_sided reversed matte visible casts_shadows
            whole_shadows shadows_of_opacity detail detail_box detail_range seen solid
        };
        are_same
            && shader(&self.surface, &other.surface)
            && maybe(&self.displacement, &other.displacement, shader)
            && maybe(&self.atmosphere, &other.atmosphere, shader)
            && volume(&self.interior, &other.interior)
            && volume(&self.exterior, &other.exterior)
            && self.light_list.len() == other.light_list.len()
            && self.light_list.iter().zip(other.light_list.iter()).all(|(a, b)| shader(a, b))
    }

    /// Whether its colour or opacity changes while the shutter is open.
    pub fn fades(&self) -> bool {
        !self.color_moves.is_empty() || !self.opacity_moves.is_empty()
    }

    /// The parts of the time that the shutter is open from which on its colour or opacity goes straight to that of the
    /// next, after the first.
    pub fn fade_times(&self) -> Vec<f32> {
        let mut times: Vec<f32> = self.color_moves.iter().chain(&self.opacity_moves).map(|(time, _)| *time).collect();
        times.sort_by(f32::total_cmp);
        times.dedup();
        if self.color_moves.is_empty() || self.opacity_moves.is_empty() {
            return times;
        }
        // Where both move, what a shader makes of them is not straight in between: their product is usual.
        let starts = std::iter::once(0.0).chain(times.iter().copied());
        let parts = starts.zip(&times).flat_map(|(from, to)| (1..=4).map(move |k| from + (to - from) * k as f32 / 4.0));
        parts.collect()
    }

    /// Colours and opacities of motion blocks as those of a shutter's time.
    pub fn open(&mut self, shutter: [f32; 2]) {
        for (first, moves) in [(&mut self.color, &mut self.color_moves), (&mut self.opacity, &mut self.opacity_moves)] {
            if !moves.is_empty() {
                (*first, *moves) = keys::in_shutter(moves, shutter);
            }
        }
    }

    /// Whether it is opaque and no shader makes it less, nor the time.
    pub fn stays_opaque(&self) -> bool {
        let program = &self.surface.program;
        let is_opaque = program.is_opaque || program.keeps_opacity && self.opacity == [1.0; 3];
        is_opaque && !self.fades() && self.atmosphere_keeps_opacity()
    }

    /// Whether no shader changes its opacity, nor the time.
    pub fn keeps_opacity(&self) -> bool {
        !self.fades() && self.surface_keeps_opacity() && self.atmosphere_keeps_opacity()
    }

    /// Whether the surface shader leaves the opacity as it is.
    pub fn surface_keeps_opacity(&self) -> bool {
        let program = &self.surface.program;
        program.keeps_opacity || program.is_opaque && self.opacity == [1.0; 3]
    }

    fn atmosphere_keeps_opacity(&self) -> bool {
        self.atmosphere.as_deref().is_none_or(|shader| shader.program.keeps_opacity)
    }

    /// Whether the colour of a point depends on the points beside it.
    pub fn reads_neighbours(&self) -> bool {
        let shaders = self.light_list.iter().chain(&self.atmosphere).chain([&self.surface]);
        shaders.into_iter().any(|shader| shader.program.reads_neighbours)
    }

    /// Whether it has the very shaders and lights of another.
    pub fn has_shaders_of(&self, other: &Attributes) -> bool {
        let alike = |a: &Option<Arc<BoundShader>>, b: &Option<Arc<BoundShader>>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        Arc::ptr_eq(&self.surface, &other.surface)
            && alike(&self.displacement, &other.displacement)
            && alike(&self.atmosphere, &other.atmosphere)
            && self.light_list.len() == other.light_list.len()
            && self.light_list.iter().zip(other.light_list.iter()).all(|(a, b)| Arc::ptr_eq(a, b))
    }

    /// Whether its surface shader says what a display shows of it: [`SHOWN`].
    pub fn is_shown(&self) -> bool {
        let params = &self.surface.program.params;
        let gives = |name: &str| params.iter().any(|p| p.output && p.kind == Kind::Color && p.name == name);
        !self.matte && SHOWN.into_iter().all(gives)
    }

    /// Whether it has volume shaders for rays.
    pub fn has_volumes(&self) -> bool {
        self.interior.is_some() || self.exterior.is_some()
    }

    /// Whether a shader that runs for the primitive sends rays.
    pub fn traces(&self) -> bool {
        let volumes = [&self.interior, &self.exterior].into_iter().flatten().map(|(shader, _)| shader);
        let shaders = self.light_list.iter().chain(&self.displacement).chain(&self.atmosphere).chain(volumes);
        shaders.chain([&self.surface]).any(|shader| shader.program.traces)
    }

    /// Whether rays meet it as displaced: `Attribute "trace" "displacements"`.
    pub fn traces_displaced(&self) -> bool {
        let set = self.user.iter().find(|(name, _)| name == "trace:displacements");
        !matches!(set, Some((_, sl::machine::Answer::Numbers(v))) if v.first() == Some(&0.0))
    }

    /// Whether a shader of the primitive reads u, v, s or t.
    pub fn reads_parameters(&self) -> bool {
        [Global::U, Global::V, Global::S, Global::T].into_iter().any(|global| self.reads(global))
    }

    /// Whether a shader that runs over its points uses a global variable.
    pub fn reads(&self, global: Global) -> bool {
        let shaders = [Some(&self.surface), self.displacement.as_ref(), self.atmosphere.as_ref()];
        shaders.into_iter().flatten().any(|shader| shader.program.global(global).is_some())
    }
}
