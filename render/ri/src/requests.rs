//! Each RIB request's arguments, and the call that it makes.

use crate::reader::Reader;
use crate::{Fail, Knots, Ri, Tags, TrimCurves, Values};

macro_rules! requests {
    ($($name:ident)*) => {
        /// A request that is known, named as in the stream.
        #[allow(non_camel_case_types)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Request {
            $($name),*
        }

        /// Every request and its name.
        pub(crate) const KNOWN: &[(&str, Request)] = &[$((stringify!($name), Request::$name)),*];
    };
}

requests! {
    version Declare FrameBegin FrameEnd WorldBegin WorldEnd AttributeBegin AttributeEnd TransformBegin TransformEnd
    ObjectBegin ObjectEnd ObjectInstance SolidBegin SolidEnd MotionBegin MotionEnd Format FrameAspectRatio
    ScreenWindow CropWindow Projection Clipping DepthOfField Shutter PixelSamples PixelFilter Exposure Imager Quantize
    Display Hider Option Attribute Color Opacity LightSource AreaLightSource Illuminate Surface Displacement
    Atmosphere Interior Exterior ShadingRate ShadingInterpolation Matte Bound Orientation ReverseOrientation Sides
    Identity Transform ConcatTransform Perspective Translate Rotate Scale Skew CoordinateSystem CoordSysTransform
    Polygon GeneralPolygon PointsPolygons PointsGeneralPolygons Basis Patch PatchMesh Sphere ReadArchive Cone Cylinder
    Hyperboloid Paraboloid Disk Torus Points Curves NuPatch TrimCurve SubdivisionMesh Blobby Geometry Procedural
    Detail DetailRange RelativeDetail GeometricApproximation TextureCoordinates ColorSamples PixelVariance Deformation
    ErrorHandler MakeTexture MakeLatLongEnvironment MakeCubeFaceEnvironment MakeShadow IfBegin ElseIf Else IfEnd
    ArchiveBegin ArchiveEnd
}

/// Places of the table by which names are found: twice as many as there are names, and a power of two.
const SLOTS: usize = 256;

/// For each slot, one more than the index in [`KNOWN`]; 0 is empty. Names that fall on one slot take the next ones.
static TABLE: [u8; SLOTS] = {
    let mut table = [0; SLOTS];
    let mut k = 0;
    while k < KNOWN.len() {
        let mut at = slot(KNOWN[k].0.as_bytes());
        while table[at] != 0 {
            at = (at + 1) % SLOTS;
        }
        table[at] = k as u8 + 1;
        k += 1;
    }
    table
};

const fn slot(name: &[u8]) -> usize {
    let n = name.len();
    let letters = name[0] as usize + 7 * name[n / 2] as usize + 31 * name[n - 1] as usize;
    (letters + 57 * n) % SLOTS
}

impl Request {
    /// The request of a name.
    #[inline]
    pub(crate) fn named(name: &str) -> Option<Request> {
        if name.is_empty() {
            return None;
        }
        let mut at = slot(name.as_bytes());
        while TABLE[at] != 0 {
            let (known, request) = KNOWN[TABLE[at] as usize - 1];
            if known == name {
                return Some(request);
            }
            at = (at + 1) % SLOTS;
        }
        None
    }

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        KNOWN[self as usize].0
    }

    /// Whether it opens, parts or ends a condition.
    pub(crate) fn is_condition(self) -> bool {
        matches!(self, Request::IfBegin | Request::ElseIf | Request::Else | Request::IfEnd)
    }
}

/// A failure, and whether it lies in the arguments rather than in the call.
pub(crate) struct Placed {
    pub(crate) fail: Fail,
    pub(crate) in_arguments: bool,
}

impl From<Fail> for Placed {
    fn from(fail: Fail) -> Placed {
        Placed { fail, in_arguments: true }
    }
}

/// Read over a request that is not known. The specification asks to go on; a name near a known one is most likely a slip.
pub(crate) fn pass_over(r: &mut Reader<'_>, name: &str) -> Result<(), Placed> {
    let distance = |(known, _): &&(&str, Request)| strsim::damerau_levenshtein(known, name);
    let near = KNOWN.iter().min_by_key(distance).filter(|k| distance(k) <= 3);
    let near = near.map_or(String::new(), |(known, _)| format!(", did you mean `{known}`?"));
    r.warn(&format!("request {name}"), &format!("unknown request `{name}`{near}; it is passed over"));
    Ok(r.pass_arguments()?)
}

