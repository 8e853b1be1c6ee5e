//! The names of the RISpec 3.2 itself (requests, options, attributes, functions, variables, keywords and the names that requests take)
//! against what the reader, the renderer and the compiler do with each: it has a case, or it is said that it is not supported.

use crate::cli::{scratch, scree};
use crate::docs::pages::{self, quoted};
use crate::rendering::ORTHO;
use std::collections::BTreeSet;
use std::path::Path;

/// Requests of the RIB binding (RISpec, appendix C), and one of versions before it.
const REQUESTS: &str = "AreaLightSource Atmosphere Attribute AttributeBegin AttributeEnd Basis Blobby Bound Clipping ClippingPlane Color
    ColorSamples ConcatTransform Cone CoordinateSystem CoordSysTransform CropWindow Curves Cylinder Declare Deformation DepthOfField
    Detail DetailRange Disk Displacement Display ErrorHandler Exposure Exterior Format FrameAspectRatio FrameBegin FrameEnd
    GeneralPolygon GeometricApproximation Geometry Hider Hyperboloid Identity Illuminate Imager Interior LightSource
    MakeCubeFaceEnvironment MakeLatLongEnvironment MakeShadow MakeTexture Matte MotionBegin MotionEnd NuPatch ObjectBegin ObjectEnd
    ObjectInstance Opacity Option Orientation Paraboloid Patch PatchMesh Perspective PixelFilter PixelSamples PixelVariance Points
    PointsGeneralPolygons PointsPolygons Polygon Procedural Projection Quantize ReadArchive RelativeDetail ReverseOrientation Rotate
    Scale ScreenWindow ShadingInterpolation ShadingRate Shutter Sides Skew SolidBegin SolidEnd Sphere SubdivisionMesh Surface
    TextureCoordinates Torus Transform TransformBegin TransformEnd Translate TrimCurve WorldBegin WorldEnd version MakeBump";

/// Functions of shaders (RISpec 15).
const FUNCTIONS: &str = "radians degrees sin asin cos acos tan atan pow exp sqrt inversesqrt log mod abs sign min max clamp mix floor
    ceil round step smoothstep filterstep spline Du Dv Deriv random noise pnoise cellnoise xcomp ycomp zcomp setxcomp setycomp
    setzcomp length normalize distance ptlined rotate area faceforward reflect refract fresnel transform vtransform ntransform depth
    calculatenormal comp setcomp ctransform determinant translate scale concat printf format match ambient diffuse specular
    specularbrdf phong trace texture environment shadow textureinfo atmosphere displacement lightsource surface incident opposite
    attribute option rendererinfo shadername";

/// Global variables of shaders (RISpec 12).
const VARIABLES: &str = "Cs Os P dPdu dPdv N Ng u v du dv s t L Cl Ol Ci Oi E I ncomps time dtime dPdtime Ps alpha";

/// Keywords of shaders (RISpec 11 to 13).
const KEYWORDS: &str = "break color continue displacement else extern float for if illuminance illuminate imager light matrix normal output
    point return solar string surface transformation uniform varying vector void volume while";

fn words(list: &str) -> impl Iterator<Item = &str> {
    list.split_whitespace()
}

/// The text of all files of rooms of the corpus.
fn corpus(rooms: &[&str]) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    let files = rooms.iter().flat_map(|room| std::fs::read_dir(folder.join(room)).unwrap().map(|e| e.unwrap().path()));
    files.map(|path| String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned() + "\n").collect()
}

/// The words of a text, of letters, digits and `_`.
fn names(text: &str) -> BTreeSet<&str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').collect()
}

/// The names that the page says are not supported.
fn unsupported() -> BTreeSet<String> {
    let page = pages::page("shading.md");
    let rows = page.rows(page.section("Not supported"));
    rows.iter().flat_map(|row| quoted(&row.cells[0])).map(String::from).collect()
}

/// Render a scene of a world after options; its warnings and errors.
fn said(files: &[(&str, &str)], options: &str, world: &str) -> String {
    let work = scratch();
    files.iter().for_each(|(name, text)| std::fs::write(work.path().join(name), text).unwrap());
    let path = work.path().join("t.rib");
    let text = format!("Display \"t.png\" \"png\" \"rgb\"\n{options}\n{ORTHO}\nWorldBegin\n{world}\nWorldEnd\n");
    std::fs::write(&path, text).unwrap();
    scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).errors()
}

