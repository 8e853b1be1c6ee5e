//! Nothing is silent: what cannot be drawn as it stands, and what grows without end, is said with its place.

use crate::cli::{Answer, scratch, scree};
use crate::rendering::{ORTHO, render_with};

/// What is said of a scene with shaders beside it.
fn said(files: &[(&str, &str)], text: &str) -> Answer {
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
