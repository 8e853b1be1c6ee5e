//! The calls of the interface, each passed on to what it sets or makes.

use crate::context::motion_block::Moving;
use crate::context::state::{Context, positive};
use crate::gprim::quadric::Outline;
use crate::gprim::trim::trim;
use crate::scene::attributes::Attribute;
use crate::scene::trim::Trim;
use crate::texture::{self, Wrap};
use glam::{Mat4, Vec3};
use ri::{Fail, Instances, Knots, Params, Ri, RiResult, Tags, TrimCurves};
use sl::ir::Kind;
use std::path::Path;
use std::sync::Arc;

impl Ri for Context {
    fn version(&mut self, number: f32) -> RiResult {
        if !(3.0..4.0).contains(&number) {
            self.scene.warn(format!("version {number} of the RIB format, expected 3.04: it is read as that"));
        }
        Ok(())
    }
    fn declare(&mut self, name: &str, declaration: &str) -> RiResult {
        let kinds = [Kind::Float, Kind::Color, Kind::Point, Kind::Vector, Kind::Normal];
        let kind = kinds.into_iter().find(|k| declaration.split_whitespace().any(|word| word == k.name()));
        kind.map(|kind| self.declared.insert(name.into(), kind));
        Ok(())
    }
    fn frame_begin(&mut self, number: i32) -> RiResult {
        if self.is_world_open() {
            return Err(Fail::new("FrameBegin within a world, expected before WorldBegin"));
        }
        if self.saved.is_some() {
            return Err(Fail::new("FrameBegin within FrameBegin"));
        }
        self.frame = number;
        let attributes = (self.attributes.clone(), self.geometry.clone());
        self.saved = Some((self.options.clone(), attributes, self.known_lights.clone()));
        Ok(())
    }
    fn frame_end(&mut self) -> RiResult {
        if self.is_world_open() {
            return Err(Fail::new("FrameEnd before the WorldEnd of its world"));
        }
        if let Some((options, attributes, lights)) = self.saved.take() {
            self.options = options;
            (self.attributes, self.geometry) = attributes;
            self.known_lights = lights;
            (self.transform, self.moves) = (Mat4::IDENTITY, vec![]);
            return Ok(());
        }
        Err(Fail::new("FrameEnd without FrameBegin"))
    }
    fn world_begin(&mut self) -> RiResult {
        self.begin_world()
    }
    fn world_end(&mut self) -> RiResult {
        self.end_world()
    }
    fn attribute_begin(&mut self) -> RiResult {
        self.attribute_stack.push((self.attributes.clone(), self.place(), self.geometry.clone()));
        Ok(())
    }
    fn attribute_end(&mut self) -> RiResult {
        self.pop_attributes()
    }
    fn transform_begin(&mut self) -> RiResult {
        self.transform_stack.push(self.place());
        Ok(())
    }
    fn transform_end(&mut self) -> RiResult {
        if self.transform_stack.len() <= self.open_object.as_ref().map_or(0, |object| object.transforms()) {
            return Err(Fail::new("TransformEnd without TransformBegin"));
        }
        if let Some(place) = self.transform_stack.pop() {
            (self.transform, self.moves) = place;
        }
        Ok(())
    }
    fn object_begin(&mut self, handle: &str) -> RiResult {
        self.open_object(handle)
    }
    fn object_end(&mut self) -> RiResult {
        self.close_object()
    }
    fn object_instance(&mut self, handle: &str) -> RiResult {
        self.draw_object(handle)
    }
    fn format(&mut self, width: i32, height: i32, aspect: f32) -> RiResult {
        self.set_format(width, height, aspect)
    }
    fn frame_aspect_ratio(&mut self, ratio: f32) -> RiResult {
        positive(ratio, "the frame aspect ratio")?;
        self.options.frame_aspect = Some(ratio);
        self.options.fit_frame();
        Ok(())
    }
    fn screen_window(&mut self, left: f32, right: f32, bottom: f32, top: f32) -> RiResult {
        for (side, what) in [(right - left, "width"), (top - bottom, "height")] {
            if side == 0.0 || !side.is_finite() {
                return Err(Fail::new(format!("the screen window's {what} is {side}, expected another number than 0")));
            }
        }
        self.options.screen_window = Some([left, right, bottom, top]);
        Ok(())
    }
    fn projection(&mut self, name: &str, params: Params) -> RiResult {
        self.set_projection(name, params)
    }
    fn clipping(&mut self, near: f32, far: f32) -> RiResult {
        positive(near, "the near plane")?;
        positive(far - near, "the depth from near to far")?;
        (self.options.clipping, self.options.sees_near) = ([near, far], false);
        Ok(())
    }
    fn clipping_plane(&mut self, point: [f32; 3], normal: [f32; 3]) -> RiResult {
        self.add_clipping_plane(point.into(), normal.into())
    }
    fn shutter(&mut self, open: f32, close: f32) -> RiResult {
        if !(close >= open && open.is_finite() && close.is_finite()) {
            return Err(Fail::new(format!("the shutter opens at {open} and closes at {close}, expected rising times")));
        }
        self.options.shutter = [open, close];
        Ok(())
    }
    fn pixel_samples(&mut self, x: f32, y: f32) -> RiResult {
        self.set_pixel_samples(x, y)
    }
    fn pixel_filter(&mut self, name: &str, x_width: f32, y_width: f32) -> RiResult {
        self.set_pixel_filter(name, x_width, y_width)
    }
    fn exposure(&mut self, gain: f32, gamma: f32) -> RiResult {
        positive(gain, "the gain")?;
        positive(gamma, "gamma")?;
        (self.options.gain, self.options.gamma) = (gain, gamma);
        Ok(())
    }
    fn imager(&mut self, name: &str, params: Params) -> RiResult {
        self.options.imager = if name == "null" { None } else { Some(self.shader(name, "imager", params)?) };
        Ok(())
    }
    fn quantize(&mut self, kind: &str, one: i32, min: i32, max: i32, dither: f32) -> RiResult {
        self.set_quantize(kind, [one, min, max], dither)
    }
    fn display(&mut self, name: &str, kind: &str, mode: &str, params: Params) -> RiResult {
        self.add_display(name, kind, mode, params)
    }
    fn hider(&mut self, name: &str, params: Params) -> RiResult {
        self.set_hider(name, &params)
    }
    fn option(&mut self, name: &str, params: Params) -> RiResult {
        self.set_option(name, params)
    }
    fn attribute(&mut self, name: &str, params: Params) -> RiResult {
        self.set_attribute(name, params)
    }
    fn color(&mut self, color: [f32; 3]) -> RiResult {
        self.set_color(Attribute::Color, color)
    }
    fn opacity(&mut self, opacity: [f32; 3]) -> RiResult {
        self.set_color(Attribute::Opacity, opacity)
    }
    fn light_source(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        self.add_light(name, handle, params)?;
        if !self.moves.is_empty() {
            self.scene.warn(format!("the light `{name}` moves: it shines from where it is when the shutter opens"));
        }
        Ok(())
    }
    fn illuminate(&mut self, handle: &str, on: bool) -> RiResult {
        self.switch_light(handle, on)
    }
    fn surface(&mut self, name: &str, params: Params) -> RiResult {
        self.sets(Attribute::Surface);
        self.attributes.surface = self.shader(name, "surface", params)?;
        self.attributes.surface_space = self.transform;
        Ok(())
    }
    fn displacement(&mut self, name: &str, params: Params) -> RiResult {
        self.sets(Attribute::Displacement);
        self.attributes.displacement =
            if name == "null" { None } else { Some(self.shader(name, "displacement", params)?) };
        self.attributes.displacement_space = self.transform;
        Ok(())
    }
    fn area_light_source(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        self.add_area_light(name, handle, params)
    }
    fn atmosphere(&mut self, name: &str, params: Params) -> RiResult {
        self.sets(Attribute::Atmosphere);
        self.attributes.atmosphere =
            if name == "null" || name.is_empty() { None } else { Some(self.shader(name, "volume", params)?) };
        self.attributes.atmosphere_space = self.transform;
        Ok(())
    }
    fn interior(&mut self, name: &str, params: Params) -> RiResult {
        self.sets(Attribute::Interior);
        self.attributes.interior = self.volume(name, params)?;
        Ok(())
    }
    fn exterior(&mut self, name: &str, params: Params) -> RiResult {
        self.sets(Attribute::Exterior);
        self.attributes.exterior = self.volume(name, params)?;
        Ok(())
    }
    fn solid_begin(&mut self, operation: &str) -> RiResult {
        self.open_solid(operation)
    }
    fn solid_end(&mut self) -> RiResult {
        self.close_solid()
    }
    fn motion_begin(&mut self, times: Vec<f32>) -> RiResult {
        self.open_motion_block(times)
    }
    fn motion_end(&mut self) -> RiResult {
        let block = self.motion.take().ok_or(Fail::new("MotionEnd without MotionBegin"))?;
        self.close(block)
    }
    fn crop_window(&mut self, x_min: f32, x_max: f32, y_min: f32, y_max: f32) -> RiResult {
        positive(x_max - x_min, "the crop window's width")?;
        positive(y_max - y_min, "the crop window's height")?;
        if [x_min, x_max, y_min, y_max].iter().any(|x| !(0.0..=1.0).contains(x)) {
            let crop = format!("{x_min} {x_max} {y_min} {y_max}");
            self.scene
                .warn(format!("the crop window {crop} reaches beyond the image, which is 0 to 1: it is cut to that"));
        }
        self.options.crop = [x_min, x_max, y_min, y_max];
        Ok(())
    }
    fn depth_of_field(&mut self, f_stop: f32, length: f32, distance: f32) -> RiResult {
        self.set_depth_of_field(f_stop, length, distance)
    }
    fn detail(&self, bound: [f32; 6]) -> f32 {
        self.raster_area(self.corners_of(bound))
    }
    fn detail_bound(&mut self, bound: [f32; 6]) -> RiResult {
        self.attributes.detail_box = Some(self.corners_of(bound));
        self.level_changed();
        Ok(())
    }
    fn detail_range(&mut self, range: [f32; 4]) -> RiResult {
        if range.windows(2).any(|r| !(r[0] <= r[1])) {
            return Err(Fail::new(format!("DetailRange {range:?}: expected four numbers that do not fall")));
        }
        self.attributes.detail_range = range;
        self.level_changed();
        Ok(())
    }
    fn relative_detail(&mut self, factor: f32) -> RiResult {
        if !(factor >= 0.0 && factor.is_finite()) {
            return Err(Fail::new(format!("the relative detail is {factor}, expected 0 or more")));
        }
        self.options.relative_detail = factor;
        Ok(())
    }
    fn geometric_approximation(&mut self, kind: &str, _: f32) -> RiResult {
        if kind != "flatness" {
            self.scene.warn(format!("geometric approximation `{kind}` is not known, expected flatness"));
        }
        Ok(())
    }
    fn texture_coordinates(&mut self, corners: [f32; 8]) -> RiResult {
        self.sets(Attribute::TextureCorners);
        self.attributes.texture_corners = corners;
        Ok(())
    }
    fn color_samples(&mut self, to_rgb: Vec<f32>, from_rgb: Vec<f32>) -> RiResult {
        self.check_color_samples(to_rgb, from_rgb)
    }
    fn pixel_variance(&mut self, _: f32) -> RiResult {
        Ok(())
    }
    fn deformation(&mut self, name: &str, _: Params) -> RiResult {
        self.scene.warn(format!("deformation `{name}` is passed over"));
        Ok(())
    }
    fn error_handler(&mut self, name: &str) -> RiResult {
        match name {
            "print" => {}
            "ignore" | "abort" => self.scene.warn(format!("error handler `{name}` has no effect: errors are printed")),
            other => {
                return Err(Fail::new(format!("unknown error handler `{other}`, expected ignore, print or abort")));
            }
        }
        Ok(())
    }
    fn make_texture(&mut self, from: &str, to: &str, wraps: [&str; 2], _: &str, _: [f32; 2], _: Params) -> RiResult {
        let known = wraps.map(Wrap::of_name);
        let [Some(s), Some(t)] = known else {
            let [s, t] = wraps;
            return Err(Fail::new(format!("unknown wrap `{s}` `{t}`, expected black, clamp or periodic")));
        };
        self.make(to, texture::Source::Image(from.into(), [s, t]));
        Ok(())
    }
    fn make_lat_long_environment(&mut self, from: &str, to: &str, _: &str, _: [f32; 2], _: Params) -> RiResult {
        self.make(to, texture::Source::LatLong(from.into()));
        Ok(())
    }
    fn make_cube_face_environment(
        &mut self,
        from: Vec<String>,
        to: &str,
        fov: f32,
        _: &str,
        _: [f32; 2],
        _: Params,
    ) -> RiResult {
        self.add_cube_map(from, to, fov)
    }
    fn make_shadow(&mut self, _: &str, to: &str, _: Params) -> RiResult {
        self.scene.warn(format!("the shadow map `{to}` is not made: shadows are traced, whatever map a light names"));
        Ok(())
    }
    fn shading_rate(&mut self, size: f32) -> RiResult {
        positive(size, "the shading rate")?;
        self.sets(Attribute::ShadingRate);
        self.attributes.shading_rate = size.max(1e-3);
        Ok(())
    }
    fn shading_interpolation(&mut self, kind: &str) -> RiResult {
        self.set_interpolation(kind)
    }
    fn matte(&mut self, on: bool) -> RiResult {
        self.sets(Attribute::Matte);
        self.attributes.matte = on;
        Ok(())
    }
    fn bound(&mut self, _: [f32; 6]) -> RiResult {
        Ok(())
    }
    fn orientation(&mut self, kind: &str) -> RiResult {
        self.set_orientation(kind)
    }
    fn reverse_orientation(&mut self) -> RiResult {
        self.sets(Attribute::Orientation);
        self.attributes.reversed = !self.attributes.reversed;
        Ok(())
    }
    fn sides(&mut self, sides: i32) -> RiResult {
        if !matches!(sides, 1 | 2) {
            return Err(Fail::new(format!("sides is {sides}, expected 1 or 2")));
        }
        self.sets(Attribute::Sides);
        self.attributes.two_sided = sides == 2;
        Ok(())
    }
    fn identity(&mut self) -> RiResult {
        self.set_transform(Mat4::IDENTITY)
    }
    fn transform(&mut self, matrix: [f32; 16]) -> RiResult {
        let m = Mat4::from_cols_array(&matrix);
        if !m.is_finite() {
            return Err(Fail::new("the transformation is not finite"));
        }
        self.say_flat(&m, "the matrix of `Transform`");
        self.set_transform(m)
    }
    fn concat_transform(&mut self, matrix: [f32; 16]) -> RiResult {
        self.concat(Mat4::from_cols_array(&matrix), "the matrix of `ConcatTransform`")
    }
    fn perspective(&mut self, fov: f32) -> RiResult {
        self.concat_perspective(fov)
    }
    fn skew(&mut self, angle: f32, from: [f32; 3], to: [f32; 3]) -> RiResult {
        self.concat_skew(angle, from, to)
    }
    fn translate(&mut self, by: [f32; 3]) -> RiResult {
        self.concat(Mat4::from_translation(by.into()), "`Translate`")
    }
    fn rotate(&mut self, angle: f32, axis: [f32; 3]) -> RiResult {
        let axis = match Vec3::from(axis).try_normalize() {
            Some(axis) => axis,
            // No turn needs no axis.
            None if angle == 0.0 => Vec3::Z,
            None => return Err(Fail::new("the axis of a rotation is zero")),
        };
        match &mut self.motion {
            Some(block) if angle.is_finite() => block.calls.push(Moving::Turn(axis, angle.to_radians())),
            _ => return self.concat(Mat4::from_axis_angle(axis, angle.to_radians()), "`Rotate`"),
        }
        Ok(())
    }
    fn scale(&mut self, by: [f32; 3]) -> RiResult {
        self.concat(Mat4::from_scale(by.into()), &format!("`Scale {} {} {}`", by[0], by[1], by[2]))
    }
    fn coordinate_system(&mut self, name: &str) -> RiResult {
        self.scene.spaces.insert(name.into(), self.to_world());
        Ok(())
    }
    fn coord_sys_transform(&mut self, name: &str) -> RiResult {
        let of_camera = self.to_camera.map_or(Mat4::IDENTITY, |m| m.inverse());
        let space = self.scene.spaces.get(name).copied().or_else(|| match name {
            "camera" | "eye" => Some(of_camera),
            "world" if self.to_camera.is_some() => Some(Mat4::IDENTITY),
            "object" | "current" => Some(self.transform),
            "shader" => Some(self.attributes.surface_space),
            _ => None,
        });
        self.set_transform(space.ok_or(Fail::new(format!("there is no coordinate system `{name}`")))?)
    }
    fn polygon(&mut self, params: Params) -> RiResult {
        self.draw_polygon(self.variables(params)?)
    }
    fn general_polygon(&mut self, n_vertices: Vec<i32>, params: Params) -> RiResult {
        self.draw_general_polygon(n_vertices, self.variables(params)?)
    }
    fn points_general_polygons(
        &mut self,
        n_loops: Vec<i32>,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        params: Params,
    ) -> RiResult {
        self.draw_points_general_polygons(n_loops, n_vertices, vertices, self.variables(params)?)
    }
    fn points_polygons(&mut self, n_vertices: Vec<i32>, vertices: Vec<i32>, params: Params) -> RiResult {
        if n_vertices.is_empty() {
            return self.draw_nothing("`PointsPolygons`");
        }
        self.draw_points_polygons(n_vertices, vertices, self.variables(params)?)
    }
    fn basis(&mut self, u: [f32; 16], u_step: i32, v: [f32; 16], v_step: i32) -> RiResult {
        if !(1..=4).contains(&u_step) || !(1..=4).contains(&v_step) {
            return Err(Fail::new(format!("steps {u_step} and {v_step} of a basis, expected 1 to 4")));
        }
        self.geometry.bases = (u, v);
        self.geometry.steps = [u_step as usize, v_step as usize];
        Ok(())
    }
    fn patch(&mut self, kind: &str, params: Params) -> RiResult {
        self.say_texts(&params);
        self.draw_patch(kind, params)
    }
    fn patch_mesh(&mut self, kind: &str, nu: i32, u_wrap: &str, nv: i32, v_wrap: &str, params: Params) -> RiResult {
        self.say_texts(&params);
        self.draw_patch_mesh(kind, nu, u_wrap, nv, v_wrap, params)
    }
    fn nu_patch(&mut self, u: Knots, v: Knots, params: Params) -> RiResult {
        self.say_texts(&params);
        self.draw_nu_patch(u, v, params)
    }
    fn trim_curve(&mut self, curves: TrimCurves) -> RiResult {
        let outside = self.geometry.trims_inside;
        let (trim, open) = trim(&curves)?;
        if let Some(k) = open {
            self.scene.warn(format!("loop {k} of `TrimCurve` is not closed: its ends are joined by straight lines"));
        }
        self.geometry.trim = trim.map(|trim| Arc::new(Trim { outside, ..trim }));
        Ok(())
    }
    fn cone(&mut self, height: f32, radius: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(Outline::Line(Vec3::new(radius, 0.0, 0.0), Vec3::new(0.0, 0.0, height)), sweep, params)
    }
    fn cylinder(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(Outline::Line(Vec3::new(radius, 0.0, z_min), Vec3::new(radius, 0.0, z_max)), sweep, params)
    }
    fn hyperboloid(&mut self, from: [f32; 3], to: [f32; 3], sweep: f32, params: Params) -> RiResult {
        self.quadric(Outline::Line(from.into(), to.into()), sweep, params)
    }
    fn paraboloid(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(Outline::Parabola(radius, [z_min, z_max]), sweep, params)
    }
    fn disk(&mut self, height: f32, radius: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(Outline::Line(Vec3::new(radius, 0.0, height), Vec3::new(0.0, 0.0, height)), sweep, params)
    }
    fn torus(&mut self, major: f32, minor: f32, phi_min: f32, phi_max: f32, sweep: f32, params: Params) -> RiResult {
        let angles = [phi_min, phi_max].map(f32::to_radians);
        self.quadric(Outline::Circle([major, 0.0], minor, angles), sweep, params)
    }
    fn points(&mut self, params: Params) -> RiResult {
        if params.iter().any(|p| matches!(p.decl.name.as_str(), "P" | "Pw") && p.numbers().is_empty()) {
            return self.draw_nothing("`Points`");
        }
        self.draw_points(self.variables(params)?)
    }
    fn curves(&mut self, kind: &str, n_vertices: Vec<i32>, wrap: &str, params: Params) -> RiResult {
        if n_vertices.is_empty() {
            return self.draw_nothing("`Curves`");
        }
        self.draw_curves(kind, n_vertices, wrap, self.variables(params)?)
    }
    fn subdivision_mesh(
        &mut self,
        scheme: &str,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        tags: Tags,
        params: Params,
    ) -> RiResult {
        self.draw_subdivision_mesh(scheme, n_vertices, vertices, tags, self.variables(params)?)
    }
    fn blobby(&mut self, leaves: i32, codes: Vec<i32>, floats: Vec<f32>, _: Vec<String>, params: Params) -> RiResult {
        self.say_texts(&params);
        self.draw_blobby(leaves, codes, floats, params)
    }
    fn geometry(&mut self, name: &str, params: Params) -> RiResult {
        self.say_texts(&params);
        self.draw_geometry(name, params)
    }
    fn warn(&mut self, message: String) {
        self.scene.warnings.add_placed(message);
    }
    fn stands_at(&mut self, place: Option<(&Path, (usize, usize))>) {
        self.scene.warnings.set_place(place);
    }
    fn sphere(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.say_texts(&params);
        self.draw_sphere(radius, z_min, z_max, sweep, params)
    }
    fn instances(&mut self, instances: Instances) -> RiResult {
        self.draw_instances(instances)
    }
    fn archive_record(&mut self, _: &str, _: &str) -> RiResult {
        Ok(())
    }
}
