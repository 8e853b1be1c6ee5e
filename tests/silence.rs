//! Nothing is silent: what cannot be drawn as it stands, and what grows without end, is said with its place.

use crate::cli::{Answer, scratch, scree};
use crate::rendering::{ORTHO, render_with};

/// What is said of a scene with shaders beside it.
pub fn said(files: &[(&str, &str)], text: &str) -> Answer {
    let work = scratch();
    for (name, text) in files {
        std::fs::write(work.path().join(name), text).unwrap();
    }
    let path = work.path().join("t.rib");
    std::fs::write(&path, text).unwrap();
    scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()])
}

#[test]
fn what_cannot_be_drawn_as_it_stands_is_said_with_its_place() {
    let head = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n");
    let solid = |parts: &str| format!("SolidBegin \"difference\"\n{parts}Sphere .5 -.5 .5 360\nSolidEnd\n");
    let tube = "SolidBegin \"primitive\" Cylinder .7 -.7 .7 360 SolidEnd\n";
    let closed = format!("{}Disk .7 .7 360 Disk -.7 .7 360 SolidEnd\n", &tube[..tube.len() - "SolidEnd\n".len()]);
    let open = "t.rib:5:24: a primitive of a solid does not enclose a volume";
    for (world, expected) in [
        (
            "Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0] Disk 0 .8 360\n",
            "t.rib:4:1: the matrix of `Transform` cannot be inverted",
        ),
        (
            "Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0] Disk 0 .8 360\n",
            "t.rib:4:45: a primitive under a transformation that cannot",
        ),
        ("Skew 90 0 1 0 1 0 0 Disk 0 .8 360\n", "t.rib:4:1: the angle of a skew is 90, expected less than 90 degrees"),
        ("Skew 91 0 1 0 1 0 0 Disk 0 .8 360\n", "t.rib:4:1: the angle of a skew is 91, expected less than 90 degrees"),
        ("Skew -180 0 1 0 1 0 0 Disk 0 .8 360\n", "t.rib:4:1: the angle of a skew is -180, expected less than 90"),
        ("Opacity [-1 0 0]\nDisk 0 .8 360\n", "t.rib:4:1: `Opacity` is [-1 0 0], expected 0 to 1"),
        ("Opacity [2 1 1]\nDisk 0 .8 360\n", "t.rib:4:1: `Opacity` is [2 1 1], expected 0 to 1"),
        (
            "Surface \"constant\"\nDisk 0 .8 360 \"uniform color Os\" [1 2 1]\n",
            "shaders/surface/constant.sl: the shader `constant` gives opacities below 0 or above 1, at ",
        ),
        ("Polygon \"P\" [0 0 0 .5 0 0 1 0 0]\n", "t.rib:4:1: a polygon whose vertices lie in a row has no area"),
        ("Polygon \"P\" [0 0 0 .5 0 0 1 0 0 .2 0 0 .1 0 0]\n", "t.rib:4:1: a polygon whose vertices lie in a row"),
        (solid(tube).as_str(), open),
    ] {
        let answer = said(&[], &format!("{head}{world}WorldEnd\n"));
        assert!(answer.errors().contains(expected), "{world}: {}", answer.errors());
    }
    // Cones, tubes and bowls without their ends, however they are turned; one with a wedge cut out.
    for angle in [0, 37, 90, 200] {
        for part in ["Cone 1 .7 360", "Cylinder .7 -.7 .7 360", "Sphere .8 -.8 0 360", "Sphere .8 -.8 .8 350"] {
            let part = format!("SolidBegin \"primitive\" Rotate {angle} 1 .3 0 {part} SolidEnd\n");
            let answer = said(&[], &format!("{head}{}WorldEnd\n", solid(&part)));
            assert!(answer.errors().contains("does not enclose a volume"), "{part}: {}", answer.errors());
        }
    }
    let cube = "SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4] [0 1 3 2 2 3 5 4 4 5 7 6 6 7 1 0 1 7 5 3 6 0 2 4]
        [\"crease\" \"interpolateboundary\"] [5 1 0 0] [0 1 3 2 0] [5] \"P\" [-1 -1 1 1 -1 1 -1 1 1 1 1 1 -1 1 -1 1 1 -1 -1 -1 -1 1 -1 -1]";
    let creased = format!("SolidBegin \"primitive\" Rotate 30 1 1 0 {cube} SolidEnd\n");
    let small = |size: f32, part: &str| {
        format!("SolidBegin \"primitive\" Rotate 30 1 1 0 Scale {size} {size} {size} {part} SolidEnd\n")
    };
    let tube = "Cylinder 1 -1 1 360 Disk -1 1 360 Disk 1 1 360";
    let pencil = "Cone 2 1 360 Disk 0 1 360";
    for whole in
        ["", &closed, &creased, &small(0.001, tube), &small(0.005, tube), &small(0.005, pencil), &small(0.5, pencil)]
    {
        let answer = said(&[], &format!("{head}{}WorldEnd\n", solid(&format!("Sphere .8 -.8 .8 360\n{whole}"))));
        assert!(!answer.errors().contains("enclose"), "{whole}: {}", answer.errors());
    }
    let lost = "surface t() { Oi = 1; Ci = pow(10, 30) * pow(10, 30) * u; }";
    let answer = said(&[("t.sl", lost)], &format!("{head}Surface \"t\"\n Disk 0 .8 360\nWorldEnd\n"));
    let errors = answer.errors();
    assert!(
        errors.contains("t.rib:5:2: ") && errors.contains("t.sl: the shader `t` gives colours that are no"),
        "{errors}"
    );
    let doubled = "surface t() {\n string s = \"ab\"; float i;\n for (i = 0; i < 60; i += 1) s = concat(s, s);\n Ci = Cs; if (s == \"x\") Ci = 0; }";
    let answer = said(&[("t.sl", doubled)], &format!("{head}Surface \"t\" Disk 0 .8 360\nWorldEnd\n"));
    let errors = answer.fails(3);
    assert!(
        errors.contains("a string of the shader `t` grows beyond 64 KiB, in ") && errors.contains("t.sl:3"),
        "{errors}"
    );
    // The place is that of the call that is too long, in a function, too.
    let doubled = "string d(string s) {\n return concat(s, s); }\nsurface t() { string s = \"abcdefgh\";\n s = d(d(d(d(d(d(d(s)))))));\n s = d(d(d(d(d(d(d(s))))))); Ci = Cs; if (s == \"x\") Ci = 0; }";
    let answer = said(&[("t.sl", doubled)], &format!("{head}Surface \"t\" Disk 0 .8 360\nWorldEnd\n"));
    let errors = answer.fails(3);
    assert!(
        errors.contains("a string of the shader `t` grows beyond 64 KiB, in ") && errors.contains("t.sl:2:"),
        "{errors}"
    );
}

/// A solid without any primitive, and one whose surfaces do not enclose it.
#[test]
fn solids_that_enclose_nothing_are_said_with_their_place() {
    let head = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n");
    let sphere = "Sphere .5 -.5 .5 360";
    let said_of = |world: &str| said(&[], &format!("{head}{world}\nWorldEnd\n")).errors().to_string();
    let empty = |operation: &str| format!("`SolidBegin \"{operation}\"` has no primitive in it: it encloses nothing");
    for operation in ["primitive", "union", "intersection", "difference"] {
        let answer = said_of(&format!("{sphere} SolidBegin \"{operation}\" Color 1 0 0 SolidEnd"));
        assert!(answer.contains(&format!("t.rib:4:22: {}", empty(operation))), "{operation}: {answer}");
    }
    let object = "ObjectBegin 1 ObjectEnd ObjectBegin 2 SolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd ObjectEnd";
    let disks = "Disk -1 .5 360 Disk 1 .5 360";
    let open = "does not enclose a volume: its surfaces are drawn as they are";
    for (world, place, expected) in [
        (
            format!("SolidBegin \"difference\" {sphere}\nSolidBegin \"primitive\" SolidEnd SolidEnd"),
            "5:1",
            empty("primitive"),
        ),
        (
            format!("SolidBegin \"intersection\" {sphere}\nSolidBegin \"union\" SolidEnd SolidEnd"),
            "5:1",
            empty("union"),
        ),
        (
            "SolidBegin \"union\"\nAttributeBegin SolidBegin \"primitive\" SolidEnd AttributeEnd SolidEnd".into(),
            "5:16",
            empty("primitive"),
        ),
        (
            "SolidBegin \"union\"\nAttributeBegin SolidBegin \"primitive\" SolidEnd AttributeEnd SolidEnd".into(),
            "4:1",
            empty("union"),
        ),
        (format!("{object} SolidBegin \"primitive\" ObjectInstance 1 SolidEnd"), "4:99", empty("primitive")),
        ("ObjectBegin 1 SolidBegin \"union\" SolidEnd ObjectEnd".into(), "4:15", empty("union")),
        ("SolidBegin \"primitive\" PointsPolygons [] [] \"P\" [] SolidEnd".into(), "4:1", empty("primitive")),
        ("SolidBegin \"primitive\" Cylinder .5 -1 1 360 SolidEnd".into(), "4:1", open.into()),
        ("SolidBegin \"primitive\" Cylinder .5 -1 1 360 Disk 1 .5 360 SolidEnd".into(), "4:1", open.into()),
        (format!("SolidBegin \"primitive\" {disks} SolidEnd"), "4:1", open.into()),
    ] {
        let answer = said_of(&world);
        let line = answer.lines().find(|line| line.contains(&expected) && line.contains(&format!("t.rib:{place}: ")));
        assert!(line.is_some(), "{world}: {answer}");
    }
    let tube = format!("Cylinder .5 -1 1 360 {disks}");
    for whole in [
        format!("SolidBegin \"primitive\" {sphere} SolidEnd"),
        format!("SolidBegin \"primitive\" {tube} SolidEnd"),
        format!("Cylinder .5 -1 1 360 SolidBegin \"primitive\" {tube} SolidEnd"),
        format!("SolidBegin \"primitive\" Rotate 30 1 2 3 {tube} SolidEnd SolidBegin \"primitive\" {sphere} SolidEnd"),
        format!("{object} SolidBegin \"primitive\" ObjectInstance 2 SolidEnd ObjectInstance 2"),
        format!(
            "SolidBegin \"difference\" {sphere} SolidEnd SolidBegin \"union\" SolidBegin \"primitive\" {tube} SolidEnd SolidEnd"
        ),
        format!("SolidBegin \"primitive\" MotionBegin [0 1] {sphere} {sphere} MotionEnd SolidEnd"),
        "SolidBegin \"primitive\" Torus .5 .2 0 360 360 SolidEnd".into(),
    ] {
        let answer = said_of(&whole);
        assert!(!answer.contains("enclose"), "{whole}: {answer}");
    }
}

/// Of what a shader asks in vain, the place of the primitive and that in the shader are said.
#[test]
fn what_a_shader_asks_in_vain_is_said_with_both_places() {
    let head =
        format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\nSurface \"t\"\n Disk 0 .8 360\nWorldEnd\n");
    for (body, expected) in [
        ("Ci = texture(\"no.png\");", "texture `no.png` cannot be read and is black"),
        ("Ci = texture(\"no.png\", s, t);", "texture `no.png` cannot be read and is black"),
        ("Ci = environment(\"no.png\", N);", "texture `no.png` cannot be read and is black"),
        ("Ci = color(transform(\"nosuch\", P));", "names the unknown space `nosuch`; world space is taken"),
        ("Ci = ctransform(concat(\"no\", \"such\"), Cs);", "unknown colour space `nosuch`"),
        ("float x[2]; Ci = textureinfo(\"no.png\", \"resolution\", x);", "texture `no.png` cannot be read"),
        ("float n; Ci = textureinfo(\"no.png\", \"channels\", n);", "texture `no.png` cannot be read"),
        ("string kind; Ci = textureinfo(\"no.png\", \"type\", kind);", "texture `no.png` cannot be read"),
        ("Ci = shadow(\"no.png\", P);", "shadow() is answered in light shaders alone"),
        ("Ci = texture(\"\", s, t, \"foo\", 1);", "has the unknown option `foo`"),
        // The surface's s and t are looked up at, whatever variables have their names.
        ("uniform string t = \"no.png\"; Ci = texture(t[1]);", "texture `no.png` cannot be read and is black"),
        ("uniform string t = \"no.png\"; if (u > 2) t = \"\"; Ci = texture(t[0]);", "texture `no.png` cannot be read"),
        // An index of an array is that of its element.
        ("string a[2] = {\"\", \"no.png\"}; Ci = texture(a[1], s, t);", "texture `no.png` cannot be read and is black"),
        (
            "string a[2] = {\"no.png\", \"\"}; Ci = texture(a[0][1], s, t);",
            "texture `no.png` cannot be read and is black",
        ),
    ] {
        let shader = format!("surface t() {{ Oi = 1;\n {body} }}");
        let answer = said(&[("t.sl", shader.as_str())], &head);
        let errors = answer.errors();
        let placed = ["t.rib:5:2: ", "t.sl:2:", ": the shader `t`: "].iter().all(|place| errors.contains(place));
        assert!(placed && errors.contains(expected), "{body}: {errors}");
    }
    for (body, expected) in [
        ("string a[2] = {\"\", \"no.png\"}; Ci = texture(a, s, t);", "expected string, found an array"),
        ("float a[2] = {0, 1}; Ci = texture(\"no.png\", a, t);", "expected float, found an array"),
    ] {
        let shader = format!("surface t() {{ Oi = 1;\n {body} }}");
        let answer = said(&[("t.sl", shader.as_str())], &head);
        let errors = answer.errors();
        assert!(errors.contains("t.sl:2:") && errors.contains(expected), "{body}: {errors}");
    }
}

