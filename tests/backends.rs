//! `scree render --backend gpu` and `scree bench render --backend gpu`, on an adapter, where there is one.

use crate::cli::{scratch, scree};
use crate::devices::has_adapter;
use crate::rendering::ON_DEVICE;
use std::collections::BTreeSet;

const CAMERA: &str =
    "Format 96 72 1 PixelSamples 4 4 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" 45
    Translate 0 0 6 Rotate -35 1 0 0 Rotate 20 0 1 0\n";

/// The command says once why the processor has drawn images, and chooses adapters.
#[test]
fn scree_render_draws_on_a_device() {
    if !has_adapter() {
        return;
    }
    let folder = scratch();
    let scene = folder.path().join("t.rib");
    let write = |world: &str| {
        let lit = "WorldBegin LightSource \"distantlight\" 1 Surface \"matte\"";
        std::fs::write(&scene, format!("Display \"t.png\" \"png\" \"rgb\" {CAMERA}{lit} {world} WorldEnd")).unwrap();
    };
    let out = folder.path().display().to_string();
    let command = ["render", scene.to_str().unwrap(), "-o", &out, "--backend", "gpu", "--adapter", "0"];
    let image = || std::fs::read(folder.path().join("t.png")).unwrap();
    write("Opacity [0.5 0.5 0.5] Sphere 1 -1 1 360");
    let answer = scree(&command);
    assert!(!answer.errors().contains("processor"), "{}", answer.errors());
    answer.ok();
    let drawn = image();
    let answer = scree(&command.iter().copied().chain(["--gpu-memory", "64MiB"]).collect::<Vec<_>>());
    assert!(!answer.errors().contains("processor"), "{}", answer.errors());
    answer.ok();
    assert!(image() == drawn, "within less memory");
    let part = |x: f32| format!("SolidBegin \"primitive\" Translate {x} 0 0 Sphere 1 -1 1 360 SolidEnd");
    write(&format!("SolidBegin \"difference\" {} {} SolidEnd", part(0.0), part(1.0)));
    let answer = scree(&command);
    assert_eq!(
        answer.errors().matches("the processor has drawn the image: the scene has solids").count(),
        1,
        "{}",
        answer.errors()
    );
    answer.ok();
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--backend", "gpu", "--adapter", "nobody's"]);
    assert!(answer.fails(2).contains("nobody's"));
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--backend", "gpu", "--adapter", ""]);
    assert!(answer.fails(2).contains("expected the index of an adapter or a part of its name"), "{}", answer.errors());
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--backend", "cpu", "--gpu-memory", "1GiB"]);
    assert!(answer.fails(2).contains("--gpu-memory"));
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--adapter", "0"]);
    assert!(answer.fails(2).contains("--backend gpu"));
}

/// Of what a shader asks in vain, both back ends say the same: the place of the primitive, and that in the shader.
#[test]
fn what_a_shader_asks_in_vain_is_said_with_both_places_on_a_device() {
    if !has_adapter() {
        return;
    }
    let folder = scratch();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let shader = "surface t() { Oi = 1;
 float n = 1; float x[2] = {1, 1};
 Ci = texture(\"no.png\") + color(transform(\"nosuch\", P));
 Ci += texture(\"\", s, t, \"foo\", 1) + environment(\"none.png\", N);
 textureinfo(\"lost.png\", \"channels\", n);
 Ci += n * float texture(\"no.png\", s, t); }";
    std::fs::write(at("t.sl"), shader).unwrap();
    let scene = format!(
        "Display \"t.png\" \"png\" \"rgb\"\n{CAMERA}WorldBegin\nSurface \"t\"\n Sphere 1 -1 1 360\n Disk 0 2 360\nWorldEnd\n"
    );
    std::fs::write(at("t.rib"), scene).unwrap();
    let said = |more: &[&str]| {
        let answer = scree(&[&["render", &at("t.rib"), "-o", &at("")], more].concat());
        answer.ok();
        let warnings =
            |errors: String| errors.lines().filter(|line| line.starts_with("warning")).map(String::from).collect();
        (warnings(answer.errors()), answer.errors())
    };
    let (own, errors): (BTreeSet<String>, String) = said(&["--backend", "gpu", "--adapter", "0"]);
    let (others, _): (BTreeSet<String>, String) = said(&["--backend", "cpu"]);
    assert!(!errors.contains("the processor has drawn"), "{errors}");
    for (line, what) in [
        (3, "texture `no.png` cannot be read and is black"),
        (3, "names the unknown space `nosuch`"),
        (4, "has the unknown option `foo`"),
        (4, "texture `none.png` cannot be read and is black"),
        (5, "texture `lost.png` cannot be read"),
    ] {
        let place = format!("t.sl:{line}:");
        let is_it = |said: &&String| said.contains("t.rib:6:2: ") && said.contains(&place) && said.contains(what);
        assert!(own.iter().any(|said| is_it(&said)), "{what}: {errors}");
        assert!(others.iter().any(|said| is_it(&said)), "{what}: {others:#?}");
    }
    // The processor also says the other places of one that is asked for at several.
    assert!(own.is_subset(&others), "{own:#?} {others:#?}");
}

/// The benchmark compares both back ends.
#[test]
fn the_benchmark_compares_both_back_ends() {
    if !has_adapter() {
        return;
    }
    let answer = scree(&[
        "bench",
        "render",
        "--n",
        "300",
        "--res",
        "96x54",
        "--backend",
        "gpu",
        "--adapter",
        "0",
        "--compare",
        "cpu",
        "--json",
    ]);
    let json: serde_json::Value = serde_json::from_str(&answer.ok()).unwrap();
    let part = |key: &str| json[key].as_f64().unwrap_or_else(|| panic!("{json}"));
    assert!(part("ids_equal_fraction") >= 0.9999 && part("pixels_within_2_fraction") >= 0.999, "{json}");
    assert!(json["backend"] == "gpu" && json["adapter"].is_string(), "{json}");
}

/// What is known on paper is so on a device: tests of images, run again by themselves.
#[test]
fn images_known_on_paper_are_right_on_a_device() {
    if !has_adapter() {
        return;
    }
    let names = [
        "rendering::a_sphere_is_lit_by_lamberts_law",
        "rendering::a_disc_covers_its_area_and_has_no_facets",
        "rendering::a_half_plane_covers_half_through_every_filter",
        "rendering::half_transparent_layers_multiply",
        "rendering::perspective_puts_points_where_they_belong",
        "rendering::no_background_shows_between_grids",
        "blur::a_moving_edge_is_a_ramp",
        "blur::a_shutter_sees_its_part_of_many_segments",
        "blur::everything_that_can_move_covers_its_mean_area",
        "blur::a_point_out_of_focus_is_a_circle_of_confusion",
        "blur::blur_opens_no_holes",
        "light::the_sun_has_a_penumbra_as_wide_as_its_disc",
        "light::light_through_two_panes_is_the_product",
        "sky::in_the_open_a_plane_gets_what_its_tilt_lets_it",
        "sky::a_sphere_hides_its_form_factor_of_the_sky",
        "sky::facets_hide_what_is_behind_them_and_nothing_else",
        "sky::the_sky_and_the_suns_light_agree",
        "horizon::fine_textures_fade_to_their_mean",
        "horizon::textures_seen_askew_fade_to_their_mean",
    ];
    let own = std::env::current_exe().unwrap();
    let answer = std::process::Command::new(own).arg("--exact").args(names).env(ON_DEVICE, "1").output().unwrap();
    let said = String::from_utf8_lossy(&answer.stdout);
    assert!(answer.status.success() && said.contains(&format!("{} passed", names.len())), "{said}");
}
