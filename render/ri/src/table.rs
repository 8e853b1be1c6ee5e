//! The table of RIB's requests: where each may stand, its arguments, and the call of [`crate::ri::Ri`] that it makes.
//!
//! A row is
//! ```text
//! /// What it does.
//! Name [where] => method(kind "what" (argument: type, …) kind (argument: type) …);
//! ```
//! *where* is `options` (before WorldBegin), `world` (between WorldBegin and WorldEnd) or `any`, and `opens` or `closes` if the
//! request begins or ends a block; `standing.rs` warns of what stands elsewhere. A *kind* says how an argument stands in the stream
//! and is written back:
//!
//! | kind | in the stream |
//! |---|---|
//! | `text` `handle` `whole` `number` `flag` | a string; a handle; a whole number; a number; 0 or 1 |
//! | `numbers "what"` | exactly as many numbers as the arguments hold, one after the other; *what* is said where they are missing |
//! | `list "what"` | the same, written in brackets; both are read with brackets or without |
//! | `floats` `wholes` `texts` | a bracketed list of any length |
//! | `params` | the parameter list that ends a request |
//! | `grouped` | a text and the parameters of the group that it names |
//! | `declaration` `frame` `setting` | texts, a number, and text with parameters that later requests depend on |
//! | others | groups that one request has: read in `groups.rs`, written in `line.rs` |
//!
//! A row without a call is done by the reader itself. The trait's methods, the request's name and code, its place in the hash of
//! names, the names that are suggested for a misspelt one, the dispatch and the writer all come from these rows: a new request is a row,
//! and the method of each [`crate::ri::Ri`] that does something for it.

