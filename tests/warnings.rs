//! What shows nothing, or not what was meant, is said with its place: images that were cut off, archives that nobody reads, numbers of
//! primitives.

use crate::cli::{scratch, scree};
use crate::rendering::ORTHO;
use crate::silence::said;

/// Numbers of which a primitive can be made that shows nothing, or not what was meant.
#[test]
fn primitives_that_show_nothing_or_too_much_are_said_with_their_place() {
    let square = "\"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]";
    let points: String = (0..16).map(|k| format!("{} {} 0 ", k % 4, k / 4)).collect();
    let faces: String =
        (0..9).map(|k| k / 3 * 4 + k % 3).map(|k| format!("{k} {} {} {} ", k + 1, k + 5, k + 4)).collect();
    let mesh = |tags: &str| {
        format!("SubdivisionMesh \"catmull-clark\" [{}] [{faces}] {tags} \"P\" [{points}]", "4 ".repeat(9))
    };
    let patch = format!("NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 {square}");
    let rational =
        |w: f32| format!("NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"Pw\" [-1 -1 0 {w} 1 -1 0 1 -1 1 0 1 1 1 0 1]");
    let trim = |n: &str, u: &str, v: &str| {
        let curves = n.split(' ').count();
        format!(
            "TrimCurve [{curves}] [{}] [{}] [{}] [{}] [{n}] [{u}] [{v}] [{}] {patch}",
            "2 ".repeat(curves),
            n.split(' ')
                .map(|n| (0..n.parse::<i32>().unwrap() + 2)
                    .map(|k| format!("{} ", (k - 1).clamp(0, n.parse::<i32>().unwrap() - 1)))
                    .collect::<String>())
                .collect::<String>(),
            "0 ".repeat(curves),
            n.split(' ').map(|n| format!("{} ", n.parse::<i32>().unwrap() - 1)).collect::<String>(),
            "1 ".repeat(u.split_whitespace().count())
        )
    };
    for (world, expected) in [
        ("Torus .5 .2 90 90 360".to_string(), "make no area"),
        ("Torus .5 0 0 360 360".into(), "make no area"),
        ("Sphere 0 0 0 360".into(), "make no area"),
        ("Sphere 1 -1 1 0".into(), "make no area"),
        ("Disk 0 1 0".into(), "make no area"),
        ("Torus .5 .2 0 90 360".into(), ""),
        (
            "SubdivisionMesh \"catmull-clark\" [4] [0 1 3 2] [] [] [] [] ".to_string() + square,
            "without the tag `interpolateboundary`",
        ),
        (
            "SubdivisionMesh \"catmull-clark\" [4] [0 1 3 2] [\"interpolateboundary\"] [0 0] [] [] ".to_string()
                + square,
            "",
        ),
        // One face in the middle touches no boundary.
        (mesh("[] [] [] []"), ""),
        (rational(0.0), "point 0 of \"Pw\" has the weight 0"),
        (rational(-1.0), "point 0 of \"Pw\" has the weight -1"),
        (rational(0.5), ""),
        (trim("5", ".2 .8 .8 .2 .2", ".2 .2 .8 .8 .2"), ""),
        (trim("3 3", ".2 .8 .8 .8 .2 .2", ".2 .2 .8 .8 .8 .2"), ""),
        (trim("4", ".2 .8 .8 .2", ".2 .2 .8 .8"), "loop 0 of `TrimCurve` is not closed"),
        (trim("3 2", ".2 .8 .8 .2 .2", ".2 .2 .8 .8 .2"), "loop 0 of `TrimCurve` is not closed"),
    ] {
        let answer = said(
            &[],
            &format!(
                "Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\nSurface \"constant\"\n {world}\nWorldEnd\n"
            ),
        );
        answer.ok();
        let errors = answer.errors();
        assert_eq!(errors.contains("warning"), !expected.is_empty(), "{world}: {errors}");
        assert!(
            errors.contains(expected) && (expected.is_empty() || errors.contains("t.rib:5:2: ")),
            "{world}: {errors}"
        );
    }
    for (crop, is_said) in [("2 3 0 1", true), ("-1 .5 0 1", true), ("0 1 .25 .5", false)] {
        let errors = said(
            &[],
            &format!("Display \"t.png\" \"png\" \"rgb\"\nFormat 8 8 1\n CropWindow {crop}\nWorldBegin\nWorldEnd\n"),
        )
        .errors();
        assert_eq!(errors.contains("t.rib:3:2: the crop window"), is_said, "{crop}: {errors}");
    }
}

