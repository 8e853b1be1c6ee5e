//! Light from the sky: how open points are to it, against answers known on paper, and that the sky and the sun agree.

use crate::rendering::{ORTHO, Rendered, render_with};

/// What `openness` answers: of an even sky, of one that brightens with the height, of what is below the horizon. The wall faces the eye,
/// and up is towards it unless said.
const OPEN: &str = "surface open(vector up = vector(0, 0, -1);) { Ci = color(openness(P, faceforward(normalize(N), I), up)); Oi = Os; }";

const WALL: &str = "Polygon \"P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]";

fn render(options: &str, world: &str) -> Rendered {
    let world = format!("Surface \"open\" {world}");
    render_with(&[("open.sl", OPEN.as_bytes())], &ORTHO.replace("8 8", options), &world)
}

/// The answer in the middle of the wall, where the camera does not see what else is there.
fn middle(others: &str) -> [f32; 3] {
    let hidden = format!("AttributeBegin Attribute \"visibility\" \"int camera\" 0 {others} AttributeEnd");
    let p = render("2 2", &format!("{hidden} {WALL}"));
    [0, 1, 2].map(|c| p.at(40, 40)[c])
}

fn assert_near(found: f32, expected: f32, tolerance: f32, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected} within {tolerance}");
}

#[test]
fn in_the_open_a_plane_gets_what_its_tilt_lets_it() {
    let [even, rising, beneath] = middle("");
    assert_near(even, 1.0, 1e-3, "an even sky");
    assert_near(rising, 2.0 / 3.0, 1e-3, "a sky that brightens with the height");
    assert_near(beneath, 0.0, 1e-3, "the ground");
    // Up is along the wall: half of the sky is behind it, and the ground fills half of what it sees.
    let p = render("2 2", &format!("Surface \"open\" \"vector up\" [0 1 0] {WALL}"));
    let side = p.at(40, 40);
    assert_near(side[0], 0.5, 1e-3, "an even sky beside a wall");
    assert_near(side[1], 2.0 / (3.0 * std::f32::consts::PI), 1e-3, "a rising sky beside a wall");
    assert_near(side[2], 0.5, 1e-3, "the ground beside a wall");
}

#[test]
fn a_sphere_hides_its_form_factor_of_the_sky() {
    // Over the middle of the wall a sphere of radius R at distance d hides (R / d)² of the light; from 3 R on it fades. Cones with soft
    // sides answer to within 0.1.
    for d in [1.05f32, 1.3, 1.6, 2.0, 2.6, 3.0] {
        let found = 1.0 - middle(&format!("Translate 0 0 -{} Sphere 0.4 -0.4 0.4 360", 0.4 * d))[0];
        assert_near(found, 1.0 / (d * d), 0.1, &format!("a sphere at {d} radii"));
    }
    // The same as an ellipsoid of three equal axes but for a hair, and far away nothing.
    let even = middle("Translate 0 0 -0.8 Sphere 0.4 -0.4 0.4 360")[0];
    let uneven = middle("Translate 0 0 -0.8 Scale 1 1 1.002 Sphere 0.4 -0.4 0.4 360")[0];
    assert_near(uneven, even, 5e-3, "a sphere that is hardly an ellipsoid");
    assert_eq!(middle("Translate 0 0 -4 Sphere 0.4 -0.4 0.4 360")[0], 1.0, "a small sphere far away");
}

#[test]
fn facets_hide_what_is_behind_them_and_nothing_else() {
    let ceiling = middle("Translate 0 0 -0.5 Polygon \"P\" [-90 -90 0  90 -90 0  90 90 0  -90 90 0]");
    assert_near(ceiling[0], 0.0, 0.06, "under a ceiling");
    let half = middle("Translate 0 0 -0.5 Polygon \"P\" [0 -90 0  90 -90 0  90 90 0  0 90 0]");
    assert_near(half[0], 0.5, 0.06, "under the edge of a ceiling");
    let corner = middle("Polygon \"P\" [-0.001 -90 0  -0.001 90 0  -0.001 90 -90  -0.001 -90 -90]");
    assert_near(corner[0], 0.5, 0.1, "at the foot of a high wall");
    let behind = middle("Translate 0 0 0.5 Polygon \"P\" [-90 -90 0  90 -90 0  90 90 0  -90 90 0]");
    assert_near(behind[0], 1.0, 1e-3, "over a floor");
    // What lets light through, or casts no shadow, closes nothing.
    let pane = "Translate 0 0 -0.5 Polygon \"P\" [-90 -90 0  90 -90 0  90 90 0  -90 90 0]";
    assert_eq!(middle(&format!("Opacity [0.5 0.5 0.5] {pane}"))[0], 1.0);
    assert_eq!(middle(&format!("Attribute \"visibility\" \"int transmission\" 0 {pane}"))[0], 1.0);
}

