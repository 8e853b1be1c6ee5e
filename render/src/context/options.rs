//! Calls that set options.

use crate::context::state::{Context, positive};
use crate::film::display::{Display, Layer, stores_floats};
use crate::film::filter::FilterKind;
use crate::film::image::LONGEST_SIDE;
use crate::scene::options::Hider;
use crate::texture;
use glam::{Mat3, Mat4, Vec3};
use ri::{Fail, Params, RiResult, Values};
use sl::machine::Answer;
use std::path::{Component, Path};

/// Whether a type of display is a window.
fn is_window(kind: &str) -> bool {
    matches!(kind, "framebuffer" | "it" | "x11" | "windows")
}

/// Whether an option has its effect, or none on the image.
fn is_known_option(group: &str, name: &str) -> bool {
    match group {
        "limits" => matches!(name, "bucketsize" | "gridsize" | "texturememory"),
        "trace" => matches!(name, "maxdepth" | "maxdiffusedepth"),
        "texture" => name == "colorspace",
        "sky" => matches!(name, "sun" | "turbidity"),
        "quality" => matches!(name, "sky" | "sun"),
        "film" => matches!(name, "view" | "levels"),
        "imager" => name == "exposed",
        "searchpath" | "user" => true,
        _ => false,
    }
}

/// The maximum of pixels of an image: it is in memory whole, 16 bytes each.
const MAX_PIXELS: i64 = 1 << 28;

/// Longest name of a file of a display, bytes: the file is first written under a longer one.
const LONGEST_NAME: usize = 200;

impl Context {
    /// Size of the image.
    pub(super) fn set_format(&mut self, width: i32, height: i32, aspect: f32) -> RiResult {
        let fits = |side: i32| usize::try_from(side).is_ok_and(|n| (1..=LONGEST_SIDE).contains(&n));
        if !fits(width) || !fits(height) {
            let message = format!("format {width}×{height}: expected 1 to {LONGEST_SIDE} pixels along each side");
            return Err(Fail::new(message));
        }
        if width as i64 * height as i64 > MAX_PIXELS {
            let max = MAX_PIXELS / 1_000_000;
            return Err(Fail::new(format!("format {width}×{height}: expected at most {max} million pixels")));
        }
        self.options.format = [width as usize, height as usize];
        // Below 0 is that of the device (RISpec 4.1.2).
        if aspect == 0.0 || !aspect.is_finite() {
            self.scene.warn(format!("the pixel aspect ratio is {aspect}, expected above 0: 1 is taken"));
        }
        self.options.pixel_aspect = if aspect > 0.0 && aspect.is_finite() { aspect } else { 1.0 };
        self.options.fit_frame();
        Ok(())
    }

    /// Another clipping plane, through a point; what its normal points to is clipped.
    pub(super) fn add_clipping_plane(&mut self, point: Vec3, normal: Vec3) -> RiResult {
        let m = self.to_camera.unwrap_or(Mat4::IDENTITY) * self.transform;
        let turned = Mat3::from_mat4(m).inverse().transpose() * normal;
        let Some(turned) = turned.try_normalize().filter(|n| n.is_finite() && point.is_finite()) else {
            return Err(Fail::new("the normal of a clipping plane is zero or cannot be transformed"));
        };
        self.options.clipping_planes.push(turned.extend(-turned.dot(m.transform_point3(point))));
        Ok(())
    }