#[test]
fn numbers_that_are_not_those_expected_are_said_with_their_place() {
    let head = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n");
    let part = "surface t() { float a[3] = {1, 2}; Oi = 1; Ci = a[2]; }";
    for (world, expected) in [
        ("Disk 0 .5 720\n", "t.rib:4:1: a quadric's sweep is 720°"),
        ("Sphere .5 -.5 .5 -361\n", "t.rib:4:1: a quadric's sweep is -361°"),
        ("Attribute \"visibility\" \"camera\" [2]\nDisk 0 .5 360\n", "t.rib:4:1: visibility `camera` is 2"),
        ("version 9.9\nDisk 0 .5 360\n", "t.rib:4:1: version 9.9 of the RIB format"),
        ("LightSource \"pointlight\" 1\nIlluminate 1 5\nDisk 0 .5 360\n", "t.rib:5:1: a flag is 5, expected 0 or 1"),
        (
            "Surface \"paintedplastic\" \"string texturename\" [\"a\" \"b\"]\nDisk 0 .5 360\n",
            "t.rib:4:1: parameter `texturename` has 2 strings, expected 1",
        ),
        (
            "Surface \"t\"\nDisk 0 .5 360\n",
            "t.rib:4:1: surface shader `t` gives 2 values for the 3 of `a`: the rest are 0",
        ),
    ] {
        let answer = said(&[("t.sl", part)], &format!("{head}{world}WorldEnd\n"));
        assert!(answer.errors().contains(expected), "{world}: {}", answer.errors());
    }
    let answer = said(&[], "Display \"t.png\" \"png\" \"rgb\"\nFormat 8 8 0\nWorldBegin\nWorldEnd\n");
    assert!(answer.errors().contains("t.rib:2:1: the pixel aspect ratio is 0"), "{}", answer.errors());
}

