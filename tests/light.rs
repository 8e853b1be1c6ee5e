//! Lights that have a size, and what lets some of their light through, against answers known on paper.

use crate::rendering::{ORTHO, Rendered, render_with};

fn render(options: &str, world: &str) -> Rendered {
    render_with(&[], &ORTHO.replace("8 8", options), world)
}

/// The mean of a channel over a rectangle of pixels.
fn mean(p: &Rendered, x: std::ops::Range<usize>, y: std::ops::Range<usize>, channel: usize) -> f32 {
    let n = (x.len() * y.len()) as f32;
    y.flat_map(|y| x.clone().map(move |x| (x, y))).map(|(x, y)| p.at(x, y)[channel]).sum::<f32>() / n
}

const WALL: &str = "Polygon \"P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]";

#[test]
fn a_disc_lights_what_is_below_it_by_its_form_factor() {
    // At height h over the middle of a disc of radius R that shines 1 all over, a white surface shines R² / (R² + h²).
    for (radius, height) in [(0.5f32, 1.0f32), (2.0, 1.0), (0.5, 0.25)] {
        let p = render(
            "2 2",
            &format!(
                "AttributeBegin Attribute \"visibility\" \"int camera\" 0 Attribute \"light\" \"int nsamples\" 64
                TransformBegin Translate 0 0 -{height} AreaLightSource \"arealight\" \"lamp\" Disk 0 {radius} 360 TransformEnd AttributeEnd
                Illuminate \"lamp\" 1 Surface \"matte\" \"Ka\" 0 \"Kd\" 1 {WALL}"
            ),
        );
        let expected = radius * radius / (radius * radius + height * height);
        let found = mean(&p, 38..42, 38..42, 0);
        assert!((found - expected).abs() < 0.02 * expected, "R {radius}, h {height}: {found}, expected {expected}");
    }
}

#[test]
fn within_walls_that_shine_a_white_ball_shines_as_they_do() {
    // The furnace: the walls of a box, or a great ball turned inside out, that shine 1.
    let walls = "Polygon \"P\" [-3 -3 -3  3 -3 -3  3 3 -3  -3 3 -3]";
    let turns = ["", "Rotate 90 1 0 0", "Rotate 180 1 0 0", "Rotate 270 1 0 0", "Rotate 90 0 1 0", "Rotate -90 0 1 0"];
    let boxed = turns.map(|turn| format!("TransformBegin {turn} {walls} TransformEnd")).join(" ");
    for geometry in ["ReverseOrientation Sphere 3 -3 3 360", &boxed, &format!("ReverseOrientation {boxed}")] {
        let p = render(
            "2 2",
            &format!(
                "AttributeBegin Attribute \"visibility\" \"int camera\" 0 Attribute \"light\" \"int nsamples\" 256
                AreaLightSource \"arealight\" \"lamp\" {geometry} AttributeEnd
                Illuminate \"lamp\" 1 Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Sphere 0.8 -0.8 0.8 360"
            ),
        );
        let found = mean(&p, 30..50, 30..50, 1);
        // Walls that shine outwards leave it dark.
        let turned = geometry.starts_with("ReverseOrientation Tr");
        let expected = if turned { 0.0 } else { 1.0 };
        assert!((found - expected).abs() < 0.02, "{geometry}: {found}, expected {expected}");
    }
}

#[test]
fn the_sun_has_a_penumbra_as_wide_as_its_disc() {
    // An edge one metre before the wall, its sun 10 degrees wide: the shadow's edge is 2 tan 5° m wide, half dark in the middle.
    let p = render(
        "2 2",
        &format!(
            "LightSource \"distantlight\" 1 \"to\" [0 0 1] \"uniform float angle\" 10 \"uniform float samples\" 64
            Surface \"matte\" \"Ka\" 0 \"Kd\" 1 {WALL}
            Attribute \"visibility\" \"int camera\" 0 Polygon \"P\" [-9 -9 -1  0 -9 -1  0 9 -1  -9 9 -1]"
        ),
    );
    let half = 5f32.to_radians().tan();
    for x in 20..60 {
        let at = ((x as f32 + 0.5) / 40.0 - 1.0) / half;
        // The part of a disc right of a line.
        let a = at.clamp(-1.0, 1.0);
        let expected = 0.5 + (a * (1.0 - a * a).sqrt() + a.asin()) / std::f32::consts::PI;
        let found = mean(&p, x..x + 1, 10..70, 0);
        assert!((found - expected).abs() < 0.02, "{at}: {found}, expected {expected}");
    }
}

