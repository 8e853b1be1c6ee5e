//! An [`Ri`] that writes the calls as ASCII RIB, indented; instance arrays become standard calls.

use crate::binary::Encoder;
use crate::{Fail, Knots, Param, Params, Ri, RiResult, Tags, TrimCurves, Values};
use std::fmt::Write as _;
use std::io::Write;

/// Writes RIB to `out`.
pub struct Writer<W: Write> {
    out: W,
    indent: usize,
    line: String,
    handles: Vec<String>,
    /// Makes the bytestream of ASCII.
    encoder: Option<Encoder>,
}

impl<W: Write> Writer<W> {
    /// A writer onto `out`; starts with the structure comment and the version.
    pub fn new(out: W) -> Result<Writer<W>, Fail> {
        let mut writer = Writer::archive(out);
        writer.put("##RenderMan RIB-Structure 1.1")?;
        writer.put("version 3.04")?;
        Ok(writer)
    }

    /// A writer of an archive, which is read into other RIB and has no head of its own.
    pub fn archive(out: W) -> Writer<W> {
        Writer { out, indent: 0, line: String::new(), handles: vec![], encoder: None }
    }

    /// A writer of the binary bytestream.
    pub fn binary(out: W) -> Result<Writer<W>, Fail> {
        let mut writer = Writer { encoder: Some(Encoder::default()), ..Writer::archive(out) };
        writer.put("version 3.04")?;
        Ok(writer)
    }

    /// What it wrote onto.
    pub fn into_inner(self) -> W {
        self.out
    }

    fn put(&mut self, request: &str) -> RiResult {
        if let Some(encoder) = &mut self.encoder {
            let bytes = encoder.encode(request)?;
            return self.out.write_all(&bytes).map_err(|e| Fail::new(format!("RIB cannot be written: {e}")));
        }
        writeln!(self.out, "{:indent$}{request}", "", indent = self.indent)
            .map_err(|e| Fail::new(format!("RIB cannot be written: {e}")))
    }

    fn begin(&mut self, request: &str) -> RiResult {
        self.put(request)?;
        self.indent += 2;
        Ok(())
    }

    fn end(&mut self, request: &str) -> RiResult {
        self.indent = self.indent.saturating_sub(2);
        self.put(request)
    }

    /// A handle as a number: the specification's lights and objects have no names. Names are numbered as they come, from 1001,
    /// where the small numbers that people write do not reach.
    fn number_of(&mut self, handle: &str) -> String {
        if handle.parse::<i32>().is_ok() {
            return handle.into();
        }
        let known = self.handles.iter().position(|h| h == handle).unwrap_or_else(|| {
            self.handles.push(handle.into());
            self.handles.len() - 1
        });
        (1001 + known).to_string()
    }

    fn put_with(&mut self, head: &str, params: &[Param]) -> RiResult {
        let mut line = std::mem::take(&mut self.line);
        line.clear();
        line.push_str(head);
        for param in params {
            let _ = write!(line, " {} [", quote(&param.decl.inline()));
            match &param.values {
                Values::Floats(v) => append_numbers(&mut line, v),
                Values::Strings(v) => line.push_str(&v.iter().map(|s| quote(s)).collect::<Vec<_>>().join(" ")),
            }
            line.push(']');
        }
        let done = self.put(&line);
        self.line = line;
        done
    }

    fn put_gprim(&mut self, request: &str, numbers: &[f32], params: &[Param]) -> RiResult {
        let mut head = format!("{request} ");
        append_numbers(&mut head, numbers);
        self.put_with(&head, params)
    }

    fn put_numbers(&mut self, request: &str, numbers: &[f32]) -> RiResult {
        let mut line = format!("{request} ");
        append_numbers(&mut line, numbers);
        self.put(&line)
    }

    fn put_matrix(&mut self, request: &str, numbers: &[f32]) -> RiResult {
        let mut line = format!("{request} [");
        append_numbers(&mut line, numbers);
        line.push(']');
        self.put(&line)
    }
}

