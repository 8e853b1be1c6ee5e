//! Shaders by their names: found, compiled once, and given the parameters of a call.

use crate::context::programs::program;
use crate::context::state::Context;
use crate::texture;
use glam::{Mat4, Vec3};
use ri::{Fail, Params, Values};
use sl::ir::{Ask, Kind};
use sl::machine::{Answer, BoundShader};
use std::cell::OnceCell;
use std::sync::Arc;

/// The shader of a kind that does nothing (RISpec A.1): of a surface, that its light leaves as it is.
fn null(kind: &str) -> String {
    let body = if kind == "surface" { "Oi = Os; Ci = Os * Cs;" } else { "" };
    format!("{kind} null() {{ {body} }}")
}

/// Evaluates parameter defaults: knows the spaces of the current point of the stream, and has no lights.
struct BindScene<'a> {
    context: &'a Context,
    /// Of a default whose loops do not end, what is said.
    stopped: OnceCell<String>,
}

impl sl::machine::Scene for BindScene<'_> {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &[]
    }
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]> {
        let to_world = |space: &str| match space {
            "current" | "world" => Some(Mat4::IDENTITY),
            "shader" | "object" | "shape" => Some(self.context.to_world()),
            "camera" | "eye" => Some(self.context.to_camera.unwrap_or(Mat4::IDENTITY).inverse()),
            named => self.context.scene.spaces.get(named).copied(),
        };
        Some((to_world(to)?.inverse() * to_world(from)?).to_cols_array())
    }
    fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        self.context.scene.ask(what, names)
    }
    fn shutter(&self) -> [f32; 2] {
        self.context.options.shutter
    }
    fn eye(&self) -> [f32; 3] {
        let to_world = self.context.to_camera.unwrap_or(Mat4::IDENTITY).inverse();
        to_world.transform_point3(Vec3::ZERO).to_array()
    }
    fn print(&self, text: &str) {
        self.context.scene.print(text);
    }
    fn warn(&self, message: String) {
        self.context.scene.warn(message);
    }
    fn stop(&self, message: &str) {
        let _ = self.stopped.set(message.into());
    }
    fn is_stopped(&self) -> bool {
        self.stopped.get().is_some()
    }
}

impl Context {
    /// The names of the parameters of the shader `name`, in their order. `kind` is `surface`, `displacement`, `light`, `volume` or
    /// `imager`. An error if the shader is not found or does not compile.
    pub fn shader_parameters(&mut self, name: &str, kind: &str) -> Result<Vec<String>, Fail> {
        Ok(self.shader(name, kind, vec![])?.program.params.iter().map(|p| p.name.clone()).collect())
    }

    /// Load, compile and bind a shader.
    pub(super) fn shader(&mut self, name: &str, kind: &str, params: Params) -> Result<Arc<BoundShader>, Fail> {
        let file = if name.ends_with(".sl") { name.to_string() } else { format!("{name}.sl") };
        // A surface and a displacement may have the same name.
        let key = format!("{kind}/{file}");
        let program = match self.programs.get(&key) {
            Some(program) => program.clone(),
            None => {
                let rooms = [format!("shaders/{kind}"), "shaders".into()];
                let rooms: Vec<&str> = rooms.iter().map(String::as_str).collect();
                let (path, source) = if name == "null" {
                    ("null.sl".into(), null(kind))
                } else {
                    self.files.read_source(&file, &rooms).map_err(|m| Fail::new(format!("{kind} shader {m}")))?
                };
                let program = program(path, source, &self.files).map_err(|d| Fail::new(format!("in shader {d}")))?;
                for what in &program.unsupported {
                    self.scene.warn(format!("{kind} shader `{name}` {what}"));
                }
                self.programs.entry(key).or_insert(program).clone()
            }
        };
        if program.kind.name() != kind {
            return Err(Fail::new(format!("`{name}` is a {} shader, expected a {kind} shader", program.kind.name())));
        }
        let (mut numbers, mut texts) = (Vec::new(), Vec::new());
        for param in params.into_iter().filter(|_| name != "null") {
            let Some(i) = program.params.iter().position(|p| p.name == param.decl.name) else {
                self.scene.warn(format!("{kind} shader `{name}` has no parameter `{}`", param.decl.name));
                continue;
            };
            let wanted = program.params[i].kind;
            match param.values {
                Values::Strings(v) if wanted == Kind::Text => {
                    let (name, n) = (&param.decl.name, program.params[i].array.unwrap_or(1) as usize);
                    if v.is_empty() || v.len() > n {
                        return Err(Fail::new(format!("parameter `{name}` has {} strings, expected {n}", v.len())));
                    }
                    texts.push((i, v))
                }
                Values::Floats(v) if wanted != Kind::Text => {
                    let array = program.params[i].array;
                    numbers.push((i, self.to_current(wanted, array, &v, &param.decl.name)?))
                }
                _ => {
                    return Err(Fail::new(format!(
                        "parameter `{}` of `{name}` has the wrong type, expected {}",
                        param.decl.name,
                        wanted.name()
                    )));
                }
            }
        }
        if self.dry {
            // Maps are looked up when the image is rendered.
            let names = program.texts().into_iter().chain(texts.iter().flat_map(|(_, texts)| texts.clone()));
            names.for_each(|name| texture::note(&name, &self.made, &self.files.folders));
        }
        let scene = BindScene { context: self, stopped: OnceCell::new() };
        let bound = BoundShader::new(program, numbers, texts, &scene);
        scene.stopped.into_inner().map_or_else(|| Ok(Arc::new(bound)), |message| Err(Fail::new(message)))
    }

    /// A volume shader and its space; none of the name `null` or without one.
    pub(super) fn volume(&mut self, name: &str, params: Params) -> Result<Option<(Arc<BoundShader>, Mat4)>, Fail> {
        if name.is_empty() || name == "null" {
            return Ok(None);
        }
        Ok(Some((self.shader(name, "volume", params)?, self.transform)))
    }

    /// A parameter's numbers in world space; points and directions are given in the current one.
    fn to_current(&self, kind: Kind, array: Option<u16>, v: &[f32], name: &str) -> Result<Vec<f32>, Fail> {
        let width = kind.width() * array.unwrap_or(1) as usize;
        // An array may be given in part.
        if v.len() != width && (array.is_none() || v.len() > width || !v.len().is_multiple_of(kind.width())) {
            return Err(Fail::new(format!("parameter `{name}` has {} numbers, expected {width}", v.len())));
        }
        let m = self.to_world();
        let normals = glam::Mat3::from_mat4(m).inverse().transpose();
        let mut out = Vec::with_capacity(width);
        for v in v.chunks_exact(kind.width()) {
            match kind {
                Kind::Point => out.extend(m.transform_point3(Vec3::new(v[0], v[1], v[2])).to_array()),
                Kind::Vector => out.extend(m.transform_vector3(Vec3::new(v[0], v[1], v[2])).to_array()),
                Kind::Normal => out.extend((normals * Vec3::new(v[0], v[1], v[2])).to_array()),
                _ => out.extend(v),
            }
        }
        out.resize(width, 0.0);
        Ok(out)
    }
}