    /// The projection; it starts the camera's transformation.
    pub(super) fn set_projection(&mut self, name: &str, params: Params) -> RiResult {
        // A projection of its own gives an angle, too, but is one.
        let has_perspective = self.options.fov.is_some() && !self.options.projected;
        match name {
            "perspective" => {
                let fov = params
                    .iter()
                    .find(|p| p.decl.name == "fov")
                    .map_or(90.0, |p| p.numbers().first().copied().unwrap_or(90.0));
                if !(fov > 0.0 && fov < 179.9) {
                    return Err(Fail::new(format!("fov is {fov}, expected an angle between 0 and 179.9 degrees")));
                }
                self.options.fov = Some(fov);
            }
            "orthographic" => self.options.fov = None,
            other => {
                return Err(Fail::new(format!("unknown projection `{other}`, expected perspective or orthographic")));
            }
        }
        self.say_unused("projection", params.iter().filter(|p| p.decl.name != "fov"));
        if has_perspective {
            self.scene.warn("the `Perspective` before `Projection` is passed over".into());
        }
        // The projection comes after what was current, which is then a transformation of screen space, and starts the camera's own
        // (RISpec 4.1.1).
        let m = if self.options.projected { Mat4::IDENTITY } else { self.transform };
        let turns = [m.x_axis.y, m.x_axis.w, m.y_axis.x, m.y_axis.w, m.z_axis.x, m.z_axis.y, m.z_axis.w];
        if turns.iter().any(|x| *x != 0.0)
            || m.x_axis.x * m.y_axis.y == 0.0
            || (m != Mat4::IDENTITY && !self.moves.is_empty())
        {
            let kept = "only scales and shifts that do not move are followed there";
            self.scene
                .warn(format!("the transformation before `Projection` turns, shears or moves the screen: {kept}"));
        } else if !self.options.projected {
            self.options.screen = [[m.x_axis.x, m.y_axis.y], [m.w_axis.x, m.w_axis.y]];
        }
        self.options.projected = true;
        (self.transform, self.moves) = (Mat4::IDENTITY, vec![]);
        Ok(())
    }

    /// Samples of a pixel.
    pub(super) fn set_pixel_samples(&mut self, x: f32, y: f32) -> RiResult {
        for n in [x, y] {
            if !(1.0..=64.0).contains(&n) {
                return Err(Fail::new(format!("{n} samples along a pixel, expected 1 to 64")));
            }
        }
        self.options.samples = [x as usize, y as usize];
        Ok(())
    }

    /// The pixel filter.
    pub(super) fn set_pixel_filter(&mut self, name: &str, x_width: f32, y_width: f32) -> RiResult {
        self.options.filter = FilterKind::of_name(name).ok_or(Fail::new(format!(
            "unknown filter `{name}`, expected box, triangle, gaussian, catmull-rom, sinc, mitchell, disk or bessel"
        )))?;
        for width in [x_width, y_width] {
            if !(1.0..=16.0).contains(&width) {
                return Err(Fail::new(format!("filter width {width}, expected 1 to 16 pixels")));
            }
        }
        self.options.filter_width = [x_width, y_width];
        Ok(())
    }

    /// Another display, or the first of new ones.
    pub(super) fn add_display(&mut self, name: &str, kind: &str, mode: &str, params: Params) -> RiResult {
        let further = name.starts_with('+');
        let name = name.trim_start_matches('+');
        if !further {
            self.options.displays.clear();
            self.options.unsupported_display = false;
        }
        let message = match kind {
            "zfile" | "shadow" | "deepshad" => {
                Some(format!("the shadow map `{name}` is not made: shadows are traced, whatever map a light names"))
            }
            kind if further && is_window(kind) => Some(format!("`{name}` is not shown: there is no window")),
            _ => None,
        };
        if let Some(message) = message {
            self.scene.warn(message);
            self.options.unsupported_display = true;
            return Ok(());
        }
        let is_file = Path::new(name).file_name().is_some() && !name.ends_with(['/', '\\', '.']);
        let fits = Path::new(name).components().all(|part| part.as_os_str().len() <= LONGEST_NAME);
        let is_own = self.image.as_deref() == Some(name);
        if !is_own && (!(is_file && fits) || name.contains(char::is_control)) {
            return Err(Fail::new(format!("the display `{}` is no name of a file", name.escape_debug())));
        }
        let stays_inside = Path::new(name).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !stays_inside && !self.allow_outside && !is_own {
            let name = name.escape_debug();
            return Err(Fail::new(format!(
                "the display `{name}` would be written outside of the output folder; --allow-outside allows it"
            )));
        }
        let depth = params.iter().find(|p| matches!(p.decl.name.as_str(), "type" | "exrpixeltype"));
        let half = match depth.map(|p| p.text()) {
            None | Some(Some("float")) => false,
            Some(Some("half")) => true,
            _ => return Err(Fail::new("the display's numbers: expected \"string type\" \"half\" or \"float\"")),
        };
        let is_known =
            |p: &&ri::Param| !matches!(p.decl.name.as_str(), "type" | "exrpixeltype" | "quantize" | "dither");
        self.say_unused("display", params.iter().filter(is_known));
        let mode = Display::with_type(mode, &self.declared).map_err(Fail::new)?;
        let quantize = params.iter().find(|p| p.decl.name == "quantize").map(|p| match *p.numbers() {
            [zero, one, min, max] => Ok([zero, one, min, max].map(|x| x as i32)),
            _ => Err(Fail::new("the display's quantize: expected the values of 0 and 1, the least and the greatest")),
        });
        let dither = params.iter().find(|p| p.decl.name == "dither").and_then(|p| p.numbers().first().copied());
        let quantize = quantize.transpose()?;
        let display = Display { name: name.into(), kind: kind.into(), mode, half, quantize, dither };
        if let Some(message) = display.stands_in().filter(|_| !is_window(kind) && !is_own) {
            self.scene.warn(message);
        }
        if display.format() != "exr" && self.options.displays.iter().any(|d| d.name == name) {
            return Err(Fail::new(format!("two displays are named `{name}`: only EXR files have layers")));
        }
        // A window that is not there gives way to a file beside it.
        self.options.displays.retain(|other| !is_window(&other.kind));
        self.options.displays.push(display);
        Ok(())
    }