#[test]
fn every_request_has_a_case_or_is_said_to_be_unsupported() {
    let text = corpus(&["rib", "values"]);
    let (cases, told) = (names(&text), unsupported());
    let told: BTreeSet<&str> = told.iter().map(String::as_str).collect();
    for request in words(REQUESTS) {
        assert!(cases.contains(request) || told.contains(request), "`{request}` has no case, nor is it said to lack");
        if !cases.contains(request) {
            let warned = said(&[], &format!("{request} \"a\" \"b\" [1]"), "");
            assert!(warned.contains(&format!("`{request}`")), "{request} is not warned of: {warned}");
        }
    }
}

#[test]
fn every_function_variable_and_keyword_has_a_case_or_is_said_to_be_unsupported() {
    let text = corpus(&["shader", "values"]);
    let (cases, told) = (names(&text), unsupported());
    let told: BTreeSet<&str> = told.iter().map(String::as_str).collect();
    for function in words(FUNCTIONS) {
        let is_called = text.contains(&format!("{function}("));
        assert!(is_called || told.contains(function), "`{function}` has no case, nor is it said to lack");
    }
    for name in words(VARIABLES).chain(words(KEYWORDS)) {
        assert!(cases.contains(name) || told.contains(name), "`{name}` has no case, nor is it said to lack");
    }
    // What lacks is an error or a warning that names it.
    for name in words(VARIABLES).filter(|name| !cases.contains(name) || told.contains(name)) {
        let shader = format!("surface t() {{ Oi = 1; Ci = color({name}); }}");
        let answer = said(&[("t.sl", &shader)], "", "Surface \"t\" Disk 0 0.5 360");
        assert!(answer.contains(&format!("`{name}`")), "`{name}` is used silently: {answer}");
    }
    for (name, shader) in [
        ("transformation", "transformation t() { P = P; }"),
        ("bake", "surface t() { bake(\"a\", s, t, 1); Oi = 1; }"),
        ("texture3d", "surface t() { float x = 0; texture3d(\"a\", P, N, \"x\", x); Oi = 1; }"),
        ("filterstep", "surface t() { Oi = 1; Ci = filterstep(0.5, s, \"filter\", \"mitchell\"); }"),
        ("trace", "surface t() { Oi = 1; Ci = trace(P, N, \"samples\", 4); }"),
        ("blurr", "surface t() { Oi = 1; Ci = texture(\"a.png\", s, t, \"blurr\", 1); }"),
    ] {
        let answer = said(&[("t.sl", shader)], "", "Surface \"t\" Disk 0 0.5 360");
        assert!(answer.contains(&format!("`{name}`")), "`{name}` is used silently: {answer}");
    }
}

/// The pairs of a group and a name in the first cells of a section's tables: `"limits" "bucketsize"`.
fn settings(section: &str) -> Vec<[String; 2]> {
    let page = pages::page("shading.md");
    let rows = page.rows(page.section(section));
    let pairs = rows.iter().flat_map(|row| quoted(&row.cells[0]).into_iter().map(String::from).collect::<Vec<_>>());
    let words = pairs.filter(|pair| pair.starts_with('"')).map(|pair| pair.replace('"', ""));
    let split = words.filter_map(|pair| {
        let mut words = pair.split_whitespace().map(String::from);
        Some([words.next()?, words.rfind(|w| !matches!(w.as_str(), "string" | "int"))?])
    });
    split.collect()
}

#[test]
fn options_and_attributes_that_are_described_are_known_and_others_are_warned_of() {
    for (request, section, least) in [("Option", "Options", 6), ("Attribute", "Attributes", 8)] {
        let told = settings(section);
        assert!(told.len() >= least, "{told:?}");
        for [group, name] in told {
            let value = match name.as_str() {
                "colorspace" => "\"string colorspace\" [\"linear\"]".into(),
                "sense" => "\"string sense\" [\"inside\"]".into(),
                "name" | "shadinggroup" => format!("\"string {name}\" [\"a\"]"),
                "coordinatesystem" => "\"float sphere\" [1] \"string coordinatesystem\" [\"world\"]".into(),
                _ if group == "shape" && name != "kind" => format!("\"float[3] {name}\" [1 2 3]"),
                _ if group == "visibility" => format!("\"float {name}\" [1]"),
                _ => format!("\"float {name}\" [16]"),
            };
            let answer = said(&[], &format!("{request} \"{group}\" {value}"), "");
            assert!(!answer.contains("warning") && !answer.contains("error"), "{request} {group} {name}: {answer}");
        }
        // Of other renderers, and slips.
        for (group, name) in
            [("limits", "eyesplits"), ("dice", "binary"), ("displacementbond", "sphere"), ("trace", "bias")]
        {
            let answer = said(&[], &format!("{request} \"{group}\" \"float {name}\" [1]"), "");
            assert!(
                answer.contains(&format!("`{group}:{name}` is not supported")),
                "{request} {group} {name}: {answer}"
            );
        }
        assert!(!said(&[], &format!("{request} \"user\" \"float own\" [1]"), "").contains("warning"));
    }
}

