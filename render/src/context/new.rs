//! A context before its first call.

use crate::context::copies::Copies;
use crate::context::geometry::Geometry;
use crate::context::state::Context;
use crate::gprim::basis::BEZIER;
use crate::scene::area;
use crate::scene::attributes::{Attributes, SetAttributes};
use crate::scene::options::Options;
use crate::scene::patch::TEXTURE_CORNERS;
use crate::scene::world::Scene;
use glam::Mat4;
use ri::files::Files;
use ri::{Fail, Fit};
use sl::machine::BoundShader;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

impl Context {
    /// A renderer in its initial state (RISpec default options and attributes) that searches `files` for shaders and textures.
    pub fn new(files: Files) -> Result<Context, Fail> {
        let nothing = Arc::new(BoundShader::given(
            Arc::new(
                sl::compile(Path::new("constant.sl"), "surface constant() { Ci = Os * Cs; }")
                    .map_err(|e| Fail::new(e.to_string()))?,
            ),
            vec![],
            vec![],
        ));
        let mut context = Context {
            files,
            programs: HashMap::new(),
            options: Options::default(),
            saved: None,
            frame: 0,
            attributes: initial(nothing),
            attribute_stack: vec![],
            transform: Mat4::IDENTITY,
            moves: vec![],
            transform_stack: vec![],
            to_camera: None,
            camera_moves: vec![],
            geometry: Geometry { bases: (BEZIER, BEZIER), steps: [3, 3], trim: None, trims_inside: false },
            changes: 0,
            open_solids: vec![],
            n_given: 0,
            known_lights: vec![],
            before_world: Default::default(),
            declared: HashMap::new(),
            motion: None,
            made: HashMap::new(),
            sought: vec![],
            scene: Scene::default(),
            copies: Copies::default(),
            of_patches: None,
            of_instances: None,
            outside: [0; 2],
            objects: HashMap::new(),
            open_object: None,
            progress: Box::new(|_, _| {}),
            shard: None,
            image: None,
            allow_outside: false,
            about: vec![],
            device: None,
            keep_ids: false,
            dry: false,
            results: vec![],
        };
        context.attributes.surface = context.shader("defaultsurface", "surface", vec![])?;
        Ok(context)
    }
}

/// The attributes that a scene begins with (RISpec 5), with a surface shader.
fn initial(surface: Arc<BoundShader>) -> Attributes {
    Attributes {
        set: SetAttributes::default(),
        color: [1.0; 3],
        opacity: [1.0; 3],
        color_moves: vec![],
        opacity_moves: vec![],
        surface,
        surface_space: Mat4::IDENTITY,
        displacement: None,
        displacement_space: Mat4::IDENTITY,
        displacement_bound: None,
        atmosphere: None,
        fit: Fit::NONE,
        atmosphere_space: Mat4::IDENTITY,
        interior: None,
        exterior: None,
        user: Arc::default(),
        texture_corners: TEXTURE_CORNERS,
        lights: vec![],
        light_list: Arc::default(),
        emitters: Arc::default(),
        area_light: None,
        light_samples: area::SAMPLES,
        shading_rate: 1.0,
        smooth: true,
        two_sided: true,
        reversed: false,
        matte: false,
        visible: true,
        casts_shadows: true,
        whole_shadows: false,
        shadows_of_opacity: false,
        detail: f32::INFINITY,
        detail_box: None,
        detail_range: [0.0, 0.0, f32::INFINITY, f32::INFINITY],
        seen: [0.0, 1.0],
        solid: None,
    }
}