#[test]
fn a_trough_is_as_open_as_its_arc_lets_it_and_even() {
    // Within half a tube, open towards the eye: the chord of its opening stands at a right angle from any point on the arc (Thales), so that
    // of the sky a point at φ from the bottom gets sin 45° cos (φ / 2). Cones with soft sides answer to within 0.16.
    let trough = |radius: f32| format!("Rotate 90 1 0 0 Cylinder {radius} -9 9 180");
    for shading_rate in [0.25, 4.0] {
        let p = render("2 2", &format!("ShadingRate {shading_rate} Translate 0 0 0.1 {}", trough(0.99)));
        let across: Vec<f32> = (6..74).map(|x| p.at(x, 40)[0]).collect();
        for (k, found) in across.iter().enumerate() {
            let sine = ((k as f32 + 6.5) / 40.0 - 1.0) / 0.99;
            let expected = std::f32::consts::FRAC_1_SQRT_2 * (0.5 * sine.asin()).cos();
            assert_near(
                *found,
                expected,
                0.16,
                &format!("openness at {sine} of the radius, shading rate {shading_rate}"),
            );
        }
        let step = across.windows(2).map(|pair| (pair[0] - pair[1]).abs()).fold(0.0, f32::max);
        assert!(step < 0.03, "a stripe: a step of {step} between pixels");
    }
}

#[test]
fn beside_a_silhouette_a_body_is_open_as_its_outside_is() {
    // The outside of a tube: the sky is open to it, but for what is below its horizon. Points beyond the silhouette are within the tube, and no sky
    // comes there.
    for shading_rate in [0.25, 4.0, 30.0] {
        let p = render("2 2", &format!("ShadingRate {shading_rate} Rotate 90 1 0 0 Cylinder 0.7 -9 9 360"));
        for x in 13..67 {
            let found = p.at(x, 40);
            assert!(found[0] / found[3] > 0.45, "openness at x {x}, shading rate {shading_rate}: {found:?}");
        }
    }
}

/// What bodies around send to the middle of the wall: how much of its light is closed, that of a sun of 1 by way of white bodies, and
/// their colour. The sun stands over +x unless said.
fn around(others: &str, sun: &str) -> [f32; 5] {
    let of = |numbers: &str| {
        let source = format!(
            "surface around(vector sun = vector({sun});) {{
                 matrix m = surroundings(P, faceforward(normalize(N), I), vector(0, 0, -1), sun); Ci = color({numbers}); Oi = Os; }}"
        );
        let hidden = format!("AttributeBegin Attribute \"visibility\" \"int camera\" 0 {others} AttributeEnd");
        let world = format!("Surface \"around\" {hidden} {WALL}");
        let p = render_with(&[("around.sl", source.as_bytes())], &ORTHO.replace("8 8", "2 2"), &world).at(40, 40);
        [p[0], p[1], p[2]]
    };
    let [[closed, lit, _], [r, g, b]] =
        [of("comp(m, 0, 3), comp(m, 1, 3), 0"), of("comp(m, 1, 0), comp(m, 1, 1), comp(m, 1, 2)")];
    [closed, lit, r, g, b]
}