/// Read a request's arguments and make its call. Arguments are read to the end first, so that a broken stream makes no half call.
pub(crate) fn dispatch(r: &mut Reader<'_>, ri: &mut dyn Ri, request: Request) -> Result<(), Placed> {
    macro_rules! call {
        ($method:ident $(, $arg:expr)*) => {{
            r.end_of(request)?;
            ri.$method($($arg),*).map_err(|fail| Placed { fail, in_arguments: false })
        }};
    }
    match request {
        Request::version => {
            let number = r.number()?;
            call!(version, number)
        }
        Request::Declare => {
            let (name, declaration) = (r.string()?, r.string()?);
            r.shared.declarations.declare(&name, &declaration).map_err(Fail::new)?;
            call!(declare, &name, &declaration)
        }
        Request::FrameBegin => {
            let number = r.integer()?;
            r.remember("Frame", Values::Floats(vec![number as f32]));
            call!(frame_begin, number)
        }
        Request::FrameEnd => call!(frame_end),
        Request::WorldBegin => call!(world_begin),
        Request::WorldEnd => call!(world_end),
        Request::AttributeBegin => call!(attribute_begin),
        Request::AttributeEnd => call!(attribute_end),
        Request::TransformBegin => call!(transform_begin),
        Request::TransformEnd => call!(transform_end),
        Request::ObjectBegin => {
            let handle = r.handle()?;
            call!(object_begin, &handle)
        }
        Request::ObjectEnd => call!(object_end),
        Request::ObjectInstance => {
            let handle = r.handle()?;
            call!(object_instance, &handle)
        }
        Request::SolidBegin => {
            let operation = r.string()?;
            call!(solid_begin, &operation)
        }
        Request::SolidEnd => call!(solid_end),
        Request::MotionBegin => {
            let times = r.numbers()?;
            call!(motion_begin, times)
        }
        Request::MotionEnd => call!(motion_end),
        Request::Format => {
            let (width, height, aspect) = (r.integer()?, r.integer()?, r.number()?);
            call!(format, width, height, aspect)
        }
        Request::FrameAspectRatio => {
            let ratio = r.number()?;
            call!(frame_aspect_ratio, ratio)
        }
        Request::ScreenWindow => {
            let [a, b, c, d] = r.numbers_of("left, right, bottom and top")?;
            call!(screen_window, a, b, c, d)
        }
        Request::CropWindow => {
            let [a, b, c, d] = r.numbers_of("x and y ranges")?;
            call!(crop_window, a, b, c, d)
        }
        Request::Projection => {
            let (name, params) = (r.string()?, r.params()?);
            call!(projection, &name, params)
        }
        Request::Clipping => {
            let [near, far] = r.numbers_of("near and far")?;
            call!(clipping, near, far)
        }
        Request::DepthOfField => {
            let [f, length, distance] = if r.has_argument()? {
                r.numbers_of("f-stop, focal length and distance")?
            } else {
                [f32::INFINITY, 1.0, 1.0]
            };
            call!(depth_of_field, f, length, distance)
        }
        Request::Shutter => {
            let [open, close] = r.numbers_of("opening and closing time")?;
            call!(shutter, open, close)
        }
        Request::PixelSamples => {
            let [x, y] = r.numbers_of("samples along x and y")?;
            call!(pixel_samples, x, y)
        }
        Request::PixelFilter => {
            let name = r.string()?;
            let [x, y] = r.numbers_of("filter widths")?;
            call!(pixel_filter, &name, x, y)
        }
        Request::Exposure => {
            let [gain, gamma] = r.numbers_of("gain and gamma")?;
            call!(exposure, gain, gamma)
        }
        Request::Imager => {
            let (name, params) = (r.string()?, r.params()?);
            call!(imager, &name, params)
        }
        Request::Quantize => {
            let kind = r.string()?;
            let [one, min, max, dither] = r.numbers_of("one, min, max and dither")?;
            call!(quantize, &kind, one as i32, min as i32, max as i32, dither)
        }
        Request::Display => {
            let (name, kind, mode, params) = (r.string()?, r.string()?, r.string()?, r.params()?);
            call!(display, &name, &kind, &mode, params)
        }
        Request::Hider => {
            let (name, params) = (r.string()?, r.params()?);
            call!(hider, &name, params)
        }
        Request::Option => {
            let (name, params) = (r.string()?, r.params()?);
            for param in &params {
                r.remember(&format!("{name}:{}", param.decl.name), param.values.clone());
            }
            call!(option, &name, params)
        }
        Request::Attribute => {
            let (name, params) = (r.string()?, r.params()?);
            call!(attribute, &name, params)
        }
        Request::Color => {
            let color = r.numbers_of("a colour")?;
            call!(color, color)
        }
        Request::Opacity => {
            let opacity = r.numbers_of("an opacity")?;
            call!(opacity, opacity)
        }
        Request::LightSource => {
            let (name, handle, params) = (r.string()?, r.handle()?, r.params()?);
            call!(light_source, &name, &handle, params)
        }
        Request::AreaLightSource => {
            let (name, handle, params) = (r.string()?, r.handle()?, r.params()?);
            call!(area_light_source, &name, &handle, params)
        }
        Request::Illuminate => {
            let (handle, on) = (r.handle()?, r.number()?);
            call!(illuminate, &handle, on != 0.0)
        }
        Request::Surface => {
            let (name, params) = (r.string()?, r.params()?);
            call!(surface, &name, params)
        }
        Request::Displacement => {
            let (name, params) = (r.string()?, r.params()?);
            call!(displacement, &name, params)
        }
        Request::Atmosphere => {
            let (name, params) = (r.string()?, r.params()?);
            call!(atmosphere, &name, params)
        }
        Request::Interior => {
            let (name, params) = (r.string()?, r.params()?);
            call!(interior, &name, params)
        }
        Request::Exterior => {
            let (name, params) = (r.string()?, r.params()?);
            call!(exterior, &name, params)
        }
        Request::ShadingRate => {
            let size = r.number()?;
            call!(shading_rate, size)
        }
        Request::ShadingInterpolation => {
            let kind = r.string()?;
            call!(shading_interpolation, &kind)
        }
        Request::Matte => {
            let on = r.number()?;
            call!(matte, on != 0.0)
        }
        Request::Bound => {
            let bound = r.numbers_of("a bound")?;
            call!(bound, bound)
        }
        Request::Orientation => {
            let kind = r.string()?;
            call!(orientation, &kind)
        }
        Request::ReverseOrientation => call!(reverse_orientation),
        Request::Sides => {
            let sides = r.integer()?;
            call!(sides, sides)
        }
        Request::Identity => call!(identity),
        Request::Transform => {
            let matrix = r.numbers_of("a matrix")?;
            call!(transform, matrix)
        }
        Request::ConcatTransform => {
            let matrix = r.numbers_of("a matrix")?;
            call!(concat_transform, matrix)
        }
        Request::Perspective => {
            let fov = r.number()?;
            call!(perspective, fov)
        }
        Request::Translate => {
            let by = r.numbers_of("a translation")?;
            call!(translate, by)
        }
        Request::Rotate => {
            let [angle, x, y, z] = r.numbers_of("an angle and an axis")?;
            call!(rotate, angle, [x, y, z])
        }
        Request::Scale => {
            let by = r.numbers_of("three factors")?;
            call!(scale, by)
        }
        Request::Skew => {
            let [angle, a, b, c, d, e, f] = r.numbers_of("an angle and two directions")?;
            call!(skew, angle, [a, b, c], [d, e, f])
        }
        Request::CoordinateSystem => {
            let name = r.string()?;
            call!(coordinate_system, &name)
        }
        Request::CoordSysTransform => {
            let name = r.string()?;
            call!(coord_sys_transform, &name)
        }
        Request::Polygon => {
            let params = r.params()?;
            call!(polygon, params)
        }
        Request::GeneralPolygon => {
            let (n_vertices, params) = (r.integers()?, r.params()?);
            call!(general_polygon, n_vertices, params)
        }
        Request::PointsPolygons => {
            let (n_vertices, vertices, params) = (r.integers()?, r.integers()?, r.params()?);
            call!(points_polygons, n_vertices, vertices, params)
        }
        Request::Basis => {
            let (u, u_step, v, v_step) = (basis(r)?, r.integer()?, basis(r)?, r.integer()?);
            call!(basis, u, u_step, v, v_step)
        }
        Request::Patch => {
            let (kind, params) = (r.string()?, r.params()?);
            call!(patch, &kind, params)
        }
        Request::PatchMesh => {
            let (kind, nu, u_wrap) = (r.string()?, r.integer()?, r.string()?);
            let (nv, v_wrap, params) = (r.integer()?, r.string()?, r.params()?);
            call!(patch_mesh, &kind, nu, &u_wrap, nv, &v_wrap, params)
        }
        Request::Sphere => {
            let [radius, z_min, z_max, sweep] = r.numbers_of("radius, zmin, zmax and thetamax")?;
            let params = r.params()?;
            call!(sphere, radius, z_min, z_max, sweep, params)
        }
        Request::PointsGeneralPolygons => {
            let (n_loops, n_vertices, vertices) = (r.integers()?, r.integers()?, r.integers()?);
            let params = r.params()?;
            call!(points_general_polygons, n_loops, n_vertices, vertices, params)
        }
        Request::Cone => {
            let [height, radius, sweep] = r.numbers_of("height, radius and thetamax")?;
            let params = r.params()?;
            call!(cone, height, radius, sweep, params)
        }
        Request::Cylinder => {
            let [radius, z_min, z_max, sweep] = r.numbers_of("radius, zmin, zmax and thetamax")?;
            let params = r.params()?;
            call!(cylinder, radius, z_min, z_max, sweep, params)
        }
        Request::Hyperboloid => {
            let [a, b, c, d, e, f, sweep] = r.numbers_of("two points and thetamax")?;
            let params = r.params()?;
            call!(hyperboloid, [a, b, c], [d, e, f], sweep, params)
        }
        Request::Paraboloid => {
            let [radius, z_min, z_max, sweep] = r.numbers_of("rmax, zmin, zmax and thetamax")?;
            let params = r.params()?;
            call!(paraboloid, radius, z_min, z_max, sweep, params)
        }
        Request::Disk => {
            let [height, radius, sweep] = r.numbers_of("height, radius and thetamax")?;
            let params = r.params()?;
            call!(disk, height, radius, sweep, params)
        }
        Request::Torus => {
            let [major, minor, phi_min, phi_max, sweep] = r.numbers_of("radii, phimin, phimax and thetamax")?;
            let params = r.params()?;
            call!(torus, major, minor, phi_min, phi_max, sweep, params)
        }
        Request::Points => {
            let params = r.params()?;
            call!(points, params)
        }
        Request::Curves => {
            let (kind, n_vertices, wrap) = (r.string()?, r.integers()?, r.string()?);
            let params = r.params()?;
            call!(curves, &kind, n_vertices, &wrap, params)
        }
        Request::NuPatch => {
            let u = knots(r)?;
            let v = knots(r)?;
            let params = r.params()?;
            call!(nu_patch, u, v, params)
        }
        Request::TrimCurve => {
            let curves = TrimCurves {
                n_curves: r.integers()?,
                order: r.integers()?,
                knot: r.numbers()?,
                min: r.numbers()?,
                max: r.numbers()?,
                n: r.integers()?,
                u: r.numbers()?,
                v: r.numbers()?,
                w: r.numbers()?,
            };
            call!(trim_curve, curves)
        }
        Request::SubdivisionMesh => {
            let (scheme, n_vertices, vertices) = (r.string()?, r.integers()?, r.integers()?);
            let mut tags = Tags::default();
            // Without tags the four lists may be left out.
            if r.has_list()? {
                tags =
                    Tags { names: r.strings()?, n_args: r.integers()?, integers: r.integers()?, floats: r.numbers()? };
            }
            let params = r.params()?;
            call!(subdivision_mesh, &scheme, n_vertices, vertices, tags, params)
        }
        Request::Blobby => {
            let (leaves, codes, floats, strings) = (r.integer()?, r.integers()?, r.numbers()?, r.strings()?);
            let params = r.params()?;
            call!(blobby, leaves, codes, floats, strings, params)
        }
        Request::Geometry => {
            let (name, params) = (r.string()?, r.params()?);
            call!(geometry, &name, params)
        }
        Request::Detail => {
            let bound = r.numbers_of("a bound")?;
            call!(detail_bound, bound)
        }
        Request::DetailRange => {
            let range = r.numbers_of("four sizes")?;
            call!(detail_range, range)
        }
        Request::RelativeDetail => {
            let factor = r.number()?;
            call!(relative_detail, factor)
        }
        Request::GeometricApproximation => {
            let (kind, value) = (r.string()?, r.number()?);
            call!(geometric_approximation, &kind, value)
        }
        Request::TextureCoordinates => {
            let corners = r.numbers_of("s and t of four corners")?;
            call!(texture_coordinates, corners)
        }
        Request::ColorSamples => {
            let (to_rgb, from_rgb) = (r.numbers()?, r.numbers()?);
            call!(color_samples, to_rgb, from_rgb)
        }
        Request::PixelVariance => {
            let variance = r.number()?;
            call!(pixel_variance, variance)
        }
        Request::Deformation => {
            let (name, params) = (r.string()?, r.params()?);
            call!(deformation, &name, params)
        }
        Request::ErrorHandler => {
            let name = r.string()?;
            call!(error_handler, &name)
        }
        Request::MakeTexture => {
            let (from, to) = (r.string()?, r.string()?);
            let (s_wrap, t_wrap, filter) = (r.string()?, r.string()?, r.string()?);
            let widths = r.numbers_of("filter widths")?;
            let params = r.params()?;
            call!(make_texture, &from, &to, [&s_wrap, &t_wrap], &filter, widths, params)
        }
        Request::MakeLatLongEnvironment => {
            let (from, to, filter) = (r.string()?, r.string()?, r.string()?);
            let widths = r.numbers_of("filter widths")?;
            let params = r.params()?;
            call!(make_lat_long_environment, &from, &to, &filter, widths, params)
        }
        Request::MakeCubeFaceEnvironment => {
            let from = [r.string()?, r.string()?, r.string()?, r.string()?, r.string()?, r.string()?].to_vec();
            let (to, fov, filter) = (r.string()?, r.number()?, r.string()?);
            let widths = r.numbers_of("filter widths")?;
            let params = r.params()?;
            call!(make_cube_face_environment, from, &to, fov, &filter, widths, params)
        }
        Request::MakeShadow => {
            let (from, to, params) = (r.string()?, r.string()?, r.params()?);
            call!(make_shadow, &from, &to, params)
        }
        Request::ArchiveEnd => Err(Fail::new("`ArchiveEnd` without `ArchiveBegin`").into()),
        // The reader itself does these.
        Request::ReadArchive
        | Request::Procedural
        | Request::ArchiveBegin
        | Request::IfBegin
        | Request::ElseIf
        | Request::Else
        | Request::IfEnd => unreachable!("a request of the reader"),
    }
}