/// Hand all rows to a macro.
macro_rules! requests {
    ($rows:ident) => {
        $rows! {
            /// version of the RIB format; a stream begins with it.
            version [any] => version(number (number: f32));
            /// declare the storage class and type of a parameter's name.
            Declare [any] => declare(declaration (name: &str, declaration: &str));
            /// begin a frame and save the options.
            FrameBegin [options opens] => frame_begin(frame (number: i32));
            /// end a frame and restore the options.
            FrameEnd [options closes] => frame_end();
            /// freeze the options; the current transformation becomes that from world to camera.
            WorldBegin [options opens] => world_begin();
            /// render the image; the transformation is as before `WorldBegin`.
            WorldEnd [world closes] => world_end();
            /// save the attributes.
            AttributeBegin [any opens] => attribute_begin();
            /// restore the attributes.
            AttributeEnd [any closes] => attribute_end();
            /// save the transformation.
            TransformBegin [any opens] => transform_begin();
            /// restore the transformation.
            TransformEnd [any closes] => transform_end();
            /// begin a retained object: keep the gprims up to `ObjectEnd` under a handle.
            ObjectBegin [any opens] => object_begin(handle (handle: &str));
            /// end a retained object.
            ObjectEnd [any closes] => object_end();
            /// draw a retained object under the current transformation.
            ObjectInstance [world] => object_instance(handle (handle: &str));
            /// begin a solid: `primitive`, `union`, `intersection` or `difference`.
            SolidBegin [world opens] => solid_begin(text (operation: &str));
            /// end a solid.
            SolidEnd [world closes] => solid_end();
            /// begin a motion block: one call up to `MotionEnd` for each of these times.
            MotionBegin [any opens] => motion_begin(floats (times: Vec<f32>));
            /// end a motion block.
            MotionEnd [any closes] => motion_end();
            /// width and height of the image in pixels, and pixel aspect ratio (width over height of a pixel).
            Format [options] => format(whole (width: i32) whole (height: i32) number (aspect: f32));
            /// width over height of the image.
            FrameAspectRatio [options] => frame_aspect_ratio(number (ratio: f32));
            /// the rectangle of screen space that the image shows.
            ScreenWindow [options] => screen_window(numbers "left, right, bottom and top" (left: f32, right: f32, bottom: f32, top: f32));
            /// the rectangle to render, as fractions from 0 to 1 of the image's width and height.
            CropWindow [options] => crop_window(numbers "x and y ranges" (x_min: f32, x_max: f32, y_min: f32, y_max: f32));
            /// set the projection: `perspective` (parameter `fov`, degrees), `orthographic` or none.
            Projection [options] => projection(text (name: &str) params (params: Params));
            /// distances of the near and far clipping planes, camera space.
            Clipping [options] => clipping(numbers "near and far" (near: f32, far: f32));
            /// clip what lies on the side of a plane that its normal points to: a point of it and its normal, current space.
            ClippingPlane [any] => clipping_plane(numbers "a point and a normal" (point: [f32; 3], normal: [f32; 3]));
            /// f-stop, focal length and focal distance of the lens; without arguments a pinhole.
            DepthOfField [options] => depth_of_field(lens (f_stop: f32, focal_length: f32, focal_distance: f32));
            /// times at which the shutter opens and closes.
            Shutter [options] => shutter(numbers "opening and closing time" (open: f32, close: f32));
            /// count of samples per pixel along x and y.
            PixelSamples [options] => pixel_samples(numbers "samples along x and y" (x: f32, y: f32));
            /// name of the pixel filter and its full widths, pixels.
            PixelFilter [options] => pixel_filter(text (name: &str) numbers "filter widths" (x_width: f32, y_width: f32));
            /// gain and gamma of the exposure: (gain · c)^(1/gamma).
            Exposure [options] => exposure(numbers "gain and gamma" (gain: f32, gamma: f32));
            /// set the imager shader.
            Imager [options] => imager(text (name: &str) params (params: Params));
            /// quantization of `rgba` or `z`: the value that 1 maps to, minimum, maximum and amplitude of the dither.
            Quantize [options] => quantize(text (kind: &str) numbers "one, min, max and dither" (one: i32, min: i32, max: i32, dither: f32));
            /// add a display: file, type (`png`, `tiff`, `exr`, `file`) and mode (`rgb`, `rgba`, `a`, `z`, a variable …).
            Display [options] => display(text (name: &str) text (kind: &str) text (mode: &str) params (params: Params));
            /// set the hidden-surface algorithm: `hidden`, `z` or `null`.
            Hider [options] => hider(text (name: &str) params (params: Params));
            /// set an implementation-specific option.
            Option [options] => option(setting (name: &str, params: Params));
            /// set an implementation-specific attribute.
            Attribute [any] => attribute(grouped (name: &str, params: Params));
            /// set the surface colour.
            Color [any] => color(colour (color: [f32; 3]));
            /// set the surface opacity.
            Opacity [any] => opacity(colour (opacity: [f32; 3]));
            /// add a light source: light shader and handle.
            LightSource [any] => light_source(text (name: &str) handle (handle: &str) params (params: Params));
            /// add an area light, emitted by the gprims that follow: light shader and handle.
            AreaLightSource [world] => area_light_source(text (name: &str) handle (handle: &str) params (params: Params));
            /// switch a light on or off.
            Illuminate [any] => illuminate(handle (handle: &str) flag (on: bool));
            /// set the surface shader.
            Surface [any] => surface(text (name: &str) params (params: Params));
            /// set the displacement shader.
            Displacement [any] => displacement(text (name: &str) params (params: Params));
            /// set the volume shader between the eye and the surface.
            Atmosphere [any] => atmosphere(text (name: &str) params (params: Params));
            /// set the volume shader inside the surface.
            Interior [any] => interior(text (name: &str) params (params: Params));
            /// set the volume shader outside the surface.
            Exterior [any] => exterior(text (name: &str) params (params: Params));
            /// maximum area of a micropolygon on the raster, pixels.
            ShadingRate [any] => shading_rate(number (size: f32));
            /// interpolation of shaded colours over micropolygons, `constant` or `smooth`.
            ShadingInterpolation [any] => shading_interpolation(text (kind: &str));
            /// whether the gprims that follow are holdouts: they hide surfaces behind them and have no colour or coverage.
            Matte [any] => matte(flag (on: bool));
            /// set a bounding box of the gprims that follow, object space.
            Bound [any] => bound(list "a bound" (bound: [f32; 6]));
            /// set the orientation of surfaces: `outside`, `inside`, `lh` or `rh`.
            Orientation [any] => orientation(text (kind: &str));
            /// reverse the orientation of surfaces.
            ReverseOrientation [any] => reverse_orientation();
            /// count of visible sides: 1 or 2.
            Sides [any] => sides(whole (sides: i32));
            /// set the current transformation to the identity.
            Identity [any] => identity();
            /// replace the current transformation.
            Transform [any] => transform(list "a matrix" (matrix: [f32; 16]));
            /// concatenate a transformation onto the current one: it is applied first.
            ConcatTransform [any] => concat_transform(list "a matrix" (matrix: [f32; 16]));
            /// concatenate a perspective transformation of this full angle of view, degrees.
            Perspective [any] => perspective(number (fov: f32));
            /// concatenate a translation.
            Translate [any] => translate(numbers "a translation" (by: [f32; 3]));
            /// concatenate a rotation about an axis, degrees.
            Rotate [any] => rotate(numbers "an angle and an axis" (angle: f32, axis: [f32; 3]));
            /// concatenate a scaling along the axes.
            Scale [any] => scale(numbers "three factors" (by: [f32; 3]));
            /// concatenate a shear of one direction towards another, degrees.
            Skew [any] => skew(list "an angle and two directions" (angle: f32, from: [f32; 3], to: [f32; 3]));
            /// give a name to the current coordinate system.
            CoordinateSystem [any] => coordinate_system(text (name: &str));
            /// make a named coordinate system the current one.
            CoordSysTransform [any] => coord_sys_transform(text (name: &str));
            /// draw a convex polygon.
            Polygon [world] => polygon(params (params: Params));
            /// draw a polygon with holes; count of vertices in each loop.
            GeneralPolygon [world] => general_polygon(wholes (n_vertices: Vec<i32>) params (params: Params));
            /// draw convex polygons that share vertices; count of vertices in each polygon, and vertex indices.
            PointsPolygons [world] => points_polygons(wholes (n_vertices: Vec<i32>) wholes (vertices: Vec<i32>) params (params: Params));
            /// draw polygons with holes that share vertices; counts of loops and of their vertices, and vertex indices.
            PointsGeneralPolygons [world] => points_general_polygons(
                wholes (n_loops: Vec<i32>) wholes (n_vertices: Vec<i32>) wholes (vertices: Vec<i32>) params (params: Params));
            /// set the basis matrices and steps of cubic patches and curves in u and v.
            Basis [any] => basis(basis (u: [f32; 16]) whole (u_step: i32) basis (v: [f32; 16]) whole (v_step: i32));
            /// draw a `bilinear` or `bicubic` patch.
            Patch [world] => patch(text (kind: &str) params (params: Params));
            /// draw a `bilinear` or `bicubic` patch mesh; count of vertices and `periodic` or `nonperiodic`, along u and v.
            PatchMesh [world] => patch_mesh(
                text (kind: &str) whole (nu: i32) text (u_wrap: &str) whole (nv: i32) text (v_wrap: &str) params (params: Params));
            /// draw a sphere about z, cut off at `z_min` and `z_max`; `sweep` in degrees, as for all quadrics.
            Sphere [world] => sphere(
                numbers "radius, zmin, zmax and thetamax" (radius: f32, z_min: f32, z_max: f32, sweep: f32) params (params: Params));
            /// read an archive in its place.
            ReadArchive [any];
            /// draw a cone about z, its base at z = 0.
            Cone [world] => cone(numbers "height, radius and thetamax" (height: f32, radius: f32, sweep: f32) params (params: Params));
            /// draw a cylinder about z.
            Cylinder [world] => cylinder(
                numbers "radius, zmin, zmax and thetamax" (radius: f32, z_min: f32, z_max: f32, sweep: f32) params (params: Params));
            /// draw a hyperboloid: a line from one point to another, swept about z.
            Hyperboloid [world] => hyperboloid(
                numbers "two points and thetamax" (from: [f32; 3], to: [f32; 3], sweep: f32) params (params: Params));
            /// draw a paraboloid about z, its minimum at the origin.
            Paraboloid [world] => paraboloid(
                numbers "rmax, zmin, zmax and thetamax" (radius: f32, z_min: f32, z_max: f32, sweep: f32) params (params: Params));
            /// draw a disk about z at this height.
            Disk [world] => disk(numbers "height, radius and thetamax" (height: f32, radius: f32, sweep: f32) params (params: Params));
            /// draw a torus about z: major and minor radius, range of angles of the tube in degrees, and sweep.
            Torus [world] => torus(
                numbers "radii, phimin, phimax and thetamax" (major: f32, minor: f32, phi_min: f32, phi_max: f32, sweep: f32)
                params (params: Params));
            /// draw points with widths.
            Points [world] => points(params (params: Params));
            /// draw `linear` or `cubic` curves; count of vertices of each, and `periodic` or `nonperiodic`.
            Curves [world] => curves(text (kind: &str) wholes (n_vertices: Vec<i32>) text (wrap: &str) params (params: Params));
            /// draw a NURBS patch; counts of control points, orders, knots and ranges along u and v.
            NuPatch [world] => nu_patch(knots (u: Knots) knots (v: Knots) params (params: Params));
            /// set the trim curves of the NURBS patches that follow, in their parameter plane.
            TrimCurve [any] => trim_curve(trim_curves (curves: TrimCurves));
            /// draw a subdivision mesh; scheme, count of vertices of each face, vertex indices, and tags.
            SubdivisionMesh [world] => subdivision_mesh(
                text (scheme: &str) wholes (n_vertices: Vec<i32>) wholes (vertices: Vec<i32>) tags (tags: Tags) params (params: Params));
            /// draw an implicit surface; count of leaves, operation codes, floats and strings.
            Blobby [world] => blobby(
                whole (leaves: i32) wholes (codes: Vec<i32>) floats (floats: Vec<f32>) texts (strings: Vec<String>)
                params (params: Params));
            /// draw an implementation-specific gprim.
            Geometry [world] => geometry(text (name: &str) params (params: Params));
            /// a program or an archive that makes gprims.
            Procedural [world];
            /// set the bound, object space, whose area on the raster is the level of detail.
            Detail [any] => detail_bound(list "a bound" (bound: [f32; 6]));
            /// range of the level of detail in which the gprims that follow are drawn, with transitions.
            DetailRange [any] => detail_range(list "four sizes" (range: [f32; 4]));
            /// factor on all levels of detail.
            RelativeDetail [options] => relative_detail(number (factor: f32));
            /// tolerance by which dicing may deviate from curved surfaces.
            GeometricApproximation [any] => geometric_approximation(text (kind: &str) number (value: f32));
            /// set the texture coordinates s and t of the four corners of primitives.
            TextureCoordinates [any] => texture_coordinates(list "s and t of four corners" (corners: [f32; 8]));
            /// set the count of colour components by the matrices to RGB and from RGB.
            ColorSamples [options] => color_samples(colour_samples (to_rgb: Vec<f32>, from_rgb: Vec<f32>));
            /// maximum variance of a pixel's colour.
            PixelVariance [options] => pixel_variance(number (variance: f32));
            /// set the deformation shader.
            Deformation [any] => deformation(text (name: &str) params (params: Params));
            /// set the error handler: `ignore`, `print` or `abort`.
            ErrorHandler [any] => error_handler(text (name: &str));
            /// make a texture map of an image; wrap modes in s and t, filter and its widths.
            MakeTexture [options] => make_texture(
                text (from: &str) text (to: &str) text_pair (wraps: [&str; 2]) text (filter: &str)
                numbers "filter widths" (widths: [f32; 2]) params (params: Params));
            /// make an environment map of a latitude-longitude image; filter and its widths.
            MakeLatLongEnvironment [options] => make_lat_long_environment(
                text (from: &str) text (to: &str) text (filter: &str) numbers "filter widths" (widths: [f32; 2])
                params (params: Params));
            /// make an environment map of six images of a cube's faces; their angle of view, filter and its widths.
            MakeCubeFaceEnvironment [options] => make_cube_face_environment(
                six_texts (from: Vec<String>) text (to: &str) number (fov: f32) text (filter: &str)
                numbers "filter widths" (widths: [f32; 2]) params (params: Params));
            /// make a shadow map of a depth image.
            MakeShadow [options] => make_shadow(text (from: &str) text (to: &str) params (params: Params));
            /// what follows holds under a condition.
            IfBegin [any opens];
            /// or else under another.
            ElseIf [any];
            /// or else.
            Else [any];
            /// end a condition.
            IfEnd [any closes];
            /// keep what stands up to `ArchiveEnd` as an archive.
            ArchiveBegin [any opens];
            /// end an archive.
            ArchiveEnd [any closes];
        }
    };
}
pub(crate) use requests;