/// A megabyte that is no name: it is said short, and at once.
#[test]
fn what_is_longer_than_any_name_is_said_in_a_line() {
    let long = "A".repeat(1_000_000);
    for (scene, fails) in
        [(format!("WorldBegin {long} WorldEnd"), false), (format!("WorldBegin Surface \"{long}\" WorldEnd"), true)]
    {
        let answer = said(&[], &format!("Display \"t.png\" \"png\" \"rgb\" Format 8 8 1\n{scene}"));
        let errors = if fails { answer.fails(3) } else { answer.errors() };
        assert!(errors.contains("AAAA…(99") && errors.len() < 2000, "{} bytes: {:.300}", errors.len(), errors);
    }
}

/// An archive that a file holds and nothing reads draws nothing: what is wrong in it is said all the same, and the image is made.
#[test]
fn what_is_wrong_in_an_archive_that_is_never_read_is_said_with_its_place() {
    for (inside, expected) in [
        ("Sphere 1 -1", "t.rib:3:1: expected radius, zmin, zmax and thetamax"),
        ("\n Sphere 1 -1 1 360 \"Cs\" [1 0]", "t.rib:4:"),
        ("Spher 1 -1 1 360", "t.rib:3:1: unknown request `Spher`"),
        ("AttributeBegin Sphere 1 -1 1 360", "t.rib:3:1: this `AttributeBegin`"),
        ("ReadArchive", "t.rib:3:1: expected a string"),
        ("ArchiveBegin \"b\" Sphere ArchiveEnd Disk 0 1 360", "t.rib:3:18: expected radius"),
        ("IfBegin \"1\" Disk 0 1 IfEnd", "t.rib:3:13: expected height"),
        (
            "Sphere 1 -1 1 360 ReadArchive \"not there.rib\" Procedural \"RunProgram\" [\"none\" \"\"] [-1 1 -1 1 -1 1]",
            "",
        ),
        ("ArchiveBegin \"b\" Sphere 1 -1 1 360 ArchiveEnd ReadArchive \"b\"", ""),
    ] {
        let scene = |name: &str| {
            format!(
                "Display \"t.png\" \"png\" \"rgb\" Format 8 8 1\nArchiveBegin \"a\"\n{inside}\nArchiveEnd ArchiveBegin \"c\" Disk 0 .5 360 ArchiveEnd
                WorldBegin ReadArchive \"{name}\"\nWorldEnd\n"
            )
        };
        let answer = said(&[], &scene("c"));
        answer.ok();
        let errors = answer.errors();
        let is_said = errors.contains("; the archive `a`, where that stands, is never read");
        assert!(is_said != expected.is_empty() && errors.contains(expected), "{inside}: {errors}");
        // One that replaces it hides nothing, and one that is read is checked as it is read.
        let errors = said(
            &[],
            &scene("c")
                .replace("ArchiveBegin \"c\"", "ArchiveBegin \"a\"")
                .replace("ReadArchive \"c\"", "ReadArchive \"a\""),
        )
        .errors();
        assert_eq!(errors.contains("is never read"), !expected.is_empty(), "{inside}: {errors}");
    }
    let read = said(&[], "WorldBegin ArchiveBegin \"a\" Spher 1 ArchiveEnd ReadArchive \"a\" WorldEnd");
    assert!(!read.errors().contains("never read"), "{}", read.errors());
}