/// Infinite colours are said, and are in the image as the greatest numbers: none is made of them that is no number.
#[test]
fn infinite_colours_are_said_and_are_numbers() {
    let shader = b"surface t() { Oi = Os; Ci = v; if (u < 0.5) Ci = pow(10, 30) * pow(10, 30); }";
    for (filter, opacity) in [("\"box\" 1 1", 1.0), ("\"catmull-rom\" 4 4", 1.0), ("\"gaussian\" 2 2", 0.5)] {
        let options = format!("{ORTHO} PixelFilter {filter}");
        let square = "Polygon \"P\" [-.8 -.8 0 .8 -.8 0 .8 .8 0 -.8 .8 0]";
        let world = format!("Surface \"t\" Opacity {opacity} {opacity} {opacity} {square}");
        let image = render_with(&[("t.sl", shader)], &options, &world);
        assert!(image.pixels.iter().flatten().all(|x| x.is_finite()), "{filter}");
        assert!(image.pixels.iter().any(|p| p[0] > 1e20), "{filter}");
    }
}

/// Textures of images that there are not, used or not; whether there is one may be asked.
#[test]
fn images_that_textures_are_made_of_are_looked_for() {
    let square = image::RgbaImage::from_pixel(2, 2, image::Rgba([255; 4]));
    let head = "Display \"t.png\" \"png\" \"rgb\"\nFormat 8 8 1\n";
    let made = |request: &str| {
        let work = scratch();
        std::fs::create_dir(work.path().join("maps")).unwrap();
        square.save(work.path().join("there.png")).unwrap();
        square.save(work.path().join("maps/other.png")).unwrap();
        std::fs::write(work.path().join("bad.png"), "no image").unwrap();
        let path = work.path().join("t.rib");
        let world = "WorldBegin\nDisk 0 .8 360\nWorldEnd\n";
        std::fs::write(&path, format!("{head}{request}\n{world}Display \"u.png\" \"png\" \"rgb\"\n{world}")).unwrap();
        let answer = scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]);
        answer.ok();
        answer.errors()
    };
    let faces = |last: &str| {
        let five = "\"there.png\" ".repeat(5);
        format!("MakeCubeFaceEnvironment {five}\"{last}\" \"cube\" 90 \"box\" 1 1")
    };
    for (request, name, image) in [
        ("MakeTexture \"no.png\" \"a\" \"black\" \"black\" \"box\" 1 1".to_string(), "a", "no.png"),
        ("MakeLatLongEnvironment \"no.png\" \"b\" \"box\" 1 1".into(), "b", "no.png"),
        (faces("gone.png"), "cube", "gone.png"),
    ] {
        let errors = made(&request);
        let said = format!("t.rib:3:1: the texture `{name}` is black: there is no image `{image}` to make it of");
        assert_eq!(errors.matches(&said).count(), 1, "{request}: {errors}");
    }
    let there = "MakeTexture \"there.png\" \"a\" \"black\" \"black\" \"box\" 1 1";
    let other = "MakeLatLongEnvironment \"other.png\" \"b\" \"box\" 1 1\nOption \"searchpath\" \"texture\" \"maps\"";
    for (request, name) in
        [("MakeTexture \"bad.png\" \"a\" \"black\" \"black\" \"box\" 1 1".to_string(), "a"), (faces("bad.png"), "cube")]
    {
        let errors = made(&request);
        let said = format!("t.rib:3:1: texture `{name}` cannot be read and is black: `");
        assert_eq!(errors.matches(&said).count(), 1, "{request}: {errors}");
    }
    for request in [there, &faces("there.png"), other] {
        let errors = made(request);
        assert!(!errors.contains("warning"), "{request}: {errors}");
    }
    let asks = "surface t() { float x = 2; textureinfo(\"no.png\", \"exists\", x); Oi = 1; Ci = x; }";
    let answer = said(&[("t.sl", asks)], &format!("{head}WorldBegin Surface \"t\" Disk 0 .8 360\nWorldEnd\n"));
    assert!(!answer.errors().contains("warning"), "{}", answer.errors());
}