    /// Say which displays keep depths as levels, of which all beyond 1 are the greatest.
    pub(super) fn say_levels_of_depths(&self) {
        let is_depth = |layer: &Layer| matches!(layer, Layer::Aov(aov) if aov.name == "z");
        let is_cut = |display: &&Display| {
            let ([_, one, min, max], _) = display.levels(&self.options.quantization());
            let levels = [0, one, min, max];
            !stores_floats(display.format(), levels) && display.layers().iter().any(is_depth)
        };
        for display in self.options.displays.iter().filter(is_cut) {
            self.scene.warn(format!(
                "the depths of `{}` are levels from 0 to 1, and all beyond are 1: EXR keeps them, and TIFF where they are floats",
                display.name
            ));
        }
    }

    /// Say that parameters of a request have no effect.
    fn say_unused<'a>(&mut self, what: &str, params: impl IntoIterator<Item = &'a ri::Param>) {
        for param in params {
            self.scene.warn(format!("parameter `{}` of the {what} has no effect", param.decl.name));
        }
    }

    /// The levels of colours or of depths: the value of 1, the least, the greatest and the dither.
    pub(super) fn set_quantize(&mut self, kind: &str, [one, min, max]: [i32; 3], dither: f32) -> RiResult {
        if one < 0 || min < 0 || min > max || max > 65535 || one > 65535 {
            return Err(Fail::new(format!(
                "Quantize {one} {min} {max}: expected levels from 0 to 65535 that do not fall"
            )));
        }
        match kind {
            "rgba" | "rgb" => {
                (self.options.quantize_one, self.options.dither) = (one, dither);
                self.options.quantize_range = [min, max];
            }
            "z" => self.options.quantize_depth = ([0, one, min, max], dither),
            other => self.scene.warn(format!("`Quantize \"{other}\"` is not known, expected rgba or z")),
        }
        Ok(())
    }

    /// The hider.
    pub(super) fn set_hider(&mut self, name: &str, params: &Params) -> RiResult {
        let has_effect = |p: &&ri::Param| p.decl.name != "jitter" || p.numbers().first() == Some(&0.0);
        self.say_unused("hider", params.iter().filter(has_effect));
        self.options.hider = match name {
            "hidden" => Hider::Hidden,
            "z" | "zbuffer" | "depth" => Hider::Depth,
            "null" => Hider::Null,
            _ => {
                self.scene.warn(format!("hider `{name}` is not known, expected hidden, z or null: `hidden` is taken"));
                Hider::Hidden
            }
        };
        Ok(())
    }

    /// An option of a group.
    pub(super) fn set_option(&mut self, name: &str, params: Params) -> RiResult {
        if name == "limits"
            && let Some(size) = params.iter().find(|p| p.decl.name == "bucketsize").and_then(|p| p.numbers().first())
        {
            self.options.bucket_size = (*size as usize).clamp(8, 512);
        }
        if name == "limits"
            && let Some(kib) = params.iter().find(|p| p.decl.name == "texturememory").and_then(|p| p.numbers().first())
        {
            positive(*kib, "the texture memory")?;
            self.options.texture_memory = (*kib as usize).saturating_mul(1024);
        }
        if name == "texture"
            && let Some(space) = params.iter().find(|p| p.decl.name == "colorspace").and_then(|p| p.text())
        {
            self.options.texture_encoded = match space {
                "linear" => Some(false),
                "srgb" | "sRGB" => Some(true),
                other => return Err(Fail::new(format!("unknown colour space `{other}`, expected linear or srgb"))),
            };
        }
        if name == "searchpath" {
            // Folders, separated by colons; `&` and `@` stand for what is searched anyway.
            for text in params.iter().filter_map(|p| p.text()) {
                for folder in text.split(':').filter(|f| !matches!(*f, "" | "&" | "@")) {
                    let known: Vec<_> = self.files.folders.clone();
                    for base in &known {
                        let place = base.join(folder);
                        if place.is_dir() && !self.files.folders.contains(&place) {
                            self.files.folders.push(place);
                        }
                    }
                }
            }
        }
        for param in params {
            if !is_known_option(name, &param.decl.name) {
                let option = format!("{name}:{}", param.decl.name);
                let message =
                    format!("option `{option}` is not supported: shaders may ask for it, it has no other effect");
                self.scene.warn(message);
            }
            let answer = answer_of(param.values);
            for key in [format!("{name}:{}", param.decl.name), param.decl.name.clone()] {
                self.scene.options.retain(|(n, _)| *n != key);
                self.scene.options.push((key, answer.clone()));
            }
        }
        Ok(())
    }

    /// The lens.
    pub(super) fn set_depth_of_field(&mut self, f_stop: f32, length: f32, distance: f32) -> RiResult {
        self.options.lens = None;
        if f_stop.is_finite() {
            positive(f_stop, "the f-stop")?;
            positive(length, "the focal length")?;
            positive(distance, "the focal distance")?;
            if length >= distance {
                return Err(Fail::new(format!(
                    "the focal length is {length}, expected less than the focal distance, {distance}: nothing nearer is in focus"
                )));
            }
            self.options.lens = Some([f_stop, length, distance]);
        }
        Ok(())
    }

    /// Colours have three samples.
    pub(super) fn check_color_samples(&mut self, to_rgb: Vec<f32>, from_rgb: Vec<f32>) -> RiResult {
        if to_rgb.len() != from_rgb.len() || to_rgb.is_empty() || !to_rgb.len().is_multiple_of(3) {
            return Err(Fail::new("ColorSamples takes two lists of three numbers a sample"));
        }
        if to_rgb.len() != 9 {
            return Err(Fail::new(format!("colours of {} samples are not supported: three are", to_rgb.len() / 3)));
        }
        Ok(())
    }

    /// An environment map of six faces.
    pub(super) fn add_cube_map(&mut self, from: Vec<String>, to: &str, fov: f32) -> RiResult {
        if !(fov > 0.0 && fov < 179.9) {
            return Err(Fail::new(format!("fov is {fov}, expected an angle between 0 and 179.9 degrees")));
        }
        let n = from.len();
        let faces: Result<[String; 6], _> = from.try_into();
        let faces = faces.map_err(|_| Fail::new(format!("{n} faces of a cube, expected 6")))?;
        self.make(to, texture::Source::CubeFaces(faces.map(Into::into), fov));
        Ok(())
    }

    /// Make a texture, whose images are looked for as the world begins: until then the search path may change.
    pub(super) fn make(&mut self, name: &str, source: texture::Source) {
        self.sought.push((name.into(), source.clone(), self.scene.warnings.spot()));
        self.made.insert(name.into(), source);
    }

    /// Say which textures were made of files that there are not, or that are no whole images, whether or not they are used: those of the world
    /// are read.
    pub(super) fn say_missing_images(&mut self) {
        for (name, source, spot) in self.sought.drain(..) {
            if let Some(path) = source.missing(&self.files.folders) {
                let path = path.display();
                let message = format!("the texture `{name}` is black: there is no image `{path}` to make it of");
                self.scene.warnings.add_at(spot, message);
                continue;
            }
            if self.made.get(&name) == Some(&source) {
                self.scene.textures.fault(&name).into_iter().for_each(|why| self.scene.warnings.add_at(spot, why));
            } else if let Some((path, why)) = source.unreadable(&self.files.folders) {
                let message = format!("texture `{name}` cannot be read and is black: `{}`: {why}", path.display());
                self.scene.warnings.add_at(spot, message);
            }
        }
    }
}

/// What shaders that ask for an option or an attribute of these values are answered.
pub(super) fn answer_of(values: Values) -> Answer {
    match values {
        Values::Floats(v) => Answer::Numbers(v),
        Values::Strings(v) if v.len() > 1 => Answer::Texts(v),
        Values::Strings(v) => Answer::Text(v.into_iter().next().unwrap_or_default()),
    }
}
