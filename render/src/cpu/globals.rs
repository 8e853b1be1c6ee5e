//! Global variables that shaders start with.

use crate::scene::camera::Camera;
use crate::scene::source::ItemView;
use glam::Vec3;
use sl::Global;
use sl::machine::Points;

/// What a surface shader starts with besides where it is: colours, and Ng and E if it asks for them.
pub fn surface_globals(points: &mut Points, view: &ItemView<'_>, eye: Vec3) {
    let a = view.attributes;
    let slots = view.attached;
    let own = [
        (Global::Cs, slots.color, view.color),
        (Global::Os, slots.opacity, a.opacity),
        (Global::Oi, slots.opacity, a.opacity),
    ];
    for (global, slot, of_all) in own {
        points.refill_from(global, slot, &of_all);
    }
    points.refill(Global::Ci).extend_from_slice(&[0.0; 3]);
    if a.surface.program.global(Global::Ng).is_some() {
        let normal = points.get(Global::N).unwrap_or(&[]).to_vec();
        points.refill(Global::Ng).extend(normal);
    }
    if a.surface.program.global(Global::E).is_some() {
        points.refill(Global::E).extend_from_slice(&eye.to_array());
    }
}

/// I at every point, and a uniform P or N made varying, as projection wants it.
pub fn fill_incident(points: &mut Points, camera: &Camera) {
    spread(points);
    let n = points.n();
    let mut i = std::mem::take(points.refill(Global::I));
    i.resize(3 * n, 0.0);
    let p = points.get(Global::P).unwrap_or(&[]);
    for k in 0..n {
        let v = camera.incident(Vec3::new(p[k], p[n + k], p[2 * n + k]));
        (i[k], i[n + k], i[2 * n + k]) = (v.x, v.y, v.z);
    }
    *points.refill(Global::I) = i;
}

/// A shader may have left P or N the same everywhere.
pub fn spread(points: &mut Points) {
    let n = points.n();
    for global in [Global::P, Global::N] {
        if let Some(v) = points.get_mut(global).filter(|v| v.len() == 3 && n > 1) {
            *v = v.iter().flat_map(|x| std::iter::repeat_n(*x, n)).collect();
        }
    }
}
