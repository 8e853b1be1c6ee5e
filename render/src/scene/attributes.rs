//! Attributes of primitives (RISpec section 5).

use crate::scene::area::Emitter;
use glam::Mat4;
use sl::Global;
use sl::machine::BoundShader;
use std::sync::Arc;

/// Attributes of a primitive.
#[derive(Clone)]
pub struct Attributes {
    /// Colour.
    pub color: [f32; 3],
    /// Opacity.
    pub opacity: [f32; 3],
    /// Surface shader.
    pub surface: Arc<BoundShader>,
    /// The surface shader's space.
    pub surface_space: Mat4,
    /// Displacement shader.
    pub displacement: Option<Arc<BoundShader>>,
    /// The displacement shader's space.
    pub displacement_space: Mat4,
    /// Greatest displacement, in object units; if not given, a tenth of the primitive.
    pub displacement_bound: Option<f32>,
    /// Atmosphere shader.
    pub atmosphere: Option<Arc<BoundShader>>,
    /// The atmosphere shader's space.
    pub atmosphere_space: Mat4,
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
    /// Square pixels that the bound of `Detail` covers, and the range of these in which primitives are seen.
    pub detail: f32,
    /// From none to all, and from all to none.
    pub detail_range: [f32; 4],
    /// How much of the level of detail is seen.
    pub level: f32,
}

impl Attributes {
    /// Whether it is opaque and no shader makes it less.
    pub fn stays_opaque(&self) -> bool {
        let kept = |shader: &BoundShader| shader.program.keeps_opacity;
        self.opacity == [1.0; 3] && kept(&self.surface) && self.atmosphere.as_deref().is_none_or(kept)
    }

    /// Whether no light gets through it.
    pub fn blocks_light(&self) -> bool {
        self.whole_shadows || (self.opacity == [1.0; 3] && self.surface.program.keeps_opacity)
    }

    /// Whether the colour of a point depends on the points beside it.
    pub fn reads_neighbours(&self) -> bool {
        let shaders = self.light_list.iter().chain(&self.atmosphere).chain([&self.surface]);
        shaders.into_iter().any(|shader| shader.program.reads_neighbours)
    }

    /// Whether a shader of the primitive reads u, v, s or t.
    pub fn reads_parameters(&self) -> bool {
        let mut shaders =
            [Some(&self.surface), self.displacement.as_ref(), self.atmosphere.as_ref()].into_iter().flatten();
        shaders.any(|shader| {
            [Global::U, Global::V, Global::S, Global::T].iter().any(|g| shader.program.global(*g).is_some())
        })
    }
}
