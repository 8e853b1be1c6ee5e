//! The trait: one method a call of the RenderMan Interface (RISpec 3.2), and the instance array, which is ours.
//!
//! A method that a renderer leaves out answers "not supported yet" with the call's name; the reader adds file and line.

use crate::{Instances, Params};

/// Numbers of a NURBS patch along one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    /// Control points.
    pub n: i32,
    /// Order: degree plus one.
    pub order: i32,
    /// Knots (n + order).
    pub knots: Vec<f32>,
    /// Least and greatest parameter.
    pub range: [f32; 2],
}

/// Loops of NURBS curves in u, v, w. Columns but the last three have a row a curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrimCurves {
    /// Curves of each loop.
    pub n_curves: Vec<i32>,
    /// Orders.
    pub order: Vec<i32>,
    /// Knots, one curve after the other.
    pub knot: Vec<f32>,
    /// Least parameters.
    pub min: Vec<f32>,
    /// Greatest parameters.
    pub max: Vec<f32>,
    /// Control points.
    pub n: Vec<i32>,
    /// Their u.
    pub u: Vec<f32>,
    /// Their v.
    pub v: Vec<f32>,
    /// Their weights.
    pub w: Vec<f32>,
}

/// Tags of a subdivision mesh: names, and for each its numbers of integers and of floats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tags {
    /// Names.
    pub names: Vec<String>,
    /// Two numbers for each.
    pub n_args: Vec<i32>,
    /// All integers.
    pub integers: Vec<i32>,
    /// All floats.
    pub floats: Vec<f32>,
}

/// Why a call failed; who made it adds the place.
#[derive(Clone, Debug, PartialEq)]
pub struct Fail {
    /// What is wrong.
    pub message: String,
}

impl Fail {
    /// A failure with its message.
    pub fn new(message: impl Into<String>) -> Fail {
        Fail { message: message.into() }
    }
}

