//! The camera of a frame: its projection, and where it has gone.

use super::wrong::{Origin, Wrong};
use super::{archive, keys};
use crate::binding::{Binding, Camera, Formula, Placed, Projection};
use crate::expr::Expr;
use frame::{Fault, FaultKind, Frame};
use glam::{Mat4, Quat, Vec3};
use ri::files::Files;
use ri::{Class, Fail, Param, Ri, Type};

/// The depths at which nothing is seen, m, where a camera is not nearer than 0.2 m to what it looks at.
const NEAR: f32 = 1e-3;
const FAR: f32 = 1e30;

/// Where the camera of a frame stands, and what it looks at, m.
#[derive(Clone, Copy, Debug)]
pub struct Stand {
    /// The eye.
    pub eye: [f32; 3],
    /// The point that it looks at.
    pub at: [f32; 3],
    /// Perspective or parallel projection.
    pub projection: Projection,
}

impl Stand {
    /// The middle and the size of a floor under what the camera looks at: the distance of the eye, in parallel projection at least the
    /// extent.
    pub(super) fn floor(self) -> ([f32; 2], f32) {
        let far = (Vec3::from(self.at) - Vec3::from(self.eye)).length();
        let size = match self.projection {
            Projection::Parallel(height) => height,
            Projection::Perspective(_) => far,
        };
        ([self.at[0], self.at[1]], size)
    }
}

/// Metres across the image's shorter side at what the camera looks at, before it goes anywhere; none of a camera from a file.
pub(super) fn view(binding: &Binding) -> Option<f32> {
    let Some(Camera::Placed(camera)) = &binding.camera else { return None };
    Some(match camera.projection {
        Projection::Parallel(height) => height,
        Projection::Perspective(fov) => {
            let far = (Vec3::from(camera.look_at) - Vec3::from(camera.eye)).length();
            2.0 * far * (0.5 * fov).to_radians().tan()
        }
    })
}

/// The largest length of these steps and a power of ten, m, of which the view has `most` or more; 1 of a camera from a file. It is the same
/// in all frames.
pub(super) fn unit(binding: &Binding, steps: &[f32], most: f32) -> f32 {
    let Some(view) = view(binding) else { return 1.0 };
    let fits = view / most * (1.0 + 1e-5);
    let power = 10f32.powi(fits.log10().floor() as i32);
    steps.iter().map(|step| step * power).find(|length| *length <= fits).unwrap_or(power)
}

/// The width of the lines of the `i`th object, m: as it is given, or as the view has room for.
pub(super) fn width(binding: &Binding, i: usize, geometry: &str, given: Option<f64>) -> Result<f32, Fault> {
    /// Part of the view.
    const WIDTH: f32 = 0.007;
    given.map(|width| width as f32).or_else(|| Some(WIDTH * view(binding)?)).ok_or_else(|| {
        let message = "the file's camera does not say how much it sees: give `width`, m";
        binding.doc.fault(&format!("objects.{i}.geometry.{geometry}.width"), message)
    })
}

/// Projection and world-to-camera matrix.
pub(super) fn inject(
    binding: &Binding,
    number: u64,
    stand: Option<Stand>,
    files: &Files,
    ri: &mut dyn Ri,
) -> Result<(), Wrong> {
    let (camera, Stand { mut eye, mut at, projection }) = match (&binding.camera, stand) {
        (Some(Camera::Placed(camera)), Some(stand)) => (camera, stand),
        (Some(Camera::File(file)), _) => {
            let at = Origin { binding, key: "camera.file", object: None };
            return archive::include(&numbered(file, number), files, at, ri);
        }
        _ => {
            let message = "the scene wants a camera, but the metadata has none: add `camera: {eye: …, look_at: …}`";
            return Err(Fail::new(message).into());
        }
    };
    let shift = if camera.aside == 0.0 { 0.0 } else { step_aside(camera, projection, &mut eye, &mut at) };
    match projection {
        Projection::Parallel(height) => {
            let [w, h] = binding.output.resolution.map(|n| n as f32);
            let (x, y) =
                if w >= h { (0.5 * height * w / h, 0.5 * height) } else { (0.5 * height, 0.5 * height * h / w) };
            ri.screen_window(-x, x, -y, y)?;
            ri.projection("orthographic", vec![])?;
        }
        Projection::Perspective(fov) => {
            if shift != 0.0 {
                let [w, h] = binding.output.resolution.map(|n| n as f32);
                let (x, y) = if w >= h { (w / h, 1.0) } else { (1.0, h / w) };
                ri.screen_window(shift - x, shift + x, -y, y)?;
            }
            ri.projection("perspective", vec![Param::floats("fov", Class::Uniform, Type::Float, [fov])])?;
        }
    }
    // What is looked at is before the near plane, however small it is.
    let near = (Vec3::from(at) - Vec3::from(eye)).length() / 200.0;
    if near < NEAR {
        ri.clipping(near, FAR)?;
    }
    if let Some(lens) = &camera.lens {
        let focus = lens.focus.unwrap_or((Vec3::from(at) - Vec3::from(eye)).length());
        ri.depth_of_field(lens.f_stop, lens.focal_length, focus)?;
    }
    Ok(ri.concat_transform(look_at(eye, at, camera.up).to_cols_array())?)
}