#[test]
fn what_is_in_the_way_sends_the_suns_light_on_in_its_colour() {
    assert_eq!(around("", "1, 0, 0")[..2], [0.0, 0.0], "nothing is there");
    // At the foot of a high wall, which closes half of the sky and faces the sun: a half of what it would send to all sides.
    let high = "Color [0.8 0.4 0.1] Polygon \"P\" [-0.001 -90 0  -0.001 90 0  -0.001 90 -90  -0.001 -90 -90]";
    let [closed, lit, r, g, b] = around(high, "1, 0, 0");
    assert_near(closed, 0.5, 0.1, "closed by a wall");
    assert_near(lit, 0.5, 0.15, "light from a wall in the sun");
    assert!((r - 0.8).abs() < 0.01 && (g - 0.4).abs() < 0.01 && (b - 0.1).abs() < 0.01, "its colour: {r} {g} {b}");
    // The sun behind it, or none, and it sends nothing.
    assert_eq!(around(high, "-1, 0, 0")[1], 0.0, "the wall's back is in the sun");
    assert_eq!(around(high, "0, 0, 0")[1], 0.0, "no sun");
    // Half as square to the sun, half as bright.
    assert_near(around(high, "0.5, 0, -0.866")[1], 0.5 * lit, 0.08, "a wall that the sun grazes");
    // A sphere on the wall opposite to the sun is bright, before the sun it shows its dark side.
    let ball = "Color [0.2 0.6 0.2] Translate -0.5 0 -0.4 Sphere 0.4 -0.4 0.4 360";
    let [bright, dark] = ["1, 0, -0.3", "-1, 0, -0.3"].map(|sun| around(ball, sun));
    assert!(bright[1] > 3.0 * dark[1] && bright[1] > 0.03, "{bright:?}, {dark:?}");
    assert!((bright[3] - 0.6).abs() < 0.01, "a ball's colour: {bright:?}");
}

#[test]
fn a_gap_takes_the_colour_of_its_walls() {
    // Under the sky alone: what is closed sends on what the point gets, in its colour, again and again.
    let light = |color: &str, bounce: f32| {
        let wall = "Polygon \"P\" [-0.001 -90 0  -0.001 90 0  -0.001 90 90  -0.001 -90 90]";
        let world = format!(
            "LightSource \"skylight\" \"sky\" \"float bounce\" [{bounce}] \"color zenith\" [1 1 1] \"color horizon\" [1 1 1]
               \"color beneath\" [0 0 0] \"color sunshine\" [0 0 0]
             AttributeBegin Attribute \"visibility\" \"int camera\" 0 Color [{color}] {wall} AttributeEnd
             Surface \"matte\" Color [1 1 1] {WALL}"
        );
        // The camera looks down: up is towards it.
        render_with(
            &[],
            &ORTHO.replace("8 8", "2 2").replace("Translate 0 0 5", "Translate 0 0 5 Scale 1 1 -1"),
            &world,
        )
        .at(40, 40)
    };
    let (plain, red) = (light("0.9 0.1 0.1", 0.0), light("0.9 0.1 0.1", 1.0));
    let open = plain[0];
    assert!((plain[1] - open).abs() < 1e-4 && open > 0.3 && open < 0.7, "without bounce the sky's colour: {plain:?}");
    for (c, albedo) in [(0, 0.9), (1, 0.1)] {
        let closed = 1.0 - open;
        assert_near(red[c], open / (1.0 - albedo * closed), 0.06, "the sum of a geometric series");
    }
}

#[test]
fn openness_depends_on_no_bucket() {
    let heap =
        "Sphere 0.2 -0.2 0.2 360 Translate 0.3 0.1 -0.1 Sphere 0.15 -0.15 0.15 360 Translate -0.5 0.2 0 Scale 1 2 1
                Sphere 0.1 -0.1 0.1 360 Translate 0 -0.2 -0.2 Rotate 30 1 1 0 Cylinder 0.1 -0.2 0.2 360";
    let with = |size: usize| {
        let world = format!("Surface \"open\" TransformBegin {heap} TransformEnd {WALL}");
        let options = format!("{}\nOption \"limits\" \"int bucketsize\" {size}\n", ORTHO.replace("8 8", "2 2"));
        render_with(&[("open.sl", OPEN.as_bytes())], &options, &world).pixels
    };
    let whole = with(128);
    assert!(whole.iter().any(|p| p[0] > 0.0 && p[0] < 0.9), "something is half hidden");
    assert!(with(16) == whole && with(40) == whole, "the same bits however the image is cut");
}