impl std::fmt::Display for Fail {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fail {}

/// What a call answers.
pub type RiResult = Result<(), Fail>;

macro_rules! calls {
    ($($(#[$doc:meta])* $name:ident ( $($arg:ident : $ty:ty),* ) = $call:literal;)*) => {
        /// The RenderMan Interface. Matrices are 16 numbers, row after row, for row vectors.
        #[allow(unused_variables)]
        pub trait Ri {
            $(
                $(#[$doc])*
                fn $name(&mut self, $($arg: $ty),*) -> RiResult {
                    Err(Fail::new(concat!("`", $call, "` is not supported yet")))
                }
            )*

            /// Be told of something odd that does not stop the reading.
            fn warn(&mut self, message: String) {
                eprintln!("warning: {message}");
            }

            /// How large a bound is on the raster, square pixels: what programs that make geometry are told.
            fn detail(&self, bound: [f32; 6]) -> f32 {
                1e6
            }

            /// Many instances of one shape; by default as standard calls.
            fn instances(&mut self, instances: Instances) -> RiResult {
                instances.expand(self)
            }
        }
    };
}

calls! {
    /// `version`: of the RIB format.
    version(number: f32) = "version";
    /// `Declare`: name a parameter's class and type.
    declare(name: &str, declaration: &str) = "Declare";
    /// `FrameBegin`
    frame_begin(number: i32) = "FrameBegin";
    /// `FrameEnd`
    frame_end() = "FrameEnd";
    /// `WorldBegin`: options are frozen, the current transformation becomes the camera's.
    world_begin() = "WorldBegin";
    /// `WorldEnd`: the picture is made.
    world_end() = "WorldEnd";
    /// `AttributeBegin`
    attribute_begin() = "AttributeBegin";
    /// `AttributeEnd`
    attribute_end() = "AttributeEnd";
    /// `TransformBegin`
    transform_begin() = "TransformBegin";
    /// `TransformEnd`
    transform_end() = "TransformEnd";
    /// `ObjectBegin`: retain the gprims up to `ObjectEnd` under a handle.
    object_begin(handle: &str) = "ObjectBegin";
    /// `ObjectEnd`
    object_end() = "ObjectEnd";
    /// `ObjectInstance`
    object_instance(handle: &str) = "ObjectInstance";
    /// `SolidBegin`
    solid_begin(operation: &str) = "SolidBegin";
    /// `SolidEnd`
    solid_end() = "SolidEnd";
    /// `MotionBegin`
    motion_begin(times: Vec<f32>) = "MotionBegin";
    /// `MotionEnd`
    motion_end() = "MotionEnd";

    /// `Format`: pixels and pixel aspect ratio.
    format(width: i32, height: i32, aspect: f32) = "Format";
    /// `FrameAspectRatio`
    frame_aspect_ratio(ratio: f32) = "FrameAspectRatio";
    /// `ScreenWindow`
    screen_window(left: f32, right: f32, bottom: f32, top: f32) = "ScreenWindow";
    /// `CropWindow`: fractions of the image.
    crop_window(x_min: f32, x_max: f32, y_min: f32, y_max: f32) = "CropWindow";
    /// `Projection`
    projection(name: &str, params: Params) = "Projection";
    /// `Clipping`: near and far.
    clipping(near: f32, far: f32) = "Clipping";
    /// `DepthOfField`
    depth_of_field(f_stop: f32, focal_length: f32, focal_distance: f32) = "DepthOfField";
    /// `Shutter`
    shutter(open: f32, close: f32) = "Shutter";
    /// `PixelSamples`: along x and y.
    pixel_samples(x: f32, y: f32) = "PixelSamples";
    /// `PixelFilter`: name and widths, pixels.
    pixel_filter(name: &str, x_width: f32, y_width: f32) = "PixelFilter";
    /// `Exposure`: gain and gamma.
    exposure(gain: f32, gamma: f32) = "Exposure";
    /// `Imager`
    imager(name: &str, params: Params) = "Imager";
    /// `Quantize`
    quantize(kind: &str, one: i32, min: i32, max: i32, dither: f32) = "Quantize";
    /// `Display`: file, type (`png`, `exr`, `file`, `framebuffer`) and mode (`rgb`, `rgba`).
    display(name: &str, kind: &str, mode: &str, params: Params) = "Display";
    /// `Hider`
    hider(name: &str, params: Params) = "Hider";
    /// `Option`
    option(name: &str, params: Params) = "Option";

    /// `Attribute`
    attribute(name: &str, params: Params) = "Attribute";
    /// `Color`
    color(color: [f32; 3]) = "Color";
    /// `Opacity`
    opacity(opacity: [f32; 3]) = "Opacity";
    /// `LightSource`: shader and handle.
    light_source(name: &str, handle: &str, params: Params) = "LightSource";
    /// `AreaLightSource`
    area_light_source(name: &str, handle: &str, params: Params) = "AreaLightSource";
    /// `Illuminate`: switch a light.
    illuminate(handle: &str, on: bool) = "Illuminate";
    /// `Surface`
    surface(name: &str, params: Params) = "Surface";
    /// `Displacement`
    displacement(name: &str, params: Params) = "Displacement";
    /// `Atmosphere`
    atmosphere(name: &str, params: Params) = "Atmosphere";
    /// `Interior`
    interior(name: &str, params: Params) = "Interior";
    /// `Exterior`
    exterior(name: &str, params: Params) = "Exterior";
    /// `ShadingRate`: pixels a micropolygon.
    shading_rate(size: f32) = "ShadingRate";
    /// `ShadingInterpolation`: `constant` or `smooth`.
    shading_interpolation(kind: &str) = "ShadingInterpolation";
    /// `Matte`
    matte(on: bool) = "Matte";
    /// `Bound`
    bound(bound: [f32; 6]) = "Bound";
    /// `Orientation`: `outside`, `inside`, `lh` or `rh`.
    orientation(kind: &str) = "Orientation";
    /// `ReverseOrientation`
    reverse_orientation() = "ReverseOrientation";
    /// `Sides`: 1 or 2.
    sides(sides: i32) = "Sides";

    /// `Identity`
    identity() = "Identity";
    /// `Transform`: replace the current transformation.
    transform(matrix: [f32; 16]) = "Transform";
    /// `ConcatTransform`: put a transformation before the current one.
    concat_transform(matrix: [f32; 16]) = "ConcatTransform";
    /// `Perspective`
    perspective(fov: f32) = "Perspective";
    /// `Translate`
    translate(by: [f32; 3]) = "Translate";
    /// `Rotate`: degrees about an axis.
    rotate(angle: f32, axis: [f32; 3]) = "Rotate";
    /// `Scale`
    scale(by: [f32; 3]) = "Scale";
    /// `Skew`
    skew(angle: f32, from: [f32; 3], to: [f32; 3]) = "Skew";
    /// `CoordinateSystem`: name the current space.
    coordinate_system(name: &str) = "CoordinateSystem";
    /// `CoordSysTransform`: go to a named space.
    coord_sys_transform(name: &str) = "CoordSysTransform";

    /// `Polygon`: a convex one.
    polygon(params: Params) = "Polygon";
    /// `GeneralPolygon`
    general_polygon(n_vertices: Vec<i32>, params: Params) = "GeneralPolygon";
    /// `PointsPolygons`: convex ones that share vertices.
    points_polygons(n_vertices: Vec<i32>, vertices: Vec<i32>, params: Params) = "PointsPolygons";
    /// `PointsGeneralPolygons`
    points_general_polygons(n_loops: Vec<i32>, n_vertices: Vec<i32>, vertices: Vec<i32>, params: Params) = "PointsGeneralPolygons";
    /// `Basis`: names and steps in u and v.
    basis(u: [f32; 16], u_step: i32, v: [f32; 16], v_step: i32) = "Basis";
    /// `Patch`: `bilinear` or `bicubic`.
    patch(kind: &str, params: Params) = "Patch";
    /// `PatchMesh`
    patch_mesh(kind: &str, nu: i32, u_wrap: &str, nv: i32, v_wrap: &str, params: Params) = "PatchMesh";
    /// `Sphere`
    sphere(radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) = "Sphere";


    /// `Cone`
    cone(height: f32, radius: f32, sweep: f32, params: Params) = "Cone";
    /// `Cylinder`
    cylinder(radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) = "Cylinder";
    /// `Hyperboloid`: a line from one point to another, swept.
    hyperboloid(from: [f32; 3], to: [f32; 3], sweep: f32, params: Params) = "Hyperboloid";
    /// `Paraboloid`
    paraboloid(radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) = "Paraboloid";
    /// `Disk`
    disk(height: f32, radius: f32, sweep: f32, params: Params) = "Disk";
    /// `Torus`: radii, angles of the tube in degrees, and sweep.
    torus(major: f32, minor: f32, phi_min: f32, phi_max: f32, sweep: f32, params: Params) = "Torus";
    /// `Points`
    points(params: Params) = "Points";
    /// `Curves`: `linear` or `cubic`, vertices of each, `periodic` or `nonperiodic`.
    curves(kind: &str, n_vertices: Vec<i32>, wrap: &str, params: Params) = "Curves";
    /// `NuPatch`: numbers, orders, knots and ranges along u and v.
    nu_patch(u: Knots, v: Knots, params: Params) = "NuPatch";
    /// `TrimCurve`: loops of curves in the parameters of the patches that follow.
    trim_curve(curves: TrimCurves) = "TrimCurve";
    /// `SubdivisionMesh`: scheme, faces, tags with their numbers of integers and floats.
    subdivision_mesh(scheme: &str, n_vertices: Vec<i32>, vertices: Vec<i32>, tags: Tags, params: Params) = "SubdivisionMesh";
    /// `Blobby`: number of leaves, codes, floats and strings.
    blobby(leaves: i32, codes: Vec<i32>, floats: Vec<f32>, strings: Vec<String>, params: Params) = "Blobby";
    /// `Geometry`
    geometry(name: &str, params: Params) = "Geometry";

    /// `Detail`: a bound whose size on the raster is the level of detail.
    detail_bound(bound: [f32; 6]) = "Detail";
    /// `DetailRange`
    detail_range(range: [f32; 4]) = "DetailRange";
    /// `RelativeDetail`
    relative_detail(factor: f32) = "RelativeDetail";
    /// `GeometricApproximation`
    geometric_approximation(kind: &str, value: f32) = "GeometricApproximation";
    /// `TextureCoordinates`: s and t of the four corners.
    texture_coordinates(corners: [f32; 8]) = "TextureCoordinates";
    /// `ColorSamples`: to RGB and from it.
    color_samples(to_rgb: Vec<f32>, from_rgb: Vec<f32>) = "ColorSamples";
    /// `PixelVariance`
    pixel_variance(variance: f32) = "PixelVariance";
    /// `Deformation`
    deformation(name: &str, params: Params) = "Deformation";
    /// `ErrorHandler`
    error_handler(name: &str) = "ErrorHandler";
    /// `MakeTexture`: picture, texture, wraps, filter and its widths.
    make_texture(from: &str, to: &str, wraps: [&str; 2], filter: &str, widths: [f32; 2], params: Params) = "MakeTexture";
    /// `MakeLatLongEnvironment`
    make_lat_long_environment(from: &str, to: &str, filter: &str, widths: [f32; 2], params: Params) = "MakeLatLongEnvironment";
    /// `MakeCubeFaceEnvironment`: six pictures, the texture, the faces' angle, filter and its widths.
    make_cube_face_environment(from: Vec<String>, to: &str, fov: f32, filter: &str, widths: [f32; 2], params: Params) = "MakeCubeFaceEnvironment";
    /// `MakeShadow`
    make_shadow(from: &str, to: &str, params: Params) = "MakeShadow";

    /// A structured comment or any other record: kind `comment` or `structure`, and its text.
    archive_record(kind: &str, text: &str) = "ArchiveRecord";
}