fn bracket(numbers: &[f32]) -> String {
    let mut line = String::from("[");
    append_numbers(&mut line, numbers);
    line + "]"
}

fn strings(values: &[String]) -> String {
    format!("[{}]", values.iter().map(|s| quote(s)).collect::<Vec<_>>().join(" "))
}

fn append_numbers(line: &mut String, numbers: &[f32]) {
    for (i, x) in numbers.iter().enumerate() {
        let _ = write!(line, "{}{x}", if i > 0 { " " } else { "" });
    }
}

fn list(values: &[i32]) -> String {
    format!("[{}]", values.iter().map(i32::to_string).collect::<Vec<_>>().join(" "))
}

fn quote(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}

impl<W: Write> Ri for Writer<W> {
    fn version(&mut self, _: f32) -> RiResult {
        Ok(())
    }
    fn declare(&mut self, name: &str, declaration: &str) -> RiResult {
        self.put(&format!("Declare {} {}", quote(name), quote(declaration)))
    }
    fn frame_begin(&mut self, number: i32) -> RiResult {
        self.begin(&format!("FrameBegin {number}"))
    }
    fn frame_end(&mut self) -> RiResult {
        self.end("FrameEnd")
    }
    fn world_begin(&mut self) -> RiResult {
        self.begin("WorldBegin")
    }
    fn world_end(&mut self) -> RiResult {
        self.end("WorldEnd")
    }
    fn attribute_begin(&mut self) -> RiResult {
        self.begin("AttributeBegin")
    }
    fn attribute_end(&mut self) -> RiResult {
        self.end("AttributeEnd")
    }
    fn transform_begin(&mut self) -> RiResult {
        self.begin("TransformBegin")
    }
    fn transform_end(&mut self) -> RiResult {
        self.end("TransformEnd")
    }
    fn object_begin(&mut self, handle: &str) -> RiResult {
        let number = self.number_of(handle);
        self.begin(&format!("ObjectBegin {}", number))
    }
    fn object_end(&mut self) -> RiResult {
        self.end("ObjectEnd")
    }
    fn object_instance(&mut self, handle: &str) -> RiResult {
        let number = self.number_of(handle);
        self.put(&format!("ObjectInstance {}", number))
    }
    fn solid_begin(&mut self, operation: &str) -> RiResult {
        self.begin(&format!("SolidBegin {}", quote(operation)))
    }
    fn solid_end(&mut self) -> RiResult {
        self.end("SolidEnd")
    }
    fn motion_begin(&mut self, times: Vec<f32>) -> RiResult {
        self.put_matrix("MotionBegin", &times)?;
        self.indent += 2;
        Ok(())
    }
    fn motion_end(&mut self) -> RiResult {
        self.end("MotionEnd")
    }
    fn format(&mut self, width: i32, height: i32, aspect: f32) -> RiResult {
        self.put(&format!("Format {width} {height} {aspect}"))
    }
    fn frame_aspect_ratio(&mut self, ratio: f32) -> RiResult {
        self.put_numbers("FrameAspectRatio", &[ratio])
    }
    fn screen_window(&mut self, left: f32, right: f32, bottom: f32, top: f32) -> RiResult {
        self.put_numbers("ScreenWindow", &[left, right, bottom, top])
    }
    fn crop_window(&mut self, x_min: f32, x_max: f32, y_min: f32, y_max: f32) -> RiResult {
        self.put_numbers("CropWindow", &[x_min, x_max, y_min, y_max])
    }
    fn projection(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Projection {}", quote(name)), &params)
    }
    fn clipping(&mut self, near: f32, far: f32) -> RiResult {
        self.put_numbers("Clipping", &[near, far])
    }
    fn depth_of_field(&mut self, f_stop: f32, focal_length: f32, focal_distance: f32) -> RiResult {
        if f_stop.is_infinite() {
            self.put("DepthOfField")
        } else {
            self.put_numbers("DepthOfField", &[f_stop, focal_length, focal_distance])
        }
    }
    fn shutter(&mut self, open: f32, close: f32) -> RiResult {
        self.put_numbers("Shutter", &[open, close])
    }
    fn pixel_samples(&mut self, x: f32, y: f32) -> RiResult {
        self.put_numbers("PixelSamples", &[x, y])
    }
    fn pixel_filter(&mut self, name: &str, x_width: f32, y_width: f32) -> RiResult {
        self.put_numbers(&format!("PixelFilter {}", quote(name)), &[x_width, y_width])
    }
    fn exposure(&mut self, gain: f32, gamma: f32) -> RiResult {
        self.put_numbers("Exposure", &[gain, gamma])
    }
    fn imager(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Imager {}", quote(name)), &params)
    }
    fn quantize(&mut self, kind: &str, one: i32, min: i32, max: i32, dither: f32) -> RiResult {
        self.put(&format!("Quantize {} {one} {min} {max} {dither}", quote(kind)))
    }
    fn display(&mut self, name: &str, kind: &str, mode: &str, params: Params) -> RiResult {
        self.put_with(&format!("Display {} {} {}", quote(name), quote(kind), quote(mode)), &params)
    }
    fn hider(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Hider {}", quote(name)), &params)
    }
    fn option(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Option {}", quote(name)), &params)
    }
    fn attribute(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Attribute {}", quote(name)), &params)
    }
    fn color(&mut self, color: [f32; 3]) -> RiResult {
        self.put_matrix("Color", &color)
    }
    fn opacity(&mut self, opacity: [f32; 3]) -> RiResult {
        self.put_matrix("Opacity", &opacity)
    }
    fn light_source(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        let number = self.number_of(handle);
        self.put_with(&format!("LightSource {} {}", quote(name), number), &params)
    }
    fn area_light_source(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        let number = self.number_of(handle);
        self.put_with(&format!("AreaLightSource {} {}", quote(name), number), &params)
    }
    fn illuminate(&mut self, handle: &str, on: bool) -> RiResult {
        let number = self.number_of(handle);
        self.put(&format!("Illuminate {} {}", number, on as i32))
    }
    fn surface(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Surface {}", quote(name)), &params)
    }
    fn displacement(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Displacement {}", quote(name)), &params)
    }
    fn atmosphere(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Atmosphere {}", quote(name)), &params)
    }
    fn interior(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Interior {}", quote(name)), &params)
    }
    fn exterior(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Exterior {}", quote(name)), &params)
    }
    fn shading_rate(&mut self, size: f32) -> RiResult {
        self.put_numbers("ShadingRate", &[size])
    }
    fn shading_interpolation(&mut self, kind: &str) -> RiResult {
        self.put(&format!("ShadingInterpolation {}", quote(kind)))
    }
    fn matte(&mut self, on: bool) -> RiResult {
        self.put(&format!("Matte {}", on as i32))
    }
    fn bound(&mut self, bound: [f32; 6]) -> RiResult {
        self.put_matrix("Bound", &bound)
    }
    fn orientation(&mut self, kind: &str) -> RiResult {
        self.put(&format!("Orientation {}", quote(kind)))
    }
    fn reverse_orientation(&mut self) -> RiResult {
        self.put("ReverseOrientation")
    }
    fn sides(&mut self, sides: i32) -> RiResult {
        self.put(&format!("Sides {sides}"))
    }
    fn identity(&mut self) -> RiResult {
        self.put("Identity")
    }
    fn transform(&mut self, matrix: [f32; 16]) -> RiResult {
        self.put_matrix("Transform", &matrix)
    }
    fn concat_transform(&mut self, matrix: [f32; 16]) -> RiResult {
        self.put_matrix("ConcatTransform", &matrix)
    }
    fn perspective(&mut self, fov: f32) -> RiResult {
        self.put_numbers("Perspective", &[fov])
    }
    fn translate(&mut self, by: [f32; 3]) -> RiResult {
        self.put_numbers("Translate", &by)
    }
    fn rotate(&mut self, angle: f32, [x, y, z]: [f32; 3]) -> RiResult {
        self.put_numbers("Rotate", &[angle, x, y, z])
    }
    fn scale(&mut self, by: [f32; 3]) -> RiResult {
        self.put_numbers("Scale", &by)
    }
    fn skew(&mut self, angle: f32, [a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> RiResult {
        self.put_matrix("Skew", &[angle, a, b, c, d, e, f])
    }
    fn coordinate_system(&mut self, name: &str) -> RiResult {
        self.put(&format!("CoordinateSystem {}", quote(name)))
    }
    fn coord_sys_transform(&mut self, name: &str) -> RiResult {
        self.put(&format!("CoordSysTransform {}", quote(name)))
    }
    fn polygon(&mut self, params: Params) -> RiResult {
        self.put_with("Polygon", &params)
    }
    fn general_polygon(&mut self, n_vertices: Vec<i32>, params: Params) -> RiResult {
        self.put_with(&format!("GeneralPolygon {}", list(&n_vertices)), &params)
    }
    fn points_polygons(&mut self, n_vertices: Vec<i32>, vertices: Vec<i32>, params: Params) -> RiResult {
        self.put_with(&format!("PointsPolygons {} {}", list(&n_vertices), list(&vertices)), &params)
    }
    fn points_general_polygons(
        &mut self,
        n_loops: Vec<i32>,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        params: Params,
    ) -> RiResult {
        self.put_with(
            &format!("PointsGeneralPolygons {} {} {}", list(&n_loops), list(&n_vertices), list(&vertices)),
            &params,
        )
    }
    fn basis(&mut self, u: [f32; 16], u_step: i32, v: [f32; 16], v_step: i32) -> RiResult {
        let mut line = String::from("Basis [");
        append_numbers(&mut line, &u);
        let _ = write!(line, "] {u_step} [");
        append_numbers(&mut line, &v);
        let _ = write!(line, "] {v_step}");
        self.put(&line)
    }
    fn patch(&mut self, kind: &str, params: Params) -> RiResult {
        self.put_with(&format!("Patch {}", quote(kind)), &params)
    }
    fn patch_mesh(&mut self, kind: &str, nu: i32, u_wrap: &str, nv: i32, v_wrap: &str, params: Params) -> RiResult {
        self.put_with(&format!("PatchMesh {} {nu} {} {nv} {}", quote(kind), quote(u_wrap), quote(v_wrap)), &params)
    }
    fn sphere(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.put_with(&format!("Sphere {radius} {z_min} {z_max} {sweep}"), &params)
    }
    fn cone(&mut self, height: f32, radius: f32, sweep: f32, params: Params) -> RiResult {
        self.put_gprim("Cone", &[height, radius, sweep], &params)
    }
    fn cylinder(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.put_gprim("Cylinder", &[radius, z_min, z_max, sweep], &params)
    }
    fn hyperboloid(&mut self, [a, b, c]: [f32; 3], [d, e, f]: [f32; 3], sweep: f32, params: Params) -> RiResult {
        self.put_gprim("Hyperboloid", &[a, b, c, d, e, f, sweep], &params)
    }
    fn paraboloid(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.put_gprim("Paraboloid", &[radius, z_min, z_max, sweep], &params)
    }
    fn disk(&mut self, height: f32, radius: f32, sweep: f32, params: Params) -> RiResult {
        self.put_gprim("Disk", &[height, radius, sweep], &params)
    }
    fn torus(&mut self, major: f32, minor: f32, phi_min: f32, phi_max: f32, sweep: f32, params: Params) -> RiResult {
        self.put_gprim("Torus", &[major, minor, phi_min, phi_max, sweep], &params)
    }
    fn points(&mut self, params: Params) -> RiResult {
        self.put_with("Points", &params)
    }
    fn curves(&mut self, kind: &str, n_vertices: Vec<i32>, wrap: &str, params: Params) -> RiResult {
        self.put_with(&format!("Curves {} {} {}", quote(kind), list(&n_vertices), quote(wrap)), &params)
    }
    fn nu_patch(&mut self, u: Knots, v: Knots, params: Params) -> RiResult {
        let mut head = String::from("NuPatch");
        for k in [u, v] {
            let _ = write!(head, " {} {} {} {} {}", k.n, k.order, bracket(&k.knots), k.range[0], k.range[1]);
        }
        self.put_with(&head, &params)
    }
    fn trim_curve(&mut self, t: TrimCurves) -> RiResult {
        let numbers = [&t.u, &t.v, &t.w].map(|v| bracket(v)).join(" ");
        let (order, n) = (list(&t.order), list(&t.n));
        let head = format!("TrimCurve {} {order} {}", list(&t.n_curves), bracket(&t.knot));
        self.put(&format!("{head} {} {} {n} {numbers}", bracket(&t.min), bracket(&t.max)))
    }
    fn subdivision_mesh(
        &mut self,
        scheme: &str,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        tags: Tags,
        params: Params,
    ) -> RiResult {
        let names = strings(&tags.names);
        let args = format!("{names} {} {} {}", list(&tags.n_args), list(&tags.integers), bracket(&tags.floats));
        let head = format!("SubdivisionMesh {} {} {} {args}", quote(scheme), list(&n_vertices), list(&vertices));
        self.put_with(&head, &params)
    }
    fn blobby(
        &mut self,
        leaves: i32,
        codes: Vec<i32>,
        floats: Vec<f32>,
        names: Vec<String>,
        params: Params,
    ) -> RiResult {
        let head = format!("Blobby {leaves} {} {} {}", list(&codes), bracket(&floats), strings(&names));
        self.put_with(&head, &params)
    }
    fn geometry(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Geometry {}", quote(name)), &params)
    }
    fn detail_bound(&mut self, bound: [f32; 6]) -> RiResult {
        self.put_matrix("Detail", &bound)
    }
    fn detail_range(&mut self, range: [f32; 4]) -> RiResult {
        self.put_matrix("DetailRange", &range)
    }
    fn relative_detail(&mut self, factor: f32) -> RiResult {
        self.put_numbers("RelativeDetail", &[factor])
    }
    fn geometric_approximation(&mut self, kind: &str, value: f32) -> RiResult {
        self.put_numbers(&format!("GeometricApproximation {}", quote(kind)), &[value])
    }
    fn texture_coordinates(&mut self, corners: [f32; 8]) -> RiResult {
        self.put_matrix("TextureCoordinates", &corners)
    }
    fn color_samples(&mut self, to_rgb: Vec<f32>, from_rgb: Vec<f32>) -> RiResult {
        self.put(&format!("ColorSamples {} {}", bracket(&to_rgb), bracket(&from_rgb)))
    }
    fn pixel_variance(&mut self, variance: f32) -> RiResult {
        self.put_numbers("PixelVariance", &[variance])
    }
    fn deformation(&mut self, name: &str, params: Params) -> RiResult {
        self.put_with(&format!("Deformation {}", quote(name)), &params)
    }
    fn error_handler(&mut self, name: &str) -> RiResult {
        self.put(&format!("ErrorHandler {}", quote(name)))
    }
    fn make_texture(
        &mut self,
        from: &str,
        to: &str,
        [s, t]: [&str; 2],
        filter: &str,
        [x, y]: [f32; 2],
        params: Params,
    ) -> RiResult {
        let names = [from, to, s, t, filter].map(quote).join(" ");
        self.put_with(&format!("MakeTexture {names} {x} {y}"), &params)
    }
    fn make_lat_long_environment(
        &mut self,
        from: &str,
        to: &str,
        filter: &str,
        [x, y]: [f32; 2],
        params: Params,
    ) -> RiResult {
        let names = [from, to, filter].map(quote).join(" ");
        self.put_with(&format!("MakeLatLongEnvironment {names} {x} {y}"), &params)
    }
    fn make_cube_face_environment(
        &mut self,
        from: Vec<String>,
        to: &str,
        fov: f32,
        filter: &str,
        [x, y]: [f32; 2],
        params: Params,
    ) -> RiResult {
        let from: Vec<String> = from.iter().map(|f| quote(f)).collect();
        let head = format!("MakeCubeFaceEnvironment {} {} {fov} {}", from.join(" "), quote(to), quote(filter));
        self.put_with(&format!("{head} {x} {y}"), &params)
    }
    fn make_shadow(&mut self, from: &str, to: &str, params: Params) -> RiResult {
        self.put_with(&format!("MakeShadow {} {}", quote(from), quote(to)), &params)
    }
    fn archive_record(&mut self, kind: &str, text: &str) -> RiResult {
        self.put(&format!("{}{text}", if kind == "structure" { "##" } else { "#" }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Files;
    use crate::reader::read;
    use std::path::Path;

    /// Keeps the warnings.
    #[derive(Default)]
    struct Heard(Vec<String>);

    impl Ri for Heard {
        fn world_begin(&mut self) -> RiResult {
            Ok(())
        }
        fn world_end(&mut self) -> RiResult {
            Ok(())
        }
        fn surface(&mut self, _: &str, _: Params) -> RiResult {
            Ok(())
        }
        fn warn(&mut self, message: String) {
            self.0.push(message);
        }
    }

    fn rewrite(text: &str) -> String {
        let mut writer = Writer::new(Vec::new()).unwrap();
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut writer, &mut |_, _| Ok(())).unwrap();
        String::from_utf8(writer.into_inner()).unwrap()
    }

    #[test]
    fn writing_what_was_read_is_a_fixed_point() {
        let text = "Format 640 480 1 Projection \"perspective\" \"fov\" [30]
            Declare \"tint\" \"uniform color\"
            WorldBegin LightSource \"distantlight\" 1 \"intensity\" [.5] AttributeBegin # a remark
            Color 1 .5 0 Surface \"plastic\" \"tint\" [1 0 0] Translate 1 2 3 Sphere 1 -1 1 360 \"varying float x\" [1 2 3 4]
            Basis \"bezier\" 3 \"b-spline\" 1 Patch \"bilinear\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]
            AttributeEnd WorldEnd";
        let once = rewrite(text);
        assert_eq!(rewrite(&once), once);
        assert!(once.contains("    Color [1 0.5 0]\n"), "{once}");
    }

    #[test]
    fn faults_have_their_places() {
        let fault = |text: &str| {
            let mut writer = Writer::new(Vec::new()).unwrap();
            let e = read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut writer, &mut |_, _| Ok(()))
                .unwrap_err();
            (e.place.line, e.place.column, e.message)
        };
        // What is not known is read over, and said.
        let mut heard = Heard::default();
        let text = "WorldBegin\n  Shpere 1 [-1 1] \"a\" 360 Surface \"matte\" \"Kq\" [1] Shpere 2 WorldEnd";
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut heard, &mut |_, _| Ok(())).unwrap();
        let expected = [
            "t.rib:2:3: unknown request `Shpere`, did you mean `Sphere`?; it is passed over",
            "t.rib:2:27: parameter `Kq` is not declared: write \"uniform float Kq\" or `Declare` it before; did you mean `Ka`?",
        ];
        assert_eq!(heard.0, expected);
        assert_eq!(fault("Translate 1 2\nWorldEnd").0, 2);
        assert_eq!(fault("Color [1 2").2, "expected a number or `]`, found the end of the file");
        assert_eq!(fault("IfBegin \"1\" WorldBegin").2, "`IfBegin` without `IfEnd`");
        assert_eq!(fault("\n \"matte").2, "a string is not closed before the file ends");
    }
}
