// Directions spread about a normal, for rays: the same as those of the grid machine.

fn sl_spread(i: u32, p: vec3<f32>) -> vec2<f32> {
    let at = vec3<f32>(sl_round(p.x * 8192.0), sl_round(p.y * 8192.0), sl_round(p.z * 8192.0));
    let k = f32(i) + 1.0;
    return fract(vec2<f32>(k * 0.7548777 + sl_cell(at, 0u), k * 0.5698403 + sl_cell(at, 1u)));
}

// The direction at a cosine from a unit axis, turned about it by a part of a whole turn.
fn sl_around(n: vec3<f32>, cosine: f32, part: f32) -> vec3<f32> {
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    let side = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    let u = vec3<f32>(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
    let v = vec3<f32>(b, side + n.y * n.y * a, -n.y);
    let turn = part * 6.28318531;
    return n * cosine + (u * sl_cos(turn) + v * sl_sin(turn)) * sine;
}

fn sl_in_hemisphere(n: vec3<f32>, i: u32, p: vec3<f32>) -> vec3<f32> {
    let at = sl_spread(i, p);
    return sl_around(n, sqrt(1.0 - at.x), at.y);
}

// Direction `i` of `n` about an axis within an angle.
fn sl_in_cone(axis: vec3<f32>, angle: f32, i: u32, n: u32, p: vec3<f32>) -> vec3<f32> {
    let l = sqrt(dot(axis, axis));
    var about = vec3<f32>(0.0, 0.0, 1.0);
    if l > 0.0 {
        about = axis / l;
    }
    if n == 1u || angle <= 0.0 {
        return about;
    }
    let at = sl_spread(i, p);
    return sl_around(about, 1.0 - at.x * (1.0 - sl_cos(min(angle, 3.14159274))), at.y);
}

// The part of the rays over a hemisphere that meet a surface.
fn sl_occlusion(p: vec3<f32>, way: vec3<f32>, samples: f32) -> f32 {
    let n = select(64u, u32(min(samples, 4096.0)), samples >= 1.0);
    let about = sl_unit(way);
    var sum = 0.0;
    for (var i = 0u; i < n; i += 1u) {
        sum += f32(scene_hit(p, sl_in_hemisphere(about, i, p)) >= 0.0) / f32(n);
    }
    return sum;
}

// The distance along a ray to the nearest surface.
fn sl_trace(p: vec3<f32>, way: vec3<f32>) -> f32 {
    let far = scene_hit(p, sl_unit(way));
    return select(min(far, 1e30), 1e30, far < 0.0);
}
