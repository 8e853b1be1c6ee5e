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
            /// version of the RIB format.
            version [any] => version(number (number: f32));
            /// name a parameter's class and type.
            Declare [any] => declare(declaration (name: &str, declaration: &str));
            /// begin a frame.
            FrameBegin [options opens] => frame_begin(frame (number: i32));
            /// end a frame; options are as they were before it.
            FrameEnd [options closes] => frame_end();
            /// options are frozen, the current transformation becomes the camera's.
            WorldBegin [options opens] => world_begin();
            /// the image is rendered.
            WorldEnd [world closes] => world_end();
            /// save the attributes.
            AttributeBegin [any opens] => attribute_begin();
            /// restore the attributes.
            AttributeEnd [any closes] => attribute_end();
            /// save the transformation.
            TransformBegin [any opens] => transform_begin();
            /// restore the transformation.
            TransformEnd [any closes] => transform_end();
            /// retain the gprims up to `ObjectEnd` under a handle.
            ObjectBegin [any opens] => object_begin(handle (handle: &str));
            /// end a retained object.
            ObjectEnd [any closes] => object_end();
            /// draw a retained object.
            ObjectInstance [world] => object_instance(handle (handle: &str));
            /// begin a solid: `primitive`, `union`, `intersection` or `difference`.
            SolidBegin [world opens] => solid_begin(text (operation: &str));
            /// end a solid.
            SolidEnd [world closes] => solid_end();
            /// the calls up to `MotionEnd` are of these times.
            MotionBegin [any opens] => motion_begin(floats (times: Vec<f32>));
            /// end a motion block.
            MotionEnd [any closes] => motion_end();
            /// pixels and pixel aspect ratio.
            Format [options] => format(whole (width: i32) whole (height: i32) number (aspect: f32));
            /// width over height of the image.
            FrameAspectRatio [options] => frame_aspect_ratio(number (ratio: f32));
            /// the part of the screen that the image shows.
            ScreenWindow [options] => screen_window(numbers "left, right, bottom and top" (left: f32, right: f32, bottom: f32, top: f32));
            /// fractions of the image that are rendered.
            CropWindow [options] => crop_window(numbers "x and y ranges" (x_min: f32, x_max: f32, y_min: f32, y_max: f32));
            /// `perspective`, `orthographic` or none.
            Projection [options] => projection(text (name: &str) params (params: Params));
            /// near and far.
            Clipping [options] => clipping(numbers "near and far" (near: f32, far: f32));
            /// the camera's lens; without arguments a pinhole.
            DepthOfField [options] => depth_of_field(lens (f_stop: f32, focal_length: f32, focal_distance: f32));
            /// when the shutter opens and closes.
            Shutter [options] => shutter(numbers "opening and closing time" (open: f32, close: f32));
            /// samples of a pixel along x and y.
            PixelSamples [options] => pixel_samples(numbers "samples along x and y" (x: f32, y: f32));
            /// name and widths, pixels.
            PixelFilter [options] => pixel_filter(text (name: &str) numbers "filter widths" (x_width: f32, y_width: f32));
            /// gain and gamma.
            Exposure [options] => exposure(numbers "gain and gamma" (gain: f32, gamma: f32));
            /// an imager shader.
            Imager [options] => imager(text (name: &str) params (params: Params));
            /// what is quantized (`rgba` or `z`), the value of 1, the range and the dither.
            Quantize [options] => quantize(text (kind: &str) numbers "one, min, max and dither" (one: i32, min: i32, max: i32, dither: f32));
            /// file, type (`png`, `exr`, `file`, `framebuffer`) and mode (`rgb`, `rgba`).
            Display [options] => display(text (name: &str) text (kind: &str) text (mode: &str) params (params: Params));
            /// how hidden surfaces are removed.
            Hider [options] => hider(text (name: &str) params (params: Params));
            /// an option of the renderer's own.
            Option [options] => option(setting (name: &str, params: Params));
            /// an attribute of the renderer's own.
            Attribute [any] => attribute(text (name: &str) params (params: Params));
            /// surface colour.
            Color [any] => color(list "a colour" (color: [f32; 3]));
            /// surface opacity.
            Opacity [any] => opacity(list "an opacity" (opacity: [f32; 3]));
            /// shader and handle.
            LightSource [any] => light_source(text (name: &str) handle (handle: &str) params (params: Params));
            /// shader and handle of a light that the gprims after it emit.
            AreaLightSource [world] => area_light_source(text (name: &str) handle (handle: &str) params (params: Params));
            /// switch a light.
            Illuminate [any] => illuminate(handle (handle: &str) flag (on: bool));
            /// surface shader.
            Surface [any] => surface(text (name: &str) params (params: Params));
            /// displacement shader.
            Displacement [any] => displacement(text (name: &str) params (params: Params));
            /// volume shader of what lies between the eye and the surface.
            Atmosphere [any] => atmosphere(text (name: &str) params (params: Params));
            /// volume shader of the inside.
            Interior [any] => interior(text (name: &str) params (params: Params));
            /// volume shader of the outside.
            Exterior [any] => exterior(text (name: &str) params (params: Params));
            /// pixels a micropolygon.
            ShadingRate [any] => shading_rate(number (size: f32));
            /// `constant` or `smooth`.
            ShadingInterpolation [any] => shading_interpolation(text (kind: &str));
            /// hide what is behind, and show nothing.
            Matte [any] => matte(flag (on: bool));
            /// a box around the gprims that follow.
            Bound [any] => bound(list "a bound" (bound: [f32; 6]));
            /// `outside`, `inside`, `lh` or `rh`.
            Orientation [any] => orientation(text (kind: &str));
            /// turn the outside in.
            ReverseOrientation [any] => reverse_orientation();
            /// visible sides: 1 or 2.
            Sides [any] => sides(whole (sides: i32));
            /// reset the current transformation.
            Identity [any] => identity();
            /// replace the current transformation.
            Transform [any] => transform(list "a matrix" (matrix: [f32; 16]));
            /// put a transformation before the current one.
            ConcatTransform [any] => concat_transform(list "a matrix" (matrix: [f32; 16]));
            /// a perspective transformation, degrees.
            Perspective [any] => perspective(number (fov: f32));
            /// move.
            Translate [any] => translate(numbers "a translation" (by: [f32; 3]));
            /// rotate about an axis, degrees.
            Rotate [any] => rotate(numbers "an angle and an axis" (angle: f32, axis: [f32; 3]));
            /// scale along the axes.
            Scale [any] => scale(numbers "three factors" (by: [f32; 3]));
            /// shear one direction towards another, degrees.
            Skew [any] => skew(list "an angle and two directions" (angle: f32, from: [f32; 3], to: [f32; 3]));
            /// name the current space.
            CoordinateSystem [any] => coordinate_system(text (name: &str));
            /// go to a named space.
            CoordSysTransform [any] => coord_sys_transform(text (name: &str));
            /// a convex polygon.
            Polygon [world] => polygon(params (params: Params));
            /// a polygon with holes.
            GeneralPolygon [world] => general_polygon(wholes (n_vertices: Vec<i32>) params (params: Params));
            /// convex polygons that share vertices.
            PointsPolygons [world] => points_polygons(wholes (n_vertices: Vec<i32>) wholes (vertices: Vec<i32>) params (params: Params));
            /// polygons with holes that share vertices.
            PointsGeneralPolygons [world] => points_general_polygons(
                wholes (n_loops: Vec<i32>) wholes (n_vertices: Vec<i32>) wholes (vertices: Vec<i32>) params (params: Params));
            /// matrices and steps of patches and curves in u and v.
            Basis [any] => basis(basis (u: [f32; 16]) whole (u_step: i32) basis (v: [f32; 16]) whole (v_step: i32));
            /// `bilinear` or `bicubic`.
            Patch [world] => patch(text (kind: &str) params (params: Params));
            /// kind, vertices and `periodic` or `nonperiodic`, along u and v.
            PatchMesh [world] => patch_mesh(
                text (kind: &str) whole (nu: i32) text (u_wrap: &str) whole (nv: i32) text (v_wrap: &str) params (params: Params));
            /// a sphere or a part of it, about z.
            Sphere [world] => sphere(
                numbers "radius, zmin, zmax and thetamax" (radius: f32, z_min: f32, z_max: f32, sweep: f32) params (params: Params));
            /// read an archive in its place.
            ReadArchive [any];
            /// a cone about z.
            Cone [world] => cone(numbers "height, radius and thetamax" (height: f32, radius: f32, sweep: f32) params (params: Params));
            /// a cylinder about z.
            Cylinder [world] => cylinder(
                numbers "radius, zmin, zmax and thetamax" (radius: f32, z_min: f32, z_max: f32, sweep: f32) params (params: Params));
            /// a line from one point to another, swept about z.
            Hyperboloid [world] => hyperboloid(
                numbers "two points and thetamax" (from: [f32; 3], to: [f32; 3], sweep: f32) params (params: Params));
            /// a paraboloid about z.
            Paraboloid [world] => paraboloid(
                numbers "rmax, zmin, zmax and thetamax" (radius: f32, z_min: f32, z_max: f32, sweep: f32) params (params: Params));
            /// a disk about z.
            Disk [world] => disk(numbers "height, radius and thetamax" (height: f32, radius: f32, sweep: f32) params (params: Params));
            /// radii, angles of the tube in degrees, and sweep.
            Torus [world] => torus(
                numbers "radii, phimin, phimax and thetamax" (major: f32, minor: f32, phi_min: f32, phi_max: f32, sweep: f32)
                params (params: Params));
            /// points with widths.
            Points [world] => points(params (params: Params));
            /// `linear` or `cubic`, vertices of each, `periodic` or `nonperiodic`.
            Curves [world] => curves(text (kind: &str) wholes (n_vertices: Vec<i32>) text (wrap: &str) params (params: Params));
            /// numbers, orders, knots and ranges along u and v.
            NuPatch [world] => nu_patch(knots (u: Knots) knots (v: Knots) params (params: Params));
            /// loops of curves in the parameters of the patches that follow.
            TrimCurve [any] => trim_curve(trim_curves (curves: TrimCurves));
            /// scheme, faces, tags with their numbers of integers and floats.
            SubdivisionMesh [world] => subdivision_mesh(
                text (scheme: &str) wholes (n_vertices: Vec<i32>) wholes (vertices: Vec<i32>) tags (tags: Tags) params (params: Params));
            /// number of leaves, codes, floats and strings.
            Blobby [world] => blobby(
                whole (leaves: i32) wholes (codes: Vec<i32>) floats (floats: Vec<f32>) texts (strings: Vec<String>)
                params (params: Params));
            /// a gprim of the renderer's own.
            Geometry [world] => geometry(text (name: &str) params (params: Params));
            /// a program or an archive that makes gprims.
            Procedural [world];
            /// a bound whose size on the raster is the level of detail.
            Detail [any] => detail_bound(list "a bound" (bound: [f32; 6]));
            /// sizes between which the gprims that follow are drawn.
            DetailRange [any] => detail_range(list "four sizes" (range: [f32; 4]));
            /// a factor of the level of detail.
            RelativeDetail [options] => relative_detail(number (factor: f32));
            /// how far curved surfaces may be from their polygons.
            GeometricApproximation [any] => geometric_approximation(text (kind: &str) number (value: f32));
            /// s and t of the four corners.
            TextureCoordinates [any] => texture_coordinates(list "s and t of four corners" (corners: [f32; 8]));
            /// to RGB and from it.
            ColorSamples [options] => color_samples(floats (to_rgb: Vec<f32>) floats (from_rgb: Vec<f32>));
            /// how much a pixel may vary.
            PixelVariance [options] => pixel_variance(number (variance: f32));
            /// a deformation shader.
            Deformation [any] => deformation(text (name: &str) params (params: Params));
            /// what is done about errors.
            ErrorHandler [any] => error_handler(text (name: &str));
            /// image, texture, wraps, filter and its widths.
            MakeTexture [options] => make_texture(
                text (from: &str) text (to: &str) text_pair (wraps: [&str; 2]) text (filter: &str)
                numbers "filter widths" (widths: [f32; 2]) params (params: Params));
            /// image, texture, filter and its widths.
            MakeLatLongEnvironment [options] => make_lat_long_environment(
                text (from: &str) text (to: &str) text (filter: &str) numbers "filter widths" (widths: [f32; 2])
                params (params: Params));
            /// six images, the texture, the faces' angle, filter and its widths.
            MakeCubeFaceEnvironment [options] => make_cube_face_environment(
                six_texts (from: Vec<String>) text (to: &str) number (fov: f32) text (filter: &str)
                numbers "filter widths" (widths: [f32; 2]) params (params: Params));
            /// depth image and shadow map.
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