#[test]
fn uniform_variables_have_a_value_for_each_face() {
    let mesh = "[4 4] [0 1 4 3 1 2 5 4]";
    let points = "\"P\" [-1 -1 0 0 -1 0 1 -1 0 -1 1 0 0 1 0 1 1 0]";
    let curves = "Curves \"linear\" [2 2] \"nonperiodic\" \"P\" [-1 1 0 1 1 0 -1 -1 0 1 -1 0] \"constantwidth\" [0.4]";
    let shapes = [
        format!("PointsPolygons {mesh} {points}"),
        format!("SubdivisionMesh \"catmull-clark\" {mesh} [\"interpolateboundary\"] [0 0] [] [] {points}"),
        format!("PatchMesh \"bilinear\" 3 \"nonperiodic\" 2 \"nonperiodic\" {points}"),
        curves.to_string(),
    ];
    for shape in shapes {
        let answer = |values: &str| {
            let work = scratch();
            let path = work.path().join("t.rib");
            let head = "Display \"t.exr\" \"exr\" \"rgba\"\nFormat 8 8 1\nWorldBegin Surface \"constant\"\n";
            std::fs::write(&path, format!("{head}{shape} \"uniform color Cs\" [{values}]\nWorldEnd\n")).unwrap();
            scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()])
        };
        answer("1 0 0 0 1 0").ok();
        let errors = answer("1 0 0").fails(3);
        assert!(errors.contains("`Cs` has too few values: 1 of class uniform"), "{shape}: {errors}");
        assert!(errors.contains("t.rib:4:"), "{shape}: {errors}");
    }
}

