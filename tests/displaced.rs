//! Displaced surfaces as rays meet them: shadows on displaced ground against the closed form, shadows and mirror images of others.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, Rendered, render_with};

/// Waves of a height along a direction of the plane; `waves` of them a unit.
const WAVES: &[u8] = b"displacement waves(float height = 0.05; float waves = 2; float turn = 0.5;) {
    point Q = transform(\"world\", P);
    float w = cos(turn) * xcomp(Q) + sin(turn) * ycomp(Q);
    P += height * sin(2 * PI * waves * w) * vector(0, 0, -1);
    N = calculatenormal(P); }";

/// The surface moves out by a distance.
const SWELL: &[u8] = b"displacement swell(float by = 0.2;) { P += by * normalize(N); N = calculatenormal(P); }";

const FILES: [(&str, &[u8]); 2] = [("waves.sl", WAVES), ("swell.sl", SWELL)];

/// The half width of the ground of waves.
const HALF: f32 = 0.9;

/// Waves of ground under parallel light that comes in at an elevation along the plane's direction `sun`.
struct Ground {
    height: f32,
    waves: f32,
    turn: f32,
    elevation: f32,
    sun: f32,
}

impl Ground {
    fn height_at(&self, x: f32, y: f32) -> f32 {
        let w = self.turn.cos() * x + self.turn.sin() * y;
        self.height * (std::f32::consts::TAU * self.waves * w).sin()
    }

    /// Lambert's law where nothing stands in the light's way, and how far by height it is from standing there.
    fn expected(&self, x: f32, y: f32) -> (f32, f32) {
        let slope = std::f32::consts::TAU
            * self.waves
            * self.height
            * (std::f32::consts::TAU * self.waves * (self.turn.cos() * x + self.turn.sin() * y)).cos();
        let (across, up) = (self.elevation.cos(), self.elevation.sin());
        let to_sun = [across * self.sun.cos(), across * self.sun.sin()];
        let rise = slope * (to_sun[0] * self.turn.cos() + to_sun[1] * self.turn.sin());
        let lit = (up - rise) / (1.0 + slope * slope).sqrt();
        let own = self.height_at(x, y);
        // The ray's height over the ground at its lowest, beyond its own neighbourhood where the ground leaves it at an angle.
        let over = (1..4000).map(|k| 0.0005 * k as f32).map(|s| {
            let [px, py] = [x + s * self.sun.cos(), y + s * self.sun.sin()];
            if px.abs() > HALF || py.abs() > HALF {
                f32::INFINITY
            } else {
                own + s * up / across - self.height_at(px, py)
            }
        });
        let room = over.fold(f32::INFINITY, f32::min);
        (if room < 0.0 || lit < 0.0 { 0.0 } else { lit }, room)
    }

    fn render(&self, rate: f32) -> Rendered {
        let options = format!(
            "Format 200 200 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 ShadingRate {rate} Projection \"orthographic\" Translate 0 0 5"
        );
        let (across, up) = (self.elevation.cos(), self.elevation.sin());
        let way = [-across * self.sun.cos(), -across * self.sun.sin(), up];
        let world = format!(
            "LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [{} {} {}] Surface \"matte\" \"Ka\" 0 \"Kd\" 1
             Displacement \"waves\" \"float height\" [{}] \"float waves\" [{}] \"float turn\" [{}] Attribute \"displacementbound\" \"sphere\" [0.2]
             Polygon \"P\" [-{HALF} -{HALF} 0 {HALF} -{HALF} 0 {HALF} {HALF} 0 -{HALF} {HALF} 0]",
            way[0], way[1], way[2], self.height, self.waves, self.turn
        );
        render_with(&FILES, &options, &world)
    }
}

#[test]
fn displaced_ground_at_grazing_light_has_its_own_shadows_without_teeth() {
    // Waves at an angle to the rows of micropolygons, and along them; light along the rows, too. Everywhere but beside the edges of
    // shadows the image must be Lambert's law in the light and black out of it: neither teeth nor specks.
    for (height, waves, turn, degrees, sun, rate) in [
        (0.05, 2.0, 0.5, 6.0, 0.5, 1.0),
        (0.05, 2.0, 0.5, 20.0, 1.1, 1.0),
        (0.02, 2.0, 0.0, 3.0, 0.0, 1.0),
        (0.02, 3.0, 0.9, 45.0, 0.3, 1.0),
        (0.1, 1.5, 0.3, 12.0, 0.0, 1.0),
        (0.05, 2.0, 0.5, 10.0, 0.8, 4.0),
        (0.05, 2.0, 0.7, 10.0, 0.0, 9.0),
    ] {
        let ground = Ground { height, waves, turn, elevation: f32::to_radians(degrees), sun };
        let image = ground.render(rate);
        let place = |x: usize, y: usize| ((x as f32 + 0.5) / 100.0 - 1.0, 1.0 - (y as f32 + 0.5) / 100.0);
        let expected: Vec<f32> = (0..200 * 200)
            .map(|k| {
                let (x, y) = place(k % 200, k / 200);
                ground.expected(x, y).0
            })
            .collect();
        let reach = 2 + rate.sqrt() as usize;
        let (mut dark, mut lit, mut wrong) = (0, 0, vec![]);
        for y in 15..185 {
            for x in 15..185 {
                let e = expected[y * 200 + x];
                let around = (y - reach..=y + reach).flat_map(|j| (x - reach..=x + reach).map(move |i| j * 200 + i));
                if around.into_iter().any(|k| (expected[k] > 0.0) != (e > 0.0)) {
                    continue;
                }
                if e > 0.0 {
                    lit += 1
                } else {
                    dark += 1
                }
                if (image.at(x, y)[0] - e).abs() > 0.03 + 0.01 * rate {
                    wrong.push((x, y, image.at(x, y)[0], e));
                }
            }
        }
        let case = format!("height {height}, {waves} waves, turn {turn}, light {degrees} along {sun}, rate {rate}");
        assert!(lit > 1500 && dark > 1500 || degrees > 40.0, "{case}: {lit} lit, {dark} dark");
        assert!(wrong.is_empty(), "{case}: {} of {}, as {:?}", wrong.len(), lit + dark, &wrong[..wrong.len().min(4)]);
    }
}