/// Numbers of a NURBS patch along one parameter.
fn knots(r: &mut Reader<'_>) -> Result<Knots, Fail> {
    let (n, order, knots) = (r.integer()?, r.integer()?, r.numbers()?);
    Ok(Knots { n, order, knots, range: [r.number()?, r.number()?] })
}

/// A basis by name or by matrix (RISpec section 5.3).
fn basis(r: &mut Reader<'_>) -> Result<[f32; 16], Fail> {
    let sixth = 1.0 / 6.0;
    if !r.has_string()? {
        return r.numbers_of("a basis by name or matrix");
    }
    Ok(match r.string()?.as_str() {
        "bezier" => [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        "b-spline" => {
            [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 0.0, 3.0, 0.0, 1.0, 4.0, 1.0, 0.0].map(|x: f32| x * sixth)
        }
        "catmull-rom" => {
            [-1.0, 3.0, -3.0, 1.0, 2.0, -5.0, 4.0, -1.0, -1.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0].map(|x: f32| x * 0.5)
        }
        "hermite" => [2.0, 1.0, -2.0, 1.0, -3.0, -2.0, 3.0, -1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        "power" => [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        other => {
            return Err(Fail::new(format!(
                "unknown basis `{other}`, expected bezier, b-spline, catmull-rom, hermite or power"
            )));
        }
    })
}