/// Numbers that nothing takes: a list that is longer than its primitive is one of another primitive, or a class that was mistaken.
#[test]
fn values_beyond_those_of_a_primitive_are_said_with_their_place() {
    let mesh = "[4 4] [0 1 4 3 1 2 5 4]";
    let six = "\"P\" [-1 -1 0 0 -1 0 1 -1 0 -1 1 0 0 1 0 1 1 0]";
    let four = "\"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]";
    let square = "\"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
    let weighted = "\"Pw\" [-1 -1 0 1 1 -1 0 1 -2 2 0 2 1 1 0 1]";
    let curves = "Curves \"linear\" [2 2] \"nonperiodic\" \"P\" [-1 1 0 1 1 0 -1 -1 0 1 -1 0] \"constantwidth\" [0.4]";
    let points_mesh = format!("PointsPolygons {mesh} {six}");
    let subdivided = format!("SubdivisionMesh \"catmull-clark\" {mesh} [\"interpolateboundary\"] [0 0] [] [] {six}");
    let patches = format!("PatchMesh \"bilinear\" 3 \"nonperiodic\" 2 \"nonperiodic\" {six}");
    let rational = format!("PatchMesh \"bilinear\" 2 \"nonperiodic\" 2 \"nonperiodic\" {weighted}");
    let nurbs = "NuPatch 3 2 [0 0 1 2 2] 0 2 2 2 [0 0 1 1] 0 1 \"P\" [-1 -1 0 0 -1 0 1 -1 0 -1 1 0 0 1 0 1 1 0]";
    let blobby = "Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [\"\"]";
    // Of each primitive, the values that it takes of each class.
    for (shape, classes) in [
        (format!("Polygon {square}"), &[("uniform", 1), ("varying", 4), ("vertex", 4), ("facevarying", 4)][..]),
        (format!("GeneralPolygon [4] {square}"), &[("uniform", 1), ("vertex", 4), ("facevarying", 4)]),
        (points_mesh.clone(), &[("uniform", 2), ("varying", 6), ("vertex", 6), ("facevarying", 8)]),
        (
            format!("PointsGeneralPolygons [1 1] {mesh} {six}"),
            &[("uniform", 2), ("varying", 6), ("vertex", 6), ("facevarying", 8)],
        ),
        (subdivided.clone(), &[("uniform", 2), ("varying", 6), ("vertex", 6), ("facevarying", 8)]),
        (patches, &[("uniform", 2), ("varying", 6), ("vertex", 6), ("facevarying", 8)]),
        (rational, &[("uniform", 1), ("varying", 4), ("vertex", 4), ("facevarying", 4)]),
        (format!("Patch \"bilinear\" {four}"), &[("uniform", 1), ("varying", 4), ("vertex", 4), ("facevarying", 4)]),
        (curves.into(), &[("uniform", 2), ("varying", 4), ("vertex", 4)]),
        ("Sphere .5 -.5 .5 360".into(), &[("uniform", 1)]),
        ("Disk 0 .5 360".into(), &[("uniform", 1)]),
        (blobby.into(), &[("uniform", 1)]),
        ("Geometry \"teapot\"".into(), &[("uniform", 1)]),
    ] {
        for (class, n) in classes {
            let errors_of = |n: usize| {
                let values = "0.5 ".repeat(n);
                let world = format!("{shape} \"{class} float Kd\" [{values}]");
                let errors = said(&[], &head_and(&world)).errors().to_string();
                errors.lines().filter(|line| line.contains("Kd")).collect::<Vec<_>>().join("\n")
            };
            assert_eq!(errors_of(*n), "", "{shape} {class}");
            let expected = format!(
                "t.rib:4:1: `Kd` of class {class} has {} values, expected {n}: those beyond are not used",
                n + 1
            );
            let errors = errors_of(n + 1);
            assert!(errors.contains(&expected), "{shape}: {errors}, expected {expected}");
        }
    }
    for (world, expected) in [
        (
            format!("{points_mesh} \"uniform normal Np\" [0 0 1 0 0 1 0 0 1]"),
            "`Np` of class uniform has 3 values, expected 2",
        ),
        (
            format!("{nurbs} \"uniform float Kd\" [1]"),
            "`Kd` of class uniform has one value, expected 2, one a span: it is that of all",
        ),
        (points_mesh.replace("5 4]", "5 4 2 1]"), "the vertex list has 10 numbers, and the faces have 8 vertices"),
        (subdivided.replace("5 4]", "5 4 2 1]"), "the vertex list has 10 numbers, and the faces have 8 vertices"),
        (
            format!("GeneralPolygon [3] {square}"),
            "the loops have 3 vertices, and \"P\" has 4: those beyond are not used",
        ),
        (curves.replace("[2 2]", "[3]"), "\"P\" has 4 points, and the curves 3 vertices: those beyond are not used"),
        (
            "Geometry \"teapot\" \"varying float Kd\" [1 2 3 4]".into(),
            "`Kd` of class varying has no effect on a teapot",
        ),
    ] {
        let errors = said(&[], &head_and(&world)).errors().to_string();
        assert!(errors.contains(&format!("t.rib:4:1: {expected}")), "{world}: {errors}");
    }
}