#[test]
fn displaced_ground_seen_askew_is_as_fine_where_it_turns_to_the_eye() {
    // Waves at an angle, seen at 8 degrees above the ground by an eye that the sun stands behind: what is seen is lit, by Lambert's law.
    let hills = b"displacement hills() { point Q = transform(\"world\", P);
        P += 0.05 * sin(4 * PI * (0.36 * xcomp(Q) + 0.93 * ycomp(Q))) * vector(0, 0, 1); N = calculatenormal(P); }";
    let (s, c) = 8f32.to_radians().sin_cos();
    let options = format!(
        "Format 120 120 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 10
         ConcatTransform [1 0 0 0  0 {s} {c} 0  0 {c} -{s} 0  0 0 0 1]"
    );
    let world = format!(
        "LightSource \"distantlight\" 1 \"from\" [0 -{c} {s}] \"to\" [0 0 0] Surface \"matte\" \"Ka\" 0 \"Kd\" 1
         Displacement \"hills\" Attribute \"displacementbound\" \"sphere\" [0.06] Polygon \"P\" [-3 -16 0 3 -16 0 3 16 0 -3 16 0]"
    );
    let image = render_with(&[("hills.sl", hills)], &options, &world);
    let turn = 4.0 * std::f32::consts::PI;
    let height = |x: f32, y: f32| 0.05 * (turn * (0.36 * x + 0.93 * y)).sin();
    let expected = |x: f32, up: f32| {
        // From the height of the crests down along the view.
        let over = |t: f32| {
            let (y, z) = (up * s + t * c, up * c - t * s);
            (y, z - height(x, y))
        };
        let first = (up * c - 0.05) / s;
        let met = (0..4000).map(|k| first + k as f32 * 0.0002).find(|t| over(*t).1 <= 0.0).unwrap_or(first + 0.8);
        let slope = 0.05 * turn * (turn * (0.36 * x + 0.93 * over(met).0)).cos();
        let (a, b) = (0.36 * slope, 0.93 * slope);
        ((b * c + s) / (1.0 + a * a + b * b).sqrt()).max(0.0)
    };
    let places = (6..114).flat_map(|j| (6..114).map(move |i| (i, j)));
    let off = places.map(|(i, j)| {
        let (x, up) = ((i as f32 + 0.5) / 60.0 - 1.0, 1.0 - (j as f32 + 0.5) / 60.0);
        (image.at(i, j)[0] - expected(x, up)).abs()
    });
    let mean = off.sum::<f32>() / (108.0 * 108.0);
    assert!(mean < 0.09, "mean difference {mean}");
}

/// The dark area that things before a white wall at z = 1 cast on it in light along z, square units.
fn shadow(things: &str) -> f32 {
    let options = "Format 320 320 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 Projection \"orthographic\" Scale 0.5 0.5 1 Translate 0 0 5";
    let wall = "LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Polygon \"P\" [-2 -2 1 2 -2 1 2 2 1 -2 2 1]";
    let unseen = "Attribute \"visibility\" \"int camera\" [0] Attribute \"displacementbound\" \"sphere\" [0.3]";
    let image = render_with(&FILES, options, &format!("{wall} {unseen} {things}"));
    image.pixels.iter().map(|p| 1.0 - p[0]).sum::<f32>() / 6400.0
}