#[test]
fn light_through_two_panes_is_the_product() {
    let pane = |z: f32, opacity: &str| {
        format!(
            "AttributeBegin Attribute \"visibility\" \"int camera\" 0 Opacity {opacity} Polygon \"P\" [-1 -1 {z}  0 -1 {z}  0 1 {z}  -1 1 {z}] AttributeEnd"
        )
    };
    let world = |between: &str| {
        format!("LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1 {WALL} {between}")
    };
    let p = render("2 2", &world(&format!("{}{}", pane(-1.0, "0.5 0.25 0"), pane(-2.0, "0.2 0.5 0.75"))));
    for (c, expected) in [0.5 * 0.8, 0.75 * 0.5, 1.0 * 0.25].into_iter().enumerate() {
        assert!((mean(&p, 5..35, 5..75, c) - expected).abs() < 1e-3);
        assert!((mean(&p, 45..75, 5..75, c) - 1.0).abs() < 1e-3);
    }
    // A ball is met twice; one that is said to be opaque to light lets none through.
    for (attribute, expected) in [
        ("", 0.49),
        ("Attribute \"visibility\" \"string transmission\" \"opaque\"", 0.0),
        ("Attribute \"visibility\" \"transmission\" [\"opaque\"]", 0.0),
        ("Attribute \"visibility\" \"transmission\" [0]", 1.0),
    ] {
        let ball = format!(
            "AttributeBegin Attribute \"visibility\" \"int camera\" 0 {attribute} Opacity .3 .3 .3 Translate 0 0 -2 Sphere 0.5 -0.5 0.5 360 AttributeEnd"
        );
        let p = render("2 2", &world(&ball));
        assert!((mean(&p, 36..44, 36..44, 0) - expected).abs() < 1e-3 && mean(&p, 0..8, 0..8, 0) == 1.0);
    }
}

#[test]
fn what_a_shader_cuts_out_lets_light_through() {
    let grating = b"surface grating() { Oi = mod(s * 5, 1) < 0.5 ? color 1 : color 0; Ci = Oi * Cs; }";
    let p = render_with(
        &[("grating.sl", grating)],
        &ORTHO.replace("8 8", "2 2"),
        &format!(
            "LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1 {WALL}
            Attribute \"visibility\" \"int camera\" 0 Surface \"grating\" Translate 0 0 -1 {WALL}"
        ),
    );
    for x in 0..80 {
        let s = (x as f32 + 0.5) / 8.0 % 1.0;
        let expected = if s < 0.5 { 0.0 } else { 1.0 };
        if (s - 0.5).abs() > 0.1 && s > 0.1 && s < 0.9 {
            assert!((p.at(x, 40)[0] - expected).abs() < 0.1, "{x}: {}", p.at(x, 40)[0]);
        }
    }
}

#[test]
fn a_sky_lights_what_faces_it() {
    // The upper half of the sky shines 1, the lower one not at all: a wall shines as the cosine to the zenith has it.
    let sky = {
        let mut image = image::Rgb32FImage::new(64, 32);
        image.enumerate_pixels_mut().for_each(|(_, y, p)| p.0 = [if y < 16 { 1.0 } else { 0.0 }; 3]);
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
        bytes.into_inner()
    };
    // Seen along z, which is the sky's zenith: walls that face the eye look down, and are turned from there.
    for (turn, expected) in [(0.0f32, 0.0f32), (60.0, 0.25)] {
        let p = render_with(
            &[("sky.exr", &sky)],
            &ORTHO.replace("8 8", "2 2"),
            &format!(
                "AttributeBegin Attribute \"visibility\" \"int camera\" 0 Attribute \"light\" \"int nsamples\" 256
                AreaLightSource \"envlight\" \"sky\" \"string envname\" \"sky.exr\" ReverseOrientation Sphere 1000 -1000 1000 360 AttributeEnd
                Illuminate \"sky\" 1 Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Rotate {turn} 1 0 0 {WALL}"
            ),
        );
        let found = mean(&p, 30..50, 35..45, 0);
        // Of a wall whose normal is at an angle a to the zenith, (1 + cos a) / 2.
        assert!((found - expected).abs() < 0.02, "{turn}: {found}, expected {expected}");
    }
}