/// A scene whose world begins in its fourth line.
fn head_and(world: &str) -> String {
    format!(
        "Display \"t.png\" \"png\" \"rgb\" Surface \"matte\"\nFormat 8 8 1 Translate 0 0 5\nWorldBegin\n{world}\nWorldEnd\n"
    )
}

/// A comment that is meant for scree, and that nobody knows: in a scene that is rendered by itself and in an archive within it.
#[test]
fn directives_that_nobody_knows_are_errors() {
    let head = "Display \"t.png\" \"png\" \"rgb\"\nFormat 8 8 1\n";
    let world = "WorldBegin\nSphere 1 -1 1 360\nWorldEnd\n";
    let archive = |directive: &str| {
        format!("{head}ArchiveBegin \"a\"\n{directive}\nArchiveEnd\nWorldBegin\nReadArchive \"a\"\nWorldEnd\n")
    };
    for (text, place) in [
        (format!("{head}#scree nonsense\n{world}"), "t.rib:3:1"),
        (archive("#scree nonsense"), "t.rib:4:1"),
        (format!("{head}#scree inject nonsense\n{world}"), "t.rib:3:1"),
        (format!("{head}#scree override nonsense\n{world}"), "t.rib:3:1"),
        (format!("{head}#scree ground nonsense\n{world}"), "t.rib:3:1"),
    ] {
        let work = scratch();
        let path = work.path().join("t.rib");
        std::fs::write(&path, &text).unwrap();
        for command in ["render", "check"] {
            let errors = scree(&[command, path.to_str().unwrap()]).fails(3);
            assert!(errors.contains(place) && errors.contains("nonsense` is unknown, expected"), "{text}: {errors}");
        }
    }
    let known = format!("{head}#scree override Format\n#scree ground\n#scree inject objects\n{world}");
    let answer = said(&[], &known);
    let errors = answer.errors().to_string();
    assert!(errors.contains("t.rib:5:1: `#scree inject objects` has no effect"), "{errors}");
    answer.ok();
}
