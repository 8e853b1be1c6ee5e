//! The world around the shaders that are compared: coordinate systems, what blocks light, what is asked by name; for the grid machine
//! and, with the same formulas, for kernels.

use glam::{Mat4, Vec3};
use sl::ir::{Ask, Lookup};
use sl::machine::{Answer, BoundShader, MapQuery, Ray, Scene, Segment};
use sl::wgsl::Query;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A world with lights.
#[derive(Default)]
pub struct World {
    pub lights: Vec<Arc<BoundShader>>,
    pub warnings: Mutex<Vec<String>>,
}

/// From a coordinate system to the current one.
fn to_current(name: &str) -> Option<Mat4> {
    Some(match name {
        "current" | "world" => Mat4::IDENTITY,
        "object" => Mat4::from_translation(Vec3::new(0.3, -0.2, 0.7)) * Mat4::from_rotation_y(0.4),
        "shape" => Mat4::from_translation(Vec3::new(0.3, -0.2, 0.7)) * Mat4::from_scale(Vec3::new(0.2, 0.3, 0.4)),
        "shader" => Mat4::from_rotation_x(-0.7) * Mat4::from_scale(Vec3::new(1.0, 2.0, 0.5)),
        "camera" => Mat4::from_translation(Vec3::new(0.0, 0.0, -4.0)) * Mat4::from_rotation_z(0.2),
        "screen" | "raster" | "NDC" => {
            Mat4::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.3, 0.0, 0.0, 0.0, 0.0, 1.1, -0.4, 0.0, 0.0, 2.0, 5.0])
        }
        _ => return None,
    })
}

impl Scene for World {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &self.lights
    }
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]> {
        Some((to_current(to)?.inverse() * to_current(from)?).to_cols_array())
    }
    fn transmission(&self, segments: &[Segment], light: &mut [[f32; 3]]) {
        for (s, light) in segments.iter().zip(light) {
            let x = 0.5 + 0.4 * (2.0 * s.from[0] + s.to[1]).sin();
            *light = [x, x * 0.9, x * x];
        }
    }
    fn hit(&self, rays: &[Ray], distances: &mut [Option<f32>]) {
        for (ray, distance) in rays.iter().zip(distances) {
            *distance = (ray.direction[2] > 0.3717).then_some(1.0 + ray.direction[0] * ray.from[1]);
        }
    }
    fn shutter(&self) -> [f32; 2] {
        [0.25, 0.75]
    }
    fn eye(&self) -> [f32; 3] {
        [1.0, 2.0, -3.0]
    }
    fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        match (what, names[0]) {
            (Ask::Option, "Clipping") => Some(Answer::Numbers(vec![0.5, 20.0])),
            (Ask::Option, "Format") => Some(Answer::Numbers(vec![640.0, 480.0, 1.0])),
            (Ask::Option, "user:dim") => Some(Answer::Numbers(vec![0.25])),
            (Ask::Attribute, "ShadingRate") => Some(Answer::Numbers(vec![0.25])),
            (Ask::Attribute, "identifier:name") => Some(Answer::Text("pebble".into())),
            (Ask::Surface | Ask::Displacement, "Km") => Some(Answer::Numbers(vec![0.125])),
            (Ask::RayInfo, "depth") => Some(Answer::Numbers(vec![0.0])),
            (Ask::ShaderName, "surface") => Some(Answer::Text("matte".into())),
            _ => None,
        }
    }
    fn map(&self, queries: &[MapQuery<'_>], values: &mut [[f32; 4]]) {
        for (q, values) in queries.iter().zip(values) {
            let light = q.light.map_or(0.0, |l| l[0] - 0.5 * l[2]);
            let a = Vec3::from(q.at) + 3.0 * Vec3::from(q.change[0]) - 2.0 * Vec3::from(q.change[1]);
            let x = self.map_number(q.how, q.name) as f32 + a.dot(Vec3::new(0.3, 0.7, -0.2)) * q.width + 0.01 * light;
            let others = q.blur[0] - 2.0 * q.blur[1] + q.fill + 0.1 * q.samples + q.bias;
            *values = [x, x + others, x * 0.5 + q.channel as f32, 1.0 + q.how as usize as f32];
        }
    }
    fn map_number(&self, how: Lookup, name: &str) -> u32 {
        name.len() as u32 + if how == Lookup::Shadow { 3 } else { 0 }
    }
    fn warn(&self, message: String) {
        self.warnings.lock().unwrap().push(message);
    }
    fn stop(&self, message: &str) {
        self.warnings.lock().unwrap().push(message.into());
    }
}

/// The same as WGSL.
pub const FUNCTIONS: [(Query, &str); 4] = [
    (
        Query::Map,
        "fn scene_map(map: u32, q: Lookup) -> vec4<f32> {
    let light = select(0.0, q.light.x - 0.5 * q.light.z, q.has_light);
    let a = q.at + 3.0 * q.row - 2.0 * q.column;
    let x = f32(map) + dot(a, vec3<f32>(0.3, 0.7, -0.2)) * q.width + 0.01 * light;
    let others = q.blur.x - 2.0 * q.blur.y + q.fill + 0.1 * q.samples + q.bias;
    return vec4<f32>(x, x + others, x * 0.5 + f32(q.channel), 1.0 + f32(q.how));
}",
    ),
    (
        Query::Transmission,
        "fn scene_transmission(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    let x = 0.5 + 0.4 * sl_sin(2.0 * start.x + end.y);
    return vec3<f32>(x, x * 0.9, x * x);
}",
    ),
    (
        Query::Openness,
        "fn scene_openness(place: vec3<f32>, normal: vec3<f32>, up: vec3<f32>) -> vec3<f32> {
    let above = clamp(0.5 + 0.5 * dot(normal, up), 0.0, 1.0);
    return vec3<f32>(above, 2.0 / 3.0 * sl_power(above, 1.651496), 1.0 - above);
}

fn scene_surroundings(place: vec3<f32>, normal: vec3<f32>, up: vec3<f32>, sun: vec3<f32>) -> mat4x4<f32> {
    return mat4x4<f32>(vec4<f32>(scene_openness(place, normal, up), 0.0), vec4<f32>(), vec4<f32>(), vec4<f32>());
}",
    ),
    (
        Query::Hit,
        "fn scene_hit(start: vec3<f32>, direction: vec3<f32>) -> f32 {
    return select(-1.0, 1.0 + direction.x * start.y, direction.z > 0.3717);
}",
    ),
];

/// The repository's root.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Compile a shader, which may include files of the library.
pub fn program(path: &Path, source: &str) -> Result<sl::ir::Program, String> {
    let program = sl::compile_with(path, source, &|name, _| {
        let path = root().join("shaders/include").join(name);
        std::fs::read_to_string(&path).map(|text| (path, text)).map_err(|e| e.to_string())
    });
    program.map_err(|e| e.to_string())
}

/// A shader with its default parameters.
pub fn bind(source: &str) -> Arc<BoundShader> {
    let program = program(Path::new("test.sl"), source).unwrap_or_else(|e| {
        eprintln!("{e}\n{source}");
        panic!("{e}")
    });
    Arc::new(BoundShader::new(Arc::new(program), vec![], vec![], &World::default()))
}

/// The shader of a file, with its default parameters.
pub fn bind_file(path: &Path) -> Result<Arc<BoundShader>, String> {
    let source = std::fs::read_to_string(path).unwrap();
    let program = program(path, &source)?;
    Ok(Arc::new(BoundShader::new(Arc::new(program), vec![], vec![], &World::default())))
}