#[test]
fn displaced_surfaces_cast_the_shadows_of_what_they_became() {
    let pi = std::f32::consts::PI;
    let swell = "Displacement \"swell\"";
    for (things, expected) in [
        // A sphere of 0.5 swells to 0.7, half of one too; a square moves along its normal and keeps its shadow.
        (format!("{swell} Sphere 0.5 -0.5 0.5 360"), 0.49 * pi),
        (format!("{swell} Sphere 0.5 -0.5 0.5 180"), 0.245 * pi),
        (format!("{swell} Polygon \"P\" [-0.5 -0.5 0 0.5 -0.5 0 0.5 0.5 0 -0.5 0.5 0]"), 1.0),
        (format!("{swell} Rotate 90 1 0 0 Cylinder 0.3 -0.5 0.5 360"), 1.0),
        (
            format!(
                "{swell} ObjectBegin 1 Sphere 0.3 -0.3 0.3 360 ObjectEnd Translate -0.8 0 0 ObjectInstance 1 Translate 1.6 0 0 ObjectInstance 1"
            ),
            0.5 * pi,
        ),
        // Cut to a whole by solids: the swollen sphere without a swollen sphere that covers half of it.
        (
            format!(
                "{swell} SolidBegin \"difference\" SolidBegin \"primitive\" Sphere 0.5 -0.5 0.5 360 SolidEnd SolidBegin \"primitive\" Translate 0 0 0 Sphere 0.3 -0.3 0.3 360 SolidEnd SolidEnd"
            ),
            0.49 * pi,
        ),
        (
            format!(
                "{swell} SolidBegin \"intersection\" SolidBegin \"primitive\" Sphere 0.5 -0.5 0.5 360 SolidEnd SolidBegin \"primitive\" Sphere 0.3 -0.3 0.3 360 SolidEnd SolidEnd"
            ),
            0.25 * pi,
        ),
        // A surface that lets half of the light through.
        (format!("Opacity 0.5 0.5 0.5 {swell} Polygon \"P\" [-0.5 -0.5 0 0.5 -0.5 0 0.5 0.5 0 -0.5 0.5 0]"), 0.5),
    ] {
        let found = shadow(&things);
        assert!((found - expected).abs() < 0.02, "{things}: {found}, expected {expected}");
    }
}

#[test]
fn rays_of_shaders_meet_displaced_surfaces_where_they_are() {
    // A floor asks how far it is up to a sphere of 0.5 about a height of 2 that swelled to 0.7: 1.3 under its middle; and looks at its
    // normals, which are mirrored as they are: straight down there.
    let ask = b"surface ask(string what = \"far\";) { Oi = 1;
        vector up = vector(0, 0, -1);
        if (what == \"far\") { float far = trace(P, up); Ci = far; } else { color c = trace(P, up); Ci = c; } }";
    let tell = b"surface tell() { Oi = 1; vector n = normalize(N); Ci = color(u, abs(zcomp(n)), xcomp(transform(\"object\", P))); }";
    let [waves, swell] = FILES;
    let files: [(&str, &[u8]); 4] = [waves, swell, ("ask.sl", ask), ("tell.sl", tell)];
    let above = "Attribute \"visibility\" \"int camera\" [0] Attribute \"displacementbound\" \"sphere\" [0.3] Displacement \"swell\" Surface \"tell\"";
    for (above, what, expected) in [
        (format!("{above} Translate 0 0 -2 Sphere 0.5 -0.5 0.5 360"), "far", [1.3, 1.3, 1.3]),
        (format!("{above} Translate 0 0 -2 Rotate 90 1 0 0 Sphere 0.5 -0.5 0.5 360"), "normal", [f32::NAN, 1.0, 0.0]),
        (
            format!("{above} Patch \"bilinear\" \"P\" [-0.5 -0.5 -2 0.5 -0.5 -2 -0.5 0.5 -2 0.5 0.5 -2]"),
            "normal",
            [0.5, 1.0, 0.0],
        ),
    ] {
        let floor = format!(
            "Surface \"ask\" \"string what\" \"{what}\" Polygon \"P\" [-0.9 -0.9 0 0.9 -0.9 0 0.9 0.9 0 -0.9 0.9 0]"
        );
        let found = render_with(&files, ORTHO, &format!("AttributeBegin {floor} AttributeEnd {above}")).at(40, 40);
        let near = (0..3).all(|c| expected[c].is_nan() || (found[c] - expected[c]).abs() < 0.03);
        assert!(near, "{what} of {above}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn displaced_surfaces_that_find_no_memory_end_the_image_and_say_what_helps() {
    let work = scratch();
    let path = work.path().join("t.rib");
    let scene = "Display \"t.png\" \"png\" \"rgb\" Format 800 800 1 Projection \"orthographic\" Translate 0 0 5\nWorldBegin
        LightSource \"distantlight\" 1 \"to\" [0.5 -0.5 1] Surface \"matte\" ShadingRate 0.05 Displacement \"rock\" \"float Km\" [0.05]
        Attribute \"displacementbound\" \"float sphere\" [0.06] Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]\nWorldEnd\n";
    std::fs::write(&path, scene).unwrap();
    let out = work.path().to_str().unwrap();
    let said = scree(&["--memory", "120MiB", "render", path.to_str().unwrap(), "-o", out]).fails(3);
    assert!(
        said.contains("no room for the displaced surfaces that rays meet") && said.contains("ShadingRate"),
        "{said}"
    );
}