/// Move a camera to the side, for an eye of a stereo pair; gives how far its window on the screen is moved back, so that what is looked at
/// stays at its place.
fn step_aside(camera: &Placed, projection: Projection, eye: &mut [f32; 3], at: &mut [f32; 3]) -> f32 {
    let way = Vec3::from(*at) - Vec3::from(*eye);
    let step = camera.aside * way.cross(camera.up.into()).normalize();
    for place in [eye, at] {
        *place = (Vec3::from(*place) + step).into();
    }
    match projection {
        Projection::Perspective(fov) => -camera.aside / (way.length() * (fov / 2.0).to_radians().tan()),
        Projection::Parallel(_) => 0.0,
    }
}

/// Where the camera stands in a frame, if the binding places it. That it follows rows which the frame does not have is a fault of the data.
pub(super) fn stand(binding: &Binding, frame: &Frame) -> Result<Option<Stand>, Fault> {
    match &binding.camera {
        Some(Camera::Placed(camera)) => moved(binding, camera, frame).map(Some),
        _ => Ok(None),
    }
}

fn moved(binding: &Binding, camera: &Placed, frame: &Frame) -> Result<Stand, Fault> {
    let (mut eye, mut at, up, mut projection) = (camera.eye, camera.look_at, camera.up, camera.projection);
    if let Some([a, b, c, d, e, f, fov]) = keys::view(&camera.keys, frame.number as f64) {
        (eye, at) = ([a, b, c], [d, e, f]);
        if let Projection::Perspective(angle) = &mut projection {
            *angle = fov;
        }
    }
    if !(Vec3::from(at) - Vec3::from(eye)).cross(up.into()).length().is_normal() {
        let message = format!("in frame {} the camera stands where it looks at, or looks along `up`", frame.number);
        return Err(binding.doc.fault("camera.keys", message));
    }
    if let Some(degrees) = camera.orbit {
        // About the direction that is up, counter-clockwise as seen from there.
        let angle = (degrees as f64 * frame.number as f64 % 360.0).to_radians() as f32;
        let turn = Quat::from_axis_angle(Vec3::from(up).normalize(), angle);
        eye = (Vec3::from(at) + turn * (Vec3::from(eye) - Vec3::from(at))).into();
    }
    if let Some(follow) = &camera.follow {
        let middle = match camera.way.get(&frame.number) {
            Some(place) => *place,
            None => followed(binding, follow, frame)?,
        };
        for k in 0..3 {
            eye[k] += middle[k] as f32;
            at[k] += middle[k] as f32;
        }
    }
    if let Some(lens) = &camera.lens {
        lens.check(&binding.doc, (Vec3::from(at) - Vec3::from(eye)).length(), Some(frame.number))?;
    }
    Ok(Stand { eye, at, projection })
}

/// The mean position of the rows that a camera follows, turned as the data is. That there is none is a fault of the data.
pub(super) fn followed(binding: &Binding, follow: &Formula, frame: &Frame) -> Result<[f64; 3], Fault> {
    let mut middle = [0.0; 3];
    let fault = |message: String| binding.doc.fault(&follow.key, message);
    let rows = follow.expr.select(frame).map_err(fault)?;
    for (k, name) in ["pos_x", "pos_y", "pos_z"].into_iter().enumerate() {
        let mut values = Expr::column(name).numbers(frame, &rows).map_err(fault)?;
        values.retain(|x| x.is_finite());
        if values.is_empty() {
            let message =
                format!("the camera follows `{}`, which no row of frame {} is", follow.expr.text, frame.number);
            return Err(Fault { kind: FaultKind::Data, ..fault(message) });
        }
        middle[k] = values.iter().sum::<f64>() / values.len() as f64;
    }
    Ok(binding.up.turn(middle))
}

/// A file's name with the frame's number for `{frame}`, or with N digits for `{frame:0N}`.
fn numbered(file: &str, number: u64) -> String {
    let parts = file.split_once("{frame").and_then(|(before, rest)| Some((before, rest.split_once('}')?)));
    let Some((before, (format, after))) = parts else { return file.into() };
    let digits = format.strip_prefix(":0").and_then(|n| n.parse().ok()).unwrap_or(0usize).min(20);
    format!("{before}{number:0digits$}{after}")
}

/// World to camera: x right, y up, z forward.
fn look_at(eye: [f32; 3], at: [f32; 3], up: [f32; 3]) -> Mat4 {
    let (eye, at) = (Vec3::from(eye), Vec3::from(at));
    let forward = (at - eye).normalize();
    let right = forward.cross(up.into()).normalize();
    let up = right.cross(forward);
    let turn = Mat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), glam::Vec4::W).transpose();
    turn * Mat4::from_translation(-eye)
}