#[test]
fn names_that_requests_take_are_known_and_others_are_refused_or_warned_of() {
    let disk = "Disk 0 0.5 360";
    for (request, known, rest) in [
        ("PixelFilter", "box triangle catmull-rom sinc gaussian", "2 2"),
        ("Projection", "perspective orthographic", ""),
        ("Hider", "hidden null", ""),
        ("ErrorHandler", "print", ""),
        ("Quantize", "rgba", "255 0 255 0.5"),
    ] {
        for name in words(known) {
            let answer = said(&[], &format!("{request} \"{name}\" {rest}"), disk);
            assert!(!answer.contains("error") && !answer.contains("warning"), "{request} {name}: {answer}");
        }
        let answer = said(&[], &format!("{request} \"nonesuch\" {rest}"), disk);
        assert!(answer.contains("`nonesuch`") || answer.contains("\"nonesuch\""), "{request}: {answer}");
    }
    let net = "\"P\" [-0.5 -0.5 0 0.5 -0.5 0 -0.5 0.5 0 0.5 0.5 0]";
    let mesh = "[4] [0 1 2 3] [\"NAME\"] [0 0] [] [] \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
    for (known, world) in [
        ("outside inside lh rh", "Orientation \"NAME\""),
        ("constant smooth", "ShadingInterpolation \"NAME\""),
        ("bezier b-spline catmull-rom hermite power", "Basis \"NAME\" 3 \"NAME\" 3"),
        ("bilinear", &format!("Patch \"NAME\" {net}")),
        ("periodic nonperiodic", &format!("PatchMesh \"bilinear\" 2 \"nonperiodic\" 2 \"NAME\" {net}")),
        ("primitive union intersection difference", "SolidBegin \"NAME\" Sphere 1 -1 1 360 SolidEnd"),
        ("linear", "Curves \"NAME\" [2] \"nonperiodic\" \"P\" [0 0 0 1 0 0]"),
        ("catmull-clark", &format!("SubdivisionMesh \"NAME\" {}", mesh.replace("NAME", "interpolateboundary"))),
        ("interpolateboundary", &format!("SubdivisionMesh \"catmull-clark\" {mesh}")),
        ("teapot", "Geometry \"NAME\""),
        ("inside outside", "Attribute \"trimcurve\" \"sense\" [\"NAME\"]"),
        ("flatness", "GeometricApproximation \"NAME\" 1"),
    ] {
        for name in words(known) {
            let answer = said(&[], "", &world.replace("NAME", name));
            assert!(!answer.contains("error") && !answer.contains("warning"), "{name} of {world}: {answer}");
        }
        let answer = said(&[], "", &world.replace("NAME", "nonesuch"));
        assert!(answer.contains("nonesuch"), "{world}: {answer}");
    }
    for (options, world, message) in [
        ("Hider \"hidden\" \"jitter\" [0]", disk, "parameter `jitter` of the hider has no effect"),
        ("MakeShadow \"a\" \"b\"", disk, "the shadow map `b` is not made"),
        ("MakeTexture \"a\" \"b\" \"round\" \"black\" \"box\" 1 1", disk, "unknown wrap `round`"),
        ("Quantize \"rgba\" 255 200 100 0", disk, "expected levels from 0 to 65535 that do not fall"),
        ("", "Deformation \"bend\"", "deformation `bend` is passed over"),
        ("", "Attribute \"displacementbound\" \"sphere\" [-1]", "the displacement bound is -1, expected 0 or more"),
        (
            "",
            "Attribute \"displacementbound\" \"sphere\" [1] \"coordinatesystem\" [\"lost\"]",
            "no coordinate system `lost`",
        ),
        ("", "Points \"P\" [0 0 0 1 0 0 0 1 0] \"width\" [1 2]", "`width` has 2 values for 3 points"),
        ("", "Points \"P\" [0 0 0] \"width\" [-1]", "a width is -1, expected 0 or more"),
        ("", "Cylinder 0 0 1 360", "no area"),
        ("", "Scale 1e30 1e30 1e30 Disk 0 1 360", "a primitive that reaches farther than 1e12 units is not drawn"),
        ("", "Sphere 1 -1 1 360 \"constant float f\" [1 2]", "`f` of class constant has 2 values: the first holds"),
        (
            "",
            "MotionBegin [0 1] Disk 0 1 360 \"constant color Cs\" [1 0 0] Disk 0 1 360 \"constant color Cs\" [0 1 0] MotionEnd",
            "they do not move",
        ),
        (
            "",
            "MotionBegin [0 1] Surface \"matte\" Surface \"metal\" MotionEnd",
            "`Surface` in a motion block: the first holds",
        ),
        ("", "MotionBegin [0 1] Sides 1 Sides 2 MotionEnd", "`Sides` in a motion block: it may not move"),
        ("", "MotionBegin [0 1] Color 1 0 0 MotionEnd", "a motion block of 2 times has 1 of `Color`"),
    ] {
        let answer = said(&[], options, world);
        assert!(answer.contains(message), "{options} {world}: {answer}");
    }
}