#[test]
fn an_ambient_light_knows_where_it_shines_and_which_way_the_surface_faces() {
    let light = "light by_place() { Cl = color(0.5 + 0.25 * xcomp(Ps), 0, -zcomp(normalize(Ns))); }";
    let surface = "surface lit() { Ci = ambient(); Oi = 1; }";
    let sources = [("by_place.sl", light.as_bytes()), ("lit.sl", surface.as_bytes())];
    // The wall's normal may face either way: the light is told the side that is seen.
    for turn in ["", "ReverseOrientation"] {
        let world = format!("LightSource \"by_place\" 1 Surface \"lit\" {turn} {WALL}");
        let p = render_with(&sources, &ORTHO.replace("8 8", "2 2"), &world);
        assert_near(p.at(40, 40)[2], 1.0, 1e-3, "the normal faces the eye");
        assert!((p.at(60, 40)[0] - p.at(20, 40)[0]).abs() > 0.05, "the light changes along x");
    }
}

#[test]
fn the_sky_and_the_suns_light_agree() {
    // The sky is blue overhead, brighter about the sun, and a low sun is redder and weaker than a high one.
    let sky = "#include \"sky.h\"\nsurface sky(vector sun = vector(0, 0, 1); float of = 0;) {
        vector way = normalize(sun);
        if (of == 0) Ci = sky_color(vector(0, 0.6, 0.8), way, 3);
        else if (of == 1) Ci = sky_color(way, way, 3);
        else Ci = suns_color(way, 3);
        Oi = 1; }";
    let at = |sun: &str, of: u32| {
        let world = format!("Surface \"sky\" \"vector sun\" [{sun}] \"float of\" [{of}] {WALL}");
        render_with(&[("sky.sl", sky.as_bytes())], &ORTHO.replace("8 8", "1 1"), &world).at(40, 40)
    };
    let (high, low) = ("0.6 0 0.8", "0.98 0 0.2");
    let blue = at(high, 0);
    assert!(blue[2] > 1.2 * blue[0] && blue.iter().take(3).all(|c| *c > 0.02), "a blue sky: {blue:?}");
    assert!(at(high, 1)[1] > 1.5 * blue[1], "brighter about the sun");
    let (day, dusk) = (at(high, 2), at(low, 2));
    assert!(day[1] > dusk[1], "a low sun is weaker");
    assert!(dusk[2] / dusk[0] < 0.8 * day[2] / day[0], "a low sun is redder");
}

#[test]
fn in_parallel_projection_the_sky_is_that_of_a_lens() {
    let work = crate::cli::scratch();
    std::fs::write(work.path().join("s_0.csv"), "pos_x,pos_y,pos_z\n0,0,-9\n").unwrap();
    let text = "data: {files: s_0.csv}\nscene: quarry.rib\ncamera: {view: side, orthographic: 5, look_at: [0.3, 0, 1]}
objects: [{name: grain, geometry: {sphere: {radius: 0.001}}}]\noutput: {resolution: [160, 90]}\n";
    let (file, out) = (work.path().join("m.yaml"), work.path().join("o"));
    std::fs::write(&file, text).unwrap();
    crate::cli::scree(&["render", file.to_str().unwrap(), "-o", out.to_str().unwrap()]).ok();
    let image = image::open(out.join("000000.png")).unwrap().to_rgb8();
    // The colours change slowly above the hills, and the sky is lighter at the horizon; below it is the ground.
    let steps = (0..25).flat_map(|y| (1..160).map(move |x| (x, y))).map(|(x, y)| {
        let [a, b] = [image.get_pixel(x - 1, y), image.get_pixel(x, y)];
        (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap()
    });
    assert!(steps.max().unwrap() <= 6, "no rays go out from the middle");
    let [high, low, under] = [2, 30, 85].map(|y| image.get_pixel(20, y));
    assert!(low[0] > high[0] + 4 && high[2] > high[0] && under[2] < under[0], "{high:?} {low:?} {under:?}");
}