/// A lamp that lies in the plane of a ceiling: the wall below is lit as by one that hangs a little lower, and nowhere dark.
#[test]
fn a_lamp_in_a_ceiling_lights_the_wall_beside_it() {
    // What shines 1 from y = 1 gives the wall z = 0 the mean of cos α cos β / π r² over it.
    let expected = |x: f32, y: f32| {
        const N: usize = 60;
        let part = |k: usize, from: f32, until: f32| from + (until - from) * (k as f32 + 0.5) / N as f32;
        let sum: f32 = (0..N * N)
            .map(|k| {
                let (dx, dy, dz) = (part(k % N, -0.4, 0.4) - x, 1.0 - y, part(k / N, -0.8, -0.2));
                let r2 = dx * dx + dy * dy + dz * dz;
                -dz * dy / (std::f32::consts::PI * r2 * r2)
            })
            .sum();
        sum * 0.8 * 0.6 / (N * N) as f32
    };
    for height in [1.0f32, 0.999] {
        let world = format!(
            "AttributeBegin Attribute \"visibility\" \"int camera\" 0 Attribute \"light\" \"int nsamples\" 64
            AreaLightSource \"arealight\" \"lamp\" Sides 1
            Polygon \"P\" [-.4 {height} -.8 .4 {height} -.8 .4 {height} -.2 -.4 {height} -.2] AttributeEnd
            Illuminate \"lamp\" 1 Surface \"matte\" \"Ka\" 0 \"Kd\" 1 {WALL}
            Polygon \"P\" [-2 1 -2 2 1 -2 2 1 0 -2 1 0]"
        );
        let p = render("2 2", &world);
        for (x, y) in (1..79).flat_map(|x| (1..79).map(move |y| (x, y))) {
            let place = |k: usize| (k as f32 + 0.5) / 40.0 - 1.0;
            let expected = expected(place(x), -place(y));
            let found = p.at(x, y)[0];
            let off = (found - expected).abs();
            assert!(off < 0.2 * expected + 2e-3, "y {height}, ({x}, {y}): {found}, expected {expected}");
        }
        for y in [2..10, 10..30, 30..78] {
            let rows = y.clone().flat_map(|y| (1..79).map(move |x| (x, y)));
            let place = |k: usize| (k as f32 + 0.5) / 40.0 - 1.0;
            let all: f32 = rows.map(|(x, y)| expected(place(x), -place(y))).sum::<f32>() / (78 * y.len()) as f32;
            let found = mean(&p, 1..79, y.clone(), 0);
            assert!((found - all).abs() < 0.02 * all, "y {height}, rows {y:?}: {found}, expected {all}");
        }
    }
}

#[test]
fn the_round_ends_of_a_tube_cast_no_shadows_on_it() {
    // Two spheres whose upper and lower halves end a tube: where they touch it, rounding has points of each within the other. Lit from the
    // eye's upper left, or by the sky alone, the tube is as bright beside them as in its middle.
    let sun = "LightSource \"distantlight\" 1 \"to\" [0.5 -0.2 1]";
    let sky = "LightSource \"skylight\" 1 \"color zenith\" [1 1 1] \"color horizon\" [1 1 1] \"color beneath\" [1 1 1] \"color sunshine\" [0 0 0]";
    for (light, name) in [(sun, "the sun"), (sky, "the sky")] {
        for (turn, shading_rate) in [(0, 1.0), (30, 49.0), (45, 9.0), (60, 16.0), (77, 4.0)] {
            let p = render(
                "4 4",
                &format!(
                    "{light} Surface \"matte\" ShadingRate {shading_rate} Translate 0.05 0.03 0 Rotate 90 1 0 0 Rotate {turn} 0 0 1 Cylinder 0.37 -0.4 0.4 360
                     Translate 0 0 0.4 Sphere 0.37 -0.37 0.37 360 Translate 0 0 -0.8 Sphere 0.37 -0.37 0.37 360"
                ),
            );
            for x in 30..54 {
                let middle = p.at(x, 38)[1];
                for y in (24..29).chain(49..54) {
                    let found = p.at(x, y)[1];
                    assert!(
                        (found - middle).abs() < 0.06 + 0.06 * middle,
                        "{name}, {turn} degrees, shading rate {shading_rate}: {found} at ({x}, {y}), {middle} in the middle"
                    );
                }
            }
        }
    }
}