/// An image whose file was cut off after a sound header, as a copy that did not end leaves it.
#[test]
fn a_truncated_image_is_said_where_a_texture_is_made_of_it_or_asked_about() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let noise = |x: u32, y: u32| (x * 7919 + y * 104_729).wrapping_mul(0x9e37_79b9).to_be_bytes()[0];
    let bytes = image::RgbImage::from_fn(40, 30, |x, y| image::Rgb([noise(x, y), noise(y, x), noise(x + 50, y)]));
    let floats = image::Rgb32FImage::from_fn(40, 30, |x, y| image::Rgb(bytes.get_pixel(x, y).0.map(f32::from)));
    bytes.save(at("i.png")).unwrap();
    bytes.save(at("i.tif")).unwrap();
    floats.save(at("i.exr")).unwrap();
    let asks = "surface asks(string map = \"\";) { float x = 0.5; float y = textureinfo(map, \"exists\", x); Oi = 1; Ci = color(x, y, 0); }";
    for file in ["i.png", "i.tif", "i.exr"] {
        let whole = std::fs::read(at(file)).unwrap();
        for (keep, is_whole) in [(whole.len(), true), (whole.len() - 20, false), (whole.len() * 2 / 3, false)] {
            let [exists, shown] =
                [format!("Surface \"asks\" \"string map\" \"{file}\""), "Surface \"constant\"".into()];
            let made = format!("MakeTexture \"{file}\" \"a\" \"black\" \"black\" \"box\" 1 1\n");
            for (request, surface, place) in [
                (made.clone(), &shown, "t.rib:3:1: texture `a`"),
                ("\n".into(), &exists, "asks.sl:1:59: the shader `asks`: texture `i."),
            ] {
                let head = "Display \"t.exr\" \"exr\" \"rgb\"\nFormat 8 8 1 Translate 0 0 1\n";
                let scene = format!("{head}{request}WorldBegin {surface} Disk 0 9 360\nWorldEnd\n");
                std::fs::write(at("asks.sl"), asks).unwrap();
                std::fs::write(at("t.rib"), scene).unwrap();
                std::fs::write(at(file), &whole[..keep]).unwrap();
                let answer = scree(&["render", &at("t.rib"), "-o", &at("")]);
                answer.ok();
                let errors = answer.errors();
                let is_said = errors.contains(place) && errors.contains("cannot be read and is black");
                assert_eq!(is_said, !is_whole, "{keep} bytes of {file}: {request}{surface}: {errors}");
                if surface == &exists {
                    let pixel = image::open(at("t.exr")).unwrap().to_rgb32f().get_pixel(4, 4).0;
                    assert_eq!(pixel[..2], if is_whole { [1.0, 1.0] } else { [0.5, 0.0] });
                }
            }
            let made = format!("MakeTexture \"{file}\" \"a\" \"black\" \"black\" \"box\" 1 1\nWorldBegin\nWorldEnd\n");
            std::fs::write(at("t.rib"), made).unwrap();
            std::fs::write(at(file), &whole[..keep]).unwrap();
            let answer = scree(&["check", &at("t.rib")]);
            let text = answer.errors() + &answer.ok();
            let is_said = text.contains("t.rib:1:1: texture `a` cannot be read");
            assert_eq!(is_said, !is_whole, "{keep} bytes of {file}: {text}");
            std::fs::write(at(file), &whole).unwrap();
        }
    }
}

/// RISpec 6.3: the calls of a motion block differ in their numbers alone. A polygon of other vertices is another one.
#[test]
fn polygons_of_a_motion_block_have_as_many_vertices() {
    let three = "-1 -1 0 1 -1 0 1 1 0";
    let four = "-1 -1 0 1 -1 0 1 1 0 -1 1 0";
    let mesh = |n: usize, points: &str| {
        let corners: String = (0..n).map(|k| format!("{k} ")).collect();
        format!("PointsPolygons [{n}] [{corners}] \"P\" [{points}]")
    };
    let polygon = |points: &str| format!("Polygon \"P\" [{points}]");
    for (from, to, is_said) in [
        (polygon(three), polygon(four), true),
        (polygon(four), polygon(three), true),
        (polygon(four), polygon(four), false),
        (mesh(3, four), mesh(4, four), true),
        (mesh(4, four), mesh(4, four), false),
    ] {
        let world = format!("Surface \"constant\"\n MotionBegin [0 1] {from} {to} MotionEnd");
        let errors = said(
            &[],
            &format!("Display \"t.png\" \"png\" \"rgb\"\nShutter 0 1 {ORTHO}\nWorldBegin\n{world}\nWorldEnd\n"),
        )
        .errors();
        assert_eq!(errors.contains("are cut differently: the first alone is drawn"), is_said, "{world}: {errors}");
    }
}

/// A shader of one's own that does not compile is one's own fault, also where nobody names it.
#[test]
fn a_default_surface_that_does_not_compile_is_a_fault_of_the_file() {
    let broken = [("defaultsurface.sl", "surface defaultsurface() { Ci = nothing; }")];
    let errors = said(&broken, "WorldBegin Sphere 1 -1 1 360 WorldEnd").fails(3);
    assert!(errors.contains("defaultsurface.sl:1:33: unknown variable `nothing`"), "{errors}");
}

/// A `Perspective` before `Projection` would be part of the transformation of the screen, which is not followed there. Without one it is the projection.
#[test]
fn a_perspective_before_the_projection_is_said() {
    let scene = |camera: &str| {
        let rest = "Translate 0 0 5 WorldBegin Sphere 1 -1 1 360 WorldEnd";
        said(&[], &format!("Display \"t.png\" \"file\" \"rgba\"\n{camera}\n{rest}\n")).errors()
    };
    for projection in ["orthographic", "perspective"] {
        let both = scene(&format!("Perspective 90\nProjection \"{projection}\""));
        assert!(both.contains("t.rib:3:1: the `Perspective` before `Projection` is passed over"), "{both}");
    }
    for alone in
        ["Perspective 90", "Projection \"perspective\"", "Projection \"perspective\" Projection \"perspective\""]
    {
        assert!(!scene(alone).contains("passed over"), "{alone}");
    }
}
