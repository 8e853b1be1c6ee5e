//! The text of kernels, held to snapshots.

use crate::compare::host;
use crate::library::hold;
use crate::world::{World, bind, bind_file, root};
use sl::machine::BoundShader;
use sl::wgsl::Kernel;
use std::sync::Arc;

/// The shaders of a kernel's text, without the parts that all kernels have.
fn own(kernel: &Kernel) -> String {
    let items = kernel.text.split("\n\n").filter(|item| {
        let is_own = |l: &str| {
            ["fn shader_", "fn spline_", "fn light_parameter_", "fn run_light"].iter().any(|f| l.starts_with(f))
        };
        item.lines().any(is_own)
    });
    items.collect::<Vec<_>>().join("\n\n") + "\n"
}

#[test]
fn the_text_of_kernels() {
    let lamp = "light lamp(string __category = \"key\"; output float power = 1;) { illuminate(point(0, 0, 3)) { Cl = 1 / (L . L); power = 2; } }";
    let lights: Vec<Arc<BoundShader>> = [lamp, "light all() { Cl = 0.25; }"].iter().map(|l| bind(l)).collect();
    let shaders = [
        ("matte", bind_file(&root().join("shaders/surface/matte.sl")).unwrap()),
        (
            "control",
            bind("float f(float x) { float i; for (i = 0; i < 3; i += 1) { if (i > x) return i; if (i == 1) continue; } return 9; }
                surface control(string space = \"object\") {
                    float a[3] = {1, 2, 3};
                    if (space == \"object\") Ci = f(s) * a[mod(floor(s * 3), 3)] * xcomp(transform(space, P)); else Ci = texture(\"x\");
                }"),
        ),
        (
            "neighbours",
            bind("surface neighbours() { Ci = 0; if (s > 0.5) { Ci = filterwidth(s); } illuminance(\"key\", P) { float p = 0; lightsource(\"power\", p); Ci += p * Cl; } }"),
        ),
    ];
    for (name, shader) in shaders {
        let world = World { lights: lights.clone(), ..World::default() };
        let kernel = Kernel::new(&shader, &world.lights, host(&world)).unwrap();
        hold(&format!("{name}.wgsl.txt"), &own(&kernel));
    }
}
