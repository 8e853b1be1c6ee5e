//! Each RIB request's arguments, and the call that it makes.

use crate::reader::Reader;
use crate::{Fail, Knots, Ri, RiResult, Tags, TrimCurves, Values};

/// The requests that are known, for "did you mean".
pub(crate) const KNOWN: &[&str] = &[
    "version",
    "Declare",
    "FrameBegin",
    "FrameEnd",
    "WorldBegin",
    "WorldEnd",
    "AttributeBegin",
    "AttributeEnd",
    "TransformBegin",
    "TransformEnd",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "SolidBegin",
    "SolidEnd",
    "MotionBegin",
    "MotionEnd",
    "Format",
    "FrameAspectRatio",
    "ScreenWindow",
    "CropWindow",
    "Projection",
    "Clipping",
    "DepthOfField",
    "Shutter",
    "PixelSamples",
    "PixelFilter",
    "Exposure",
    "Imager",
    "Quantize",
    "Display",
    "Hider",
    "Option",
    "Attribute",
    "Color",
    "Opacity",
    "LightSource",
    "AreaLightSource",
    "Illuminate",
    "Surface",
    "Displacement",
    "Atmosphere",
    "Interior",
    "Exterior",
    "ShadingRate",
    "ShadingInterpolation",
    "Matte",
    "Bound",
    "Orientation",
    "ReverseOrientation",
    "Sides",
    "Identity",
    "Transform",
    "ConcatTransform",
    "Perspective",
    "Translate",
    "Rotate",
    "Scale",
    "Skew",
    "CoordinateSystem",
    "CoordSysTransform",
    "Polygon",
    "GeneralPolygon",
    "PointsPolygons",
    "PointsGeneralPolygons",
    "Basis",
    "Patch",
    "PatchMesh",
    "Sphere",
    "ReadArchive",
    "Cone",
    "Cylinder",
    "Hyperboloid",
    "Paraboloid",
    "Disk",
    "Torus",
    "Points",
    "Curves",
    "NuPatch",
    "TrimCurve",
    "SubdivisionMesh",
    "Blobby",
    "Geometry",
    "Procedural",
    "Detail",
    "DetailRange",
    "RelativeDetail",
    "GeometricApproximation",
    "TextureCoordinates",
    "ColorSamples",
    "PixelVariance",
    "Deformation",
    "ErrorHandler",
    "MakeTexture",
    "MakeLatLongEnvironment",
    "MakeCubeFaceEnvironment",
    "MakeShadow",
    "IfBegin",
    "ElseIf",
    "Else",
    "IfEnd",
    "ArchiveBegin",
    "ArchiveEnd",
];

/// A failure, and whether it lies in the arguments rather than in the call.
type Placed = (Fail, bool);

/// Read a request's arguments and make its call.
pub(crate) fn dispatch(r: &mut Reader<'_>, ri: &mut dyn Ri, name: &str) -> Result<(), Placed> {
    // Arguments are read to the end before the call is made, so that a broken stream makes no half call.
    let argument = |f: Fail| (f, true);
    let call: Box<dyn FnOnce(&mut dyn Ri) -> RiResult> = read_arguments(r, name).map_err(argument)?;
    if r.has_argument().map_err(argument)? {
        return Err((Fail::new(format!("`{name}` has more arguments than it takes")), true));
    }
    call(ri).map_err(|f| (f, false))
}

