//! Global variables that shaders start with.

use crate::scene::camera::Camera;
use crate::scene::motion::carried;
use crate::scene::source::ItemView;
use glam::Vec3;
use sl::Global;
use sl::machine::Points;

/// What a surface shader starts with besides where it is: colours, those of a part of the time that the shutter is open, and Ng and
/// E if it asks for them.
pub fn surface_globals(points: &mut Points, view: &ItemView<'_>, eye: Vec3, time: f32) {
    let a = view.attributes;
    let slots = view.attached;
    let (color, opacity) = view.paint(time);
    let own =
        [(Global::Cs, slots.color, color), (Global::Os, slots.opacity, opacity), (Global::Oi, slots.opacity, opacity)];
    for (global, slot, of_all) in own {
        points.refill_from(global, slot, &of_all);
    }
    points.refill(Global::Ci).extend_from_slice(&[0.0; 3]);
    if a.surface.program.global(Global::Ng).is_some() {
        fill_geometric_normal(points);
    }
    if a.surface.program.global(Global::E).is_some() {
        points.refill(Global::E).extend_from_slice(&eye.to_array());
    }
}

/// Ng where it has no values yet: it is N.
pub fn fill_geometric_normal(points: &mut Points) {
    if points.get(Global::Ng).is_none_or(<[f32]>::is_empty) {
        let normal = points.get(Global::N).unwrap_or(&[]).to_vec();
        points.set(Global::Ng, normal);
    }
}

/// The change of P per unit of time as the shutter opens, at points of an item, if one of its shaders asks for it: from now to the
/// item's next moment. `deformed` has how far each is from its place in a form that is kept.
pub fn fill_velocity(
    points: &mut Points,
    view: &ItemView<'_>,
    moment: Option<f32>,
    deformed: Option<&[f32]>,
    [open, close]: [f32; 2],
) {
    if !view.attributes.reads(Global::DPdtime) {
        return;
    }
    let n = points.n();
    let mut velocity = std::mem::take(points.refill(Global::DPdtime));
    velocity.resize(3 * n, 0.0);
    if let Some(time) = moment.filter(|_| close > open) {
        let carried = carried(view, time);
        let p = points.get(Global::P).filter(|p| p.len() == 3 * n).unwrap_or(&[]);
        let off = deformed.filter(|off| off.len() == 3 * n);
        let of = |v: &[f32], k: usize| Vec3::new(v[k], v[n + k], v[2 * n + k]);
        for k in 0..p.len() / 3 {
            let at = of(p, k);
            let later = carried.transform_point3(at + off.map_or(Vec3::ZERO, |off| of(off, k)));
            let v = (later - at) / (time * (close - open));
            (velocity[k], velocity[n + k], velocity[2 * n + k]) = (v.x, v.y, v.z);
        }
    }
    *points.refill(Global::DPdtime) = velocity;
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
    for global in [Global::P, Global::N, Global::Ng] {
        if let Some(v) = points.get_mut(global).filter(|v| v.len() == 3 && n > 1) {
            *v = v.iter().flat_map(|x| std::iter::repeat_n(*x, n)).collect();
        }
    }
}