#[test]
fn colours_that_are_no_numbers_are_counted_and_said() {
    // Infinity less infinity, on a disk and, of a shader of another name, nowhere; what is finite is not warned of.
    let files = [
        ("lost.sl", "surface lost() { float big = 1e30; Oi = 1; Ci = big * big - big * big; }"),
        ("kept.sl", "surface kept() { float big = 1e30; Oi = 1; Ci = big; }"),
    ];
    let answer = said(&files, "", "Surface \"lost\" Disk 0 0.5 360 Disk 1 0.5 360 Surface \"kept\" Disk 0 0.2 360");
    let found: Vec<&str> = answer.lines().filter(|line| line.contains("no finite numbers")).collect();
    let [line] = found[..] else { panic!("{answer}") };
    let (_, rest) = line.split_once("the shader `lost` gives colours that are no finite numbers, at ").unwrap();
    let n: usize = rest.split(' ').next().unwrap().parse().unwrap();
    assert!(n > 500, "{line}");
}

#[test]
fn what_is_given_in_vain_is_said() {
    let square = "Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
    for (told, options, world) in [
        ("type `jpeg` is not known", "Display \"t.png\" \"jpeg\" \"rgb\"", String::new()),
        ("`t.jpg` is written as png", "Display \"t.jpg\" \"file\" \"rgb\"", String::new()),
        ("string `kind`", "", format!("{square} \"uniform string kind\" [\"a\"]")),
        ("string `kind`", "", "Sphere 1 -1 1 360 \"constant string kind\" [\"a\"]".into()),
        ("has no `AttributeEnd`", "", format!("AttributeBegin {square}")),
        ("has no `SolidEnd`", "", "SolidBegin \"union\" Sphere 1 -1 1 360".into()),
        ("has no `MotionEnd`", "", "MotionBegin [0 1] Translate 0 0 0".into()),
        ("in a motion block of", "", "MotionBegin [0 1] Translate 0 0 0 Scale 1 1 1 MotionEnd".into()),
        (
            "the light `pointlight` moves: it shines from where it is when the shutter opens",
            "",
            "MotionBegin [0 1] Translate 0 0 0 Translate 1 0 0 MotionEnd LightSource \"pointlight\" 1".into(),
        ),
        (
            "the variable `Ka` of a primitive has a value of 3 numbers, and the parameter of the shader `matte` one of 1",
            "",
            "Surface \"matte\" Disk 0 0.5 360 \"uniform color Ka\" [1 0 0]".into(),
        ),
        ("the screen window's width is 0, expected another number than 0", "ScreenWindow -1 -1 0 1", String::new()),
        (
            "the depths of `d.tif` are levels from 0 to 1",
            "Display \"d.tif\" \"tiff\" \"z\" Quantize \"z\" 255 0 255 0",
            String::new(),
        ),
        ("the depths of `d.png` are levels from 0 to 1", "Display \"d.png\" \"png\" \"z\"", String::new()),
    ] {
        let answer = said(&[], options, &world);
        assert!(answer.contains(told), "{options} {world} is silent: {answer}");
    }
    assert!(!said(&[], "", square).contains("warning"), "what is sound is not warned of");
}