fn read_arguments(r: &mut Reader<'_>, name: &str) -> Result<Box<dyn FnOnce(&mut dyn Ri) -> RiResult>, Fail> {
    macro_rules! call {
        ($method:ident $(, $arg:expr)*) => { Box::new(move |ri: &mut dyn Ri| ri.$method($($arg),*)) };
    }
    Ok(match name {
        "version" => {
            let number = r.number()?;
            call!(version, number)
        }
        "Declare" => {
            let (name, declaration) = (r.string()?, r.string()?);
            r.shared.declarations.declare(&name, &declaration).map_err(Fail::new)?;
            call!(declare, &name, &declaration)
        }
        "FrameBegin" => {
            let number = r.integer()?;
            r.remember("Frame", Values::Floats(vec![number as f32]));
            call!(frame_begin, number)
        }
        "FrameEnd" => call!(frame_end),
        "WorldBegin" => call!(world_begin),
        "WorldEnd" => call!(world_end),
        "AttributeBegin" => call!(attribute_begin),
        "AttributeEnd" => call!(attribute_end),
        "TransformBegin" => call!(transform_begin),
        "TransformEnd" => call!(transform_end),
        "ObjectBegin" => {
            let handle = r.handle()?;
            call!(object_begin, &handle)
        }
        "ObjectEnd" => call!(object_end),
        "ObjectInstance" => {
            let handle = r.handle()?;
            call!(object_instance, &handle)
        }
        "SolidBegin" => {
            let operation = r.string()?;
            call!(solid_begin, &operation)
        }
        "SolidEnd" => call!(solid_end),
        "MotionBegin" => {
            let times = r.numbers()?;
            call!(motion_begin, times)
        }
        "MotionEnd" => call!(motion_end),
        "Format" => {
            let (width, height, aspect) = (r.integer()?, r.integer()?, r.number()?);
            call!(format, width, height, aspect)
        }
        "FrameAspectRatio" => {
            let ratio = r.number()?;
            call!(frame_aspect_ratio, ratio)
        }
        "ScreenWindow" => {
            let [a, b, c, d] = r.numbers_of("left, right, bottom and top")?;
            call!(screen_window, a, b, c, d)
        }
        "CropWindow" => {
            let [a, b, c, d] = r.numbers_of("x and y ranges")?;
            call!(crop_window, a, b, c, d)
        }
        "Projection" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(projection, &name, params)
        }
        "Clipping" => {
            let [near, far] = r.numbers_of("near and far")?;
            call!(clipping, near, far)
        }
        "DepthOfField" => {
            let [f, length, distance] = if r.has_argument()? {
                r.numbers_of("f-stop, focal length and distance")?
            } else {
                [f32::INFINITY, 1.0, 1.0]
            };
            call!(depth_of_field, f, length, distance)
        }
        "Shutter" => {
            let [open, close] = r.numbers_of("opening and closing time")?;
            call!(shutter, open, close)
        }
        "PixelSamples" => {
            let [x, y] = r.numbers_of("samples along x and y")?;
            call!(pixel_samples, x, y)
        }
        "PixelFilter" => {
            let name = r.string()?;
            let [x, y] = r.numbers_of("filter widths")?;
            call!(pixel_filter, &name, x, y)
        }
        "Exposure" => {
            let [gain, gamma] = r.numbers_of("gain and gamma")?;
            call!(exposure, gain, gamma)
        }
        "Imager" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(imager, &name, params)
        }
        "Quantize" => {
            let kind = r.string()?;
            let [one, min, max, dither] = r.numbers_of("one, min, max and dither")?;
            call!(quantize, &kind, one as i32, min as i32, max as i32, dither)
        }
        "Display" => {
            let (name, kind, mode, params) = (r.string()?, r.string()?, r.string()?, r.params()?);
            call!(display, &name, &kind, &mode, params)
        }
        "Hider" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(hider, &name, params)
        }
        "Option" => {
            let (name, params) = (r.string()?, r.params()?);
            for param in &params {
                r.remember(&format!("{name}:{}", param.decl.name), param.values.clone());
            }
            call!(option, &name, params)
        }
        "Attribute" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(attribute, &name, params)
        }
        "Color" => {
            let color = r.numbers_of("a colour")?;
            call!(color, color)
        }
        "Opacity" => {
            let opacity = r.numbers_of("an opacity")?;
            call!(opacity, opacity)
        }
        "LightSource" => {
            let (name, handle, params) = (r.string()?, r.handle()?, r.params()?);
            call!(light_source, &name, &handle, params)
        }
        "AreaLightSource" => {
            let (name, handle, params) = (r.string()?, r.handle()?, r.params()?);
            call!(area_light_source, &name, &handle, params)
        }
        "Illuminate" => {
            let (handle, on) = (r.handle()?, r.number()?);
            call!(illuminate, &handle, on != 0.0)
        }
        "Surface" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(surface, &name, params)
        }
        "Displacement" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(displacement, &name, params)
        }
        "Atmosphere" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(atmosphere, &name, params)
        }
        "Interior" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(interior, &name, params)
        }
        "Exterior" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(exterior, &name, params)
        }
        "ShadingRate" => {
            let size = r.number()?;
            call!(shading_rate, size)
        }
        "ShadingInterpolation" => {
            let kind = r.string()?;
            call!(shading_interpolation, &kind)
        }
        "Matte" => {
            let on = r.number()?;
            call!(matte, on != 0.0)
        }
        "Bound" => {
            let bound = r.numbers_of("a bound")?;
            call!(bound, bound)
        }
        "Orientation" => {
            let kind = r.string()?;
            call!(orientation, &kind)
        }
        "ReverseOrientation" => call!(reverse_orientation),
        "Sides" => {
            let sides = r.integer()?;
            call!(sides, sides)
        }
        "Identity" => call!(identity),
        "Transform" => {
            let matrix = r.numbers_of("a matrix")?;
            call!(transform, matrix)
        }
        "ConcatTransform" => {
            let matrix = r.numbers_of("a matrix")?;
            call!(concat_transform, matrix)
        }
        "Perspective" => {
            let fov = r.number()?;
            call!(perspective, fov)
        }
        "Translate" => {
            let by = r.numbers_of("a translation")?;
            call!(translate, by)
        }
        "Rotate" => {
            let [angle, x, y, z] = r.numbers_of("an angle and an axis")?;
            call!(rotate, angle, [x, y, z])
        }
        "Scale" => {
            let by = r.numbers_of("three factors")?;
            call!(scale, by)
        }
        "Skew" => {
            let [angle, a, b, c, d, e, f] = r.numbers_of("an angle and two directions")?;
            call!(skew, angle, [a, b, c], [d, e, f])
        }
        "CoordinateSystem" => {
            let name = r.string()?;
            call!(coordinate_system, &name)
        }
        "CoordSysTransform" => {
            let name = r.string()?;
            call!(coord_sys_transform, &name)
        }
        "Polygon" => {
            let params = r.params()?;
            call!(polygon, params)
        }
        "GeneralPolygon" => {
            let (n_vertices, params) = (r.integers()?, r.params()?);
            call!(general_polygon, n_vertices, params)
        }
        "PointsPolygons" => {
            let (n_vertices, vertices, params) = (r.integers()?, r.integers()?, r.params()?);
            call!(points_polygons, n_vertices, vertices, params)
        }
        "Basis" => {
            let (u, u_step, v, v_step) = (basis(r)?, r.integer()?, basis(r)?, r.integer()?);
            call!(basis, u, u_step, v, v_step)
        }
        "Patch" => {
            let (kind, params) = (r.string()?, r.params()?);
            call!(patch, &kind, params)
        }
        "PatchMesh" => {
            let (kind, nu, u_wrap) = (r.string()?, r.integer()?, r.string()?);
            let (nv, v_wrap, params) = (r.integer()?, r.string()?, r.params()?);
            call!(patch_mesh, &kind, nu, &u_wrap, nv, &v_wrap, params)
        }
        "Sphere" => {
            let [radius, z_min, z_max, sweep] = r.numbers_of("radius, zmin, zmax and thetamax")?;
            let params = r.params()?;
            call!(sphere, radius, z_min, z_max, sweep, params)
        }
        "PointsGeneralPolygons" => {
            let (n_loops, n_vertices, vertices) = (r.integers()?, r.integers()?, r.integers()?);
            let params = r.params()?;
            call!(points_general_polygons, n_loops, n_vertices, vertices, params)
        }
        "Cone" => {
            let [height, radius, sweep] = r.numbers_of("height, radius and thetamax")?;
            let params = r.params()?;
            call!(cone, height, radius, sweep, params)
        }
        "Cylinder" => {
            let [radius, z_min, z_max, sweep] = r.numbers_of("radius, zmin, zmax and thetamax")?;
            let params = r.params()?;
            call!(cylinder, radius, z_min, z_max, sweep, params)
        }
        "Hyperboloid" => {
            let [a, b, c, d, e, f, sweep] = r.numbers_of("two points and thetamax")?;
            let params = r.params()?;
            call!(hyperboloid, [a, b, c], [d, e, f], sweep, params)
        }
        "Paraboloid" => {
            let [radius, z_min, z_max, sweep] = r.numbers_of("rmax, zmin, zmax and thetamax")?;
            let params = r.params()?;
            call!(paraboloid, radius, z_min, z_max, sweep, params)
        }
        "Disk" => {
            let [height, radius, sweep] = r.numbers_of("height, radius and thetamax")?;
            let params = r.params()?;
            call!(disk, height, radius, sweep, params)
        }
        "Torus" => {
            let [major, minor, phi_min, phi_max, sweep] = r.numbers_of("radii, phimin, phimax and thetamax")?;
            let params = r.params()?;
            call!(torus, major, minor, phi_min, phi_max, sweep, params)
        }
        "Points" => {
            let params = r.params()?;
            call!(points, params)
        }
        "Curves" => {
            let (kind, n_vertices, wrap) = (r.string()?, r.integers()?, r.string()?);
            let params = r.params()?;
            call!(curves, &kind, n_vertices, &wrap, params)
        }
        "NuPatch" => {
            let u = knots(r)?;
            let v = knots(r)?;
            let params = r.params()?;
            call!(nu_patch, u, v, params)
        }
        "TrimCurve" => {
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
        "SubdivisionMesh" => {
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
        "Blobby" => {
            let (leaves, codes, floats, strings) = (r.integer()?, r.integers()?, r.numbers()?, r.strings()?);
            let params = r.params()?;
            call!(blobby, leaves, codes, floats, strings, params)
        }
        "Geometry" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(geometry, &name, params)
        }
        "Detail" => {
            let bound = r.numbers_of("a bound")?;
            call!(detail_bound, bound)
        }
        "DetailRange" => {
            let range = r.numbers_of("four sizes")?;
            call!(detail_range, range)
        }
        "RelativeDetail" => {
            let factor = r.number()?;
            call!(relative_detail, factor)
        }
        "GeometricApproximation" => {
            let (kind, value) = (r.string()?, r.number()?);
            call!(geometric_approximation, &kind, value)
        }
        "TextureCoordinates" => {
            let corners = r.numbers_of("s and t of four corners")?;
            call!(texture_coordinates, corners)
        }
        "ColorSamples" => {
            let (to_rgb, from_rgb) = (r.numbers()?, r.numbers()?);
            call!(color_samples, to_rgb, from_rgb)
        }
        "PixelVariance" => {
            let variance = r.number()?;
            call!(pixel_variance, variance)
        }
        "Deformation" => {
            let (name, params) = (r.string()?, r.params()?);
            call!(deformation, &name, params)
        }
        "ErrorHandler" => {
            let name = r.string()?;
            call!(error_handler, &name)
        }
        "MakeTexture" => {
            let (from, to) = (r.string()?, r.string()?);
            let (s_wrap, t_wrap, filter) = (r.string()?, r.string()?, r.string()?);
            let widths = r.numbers_of("filter widths")?;
            let params = r.params()?;
            call!(make_texture, &from, &to, [&s_wrap, &t_wrap], &filter, widths, params)
        }
        "MakeLatLongEnvironment" => {
            let (from, to, filter) = (r.string()?, r.string()?, r.string()?);
            let widths = r.numbers_of("filter widths")?;
            let params = r.params()?;
            call!(make_lat_long_environment, &from, &to, &filter, widths, params)
        }
        "MakeCubeFaceEnvironment" => {
            let from = [r.string()?, r.string()?, r.string()?, r.string()?, r.string()?, r.string()?].to_vec();
            let (to, fov, filter) = (r.string()?, r.number()?, r.string()?);
            let widths = r.numbers_of("filter widths")?;
            let params = r.params()?;
            call!(make_cube_face_environment, from, &to, fov, &filter, widths, params)
        }
        "MakeShadow" => {
            let (from, to, params) = (r.string()?, r.string()?, r.params()?);
            call!(make_shadow, &from, &to, params)
        }
        "ArchiveEnd" => return Err(Fail::new("`ArchiveEnd` without `ArchiveBegin`")),
        other => {
            // The specification asks to go on; a name near a known one is most likely a slip.
            let near = KNOWN.iter().min_by_key(|k| strsim::damerau_levenshtein(k, other));
            let near = near
                .filter(|k| strsim::damerau_levenshtein(k, other) <= 3)
                .map_or(String::new(), |k| format!(", did you mean `{k}`?"));
            r.warn(&format!("request {other}"), &format!("unknown request `{other}`{near}; it is passed over"));
            r.pass_arguments()?;
            Box::new(|_: &mut dyn Ri| Ok(()))
        }
    })
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
