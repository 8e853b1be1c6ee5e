// The nearest point of the outline of a cylinder or a cone, in the half plane of the distance from the axis and the height.
// Twin: cpu/collide/round.rs, nearest_outline

// The outward normal at the nearest point of a segment, and the distance to it; `best` has those of the segments before.
fn nearer(p: vec2<f32>, a: vec2<f32>, b: vec2<f32>, best: vec3<f32>) -> vec3<f32> {
    let edge = b - a;
    let normal = normalize(vec2(edge.y, -edge.x));
    let t = clamp(dot(p - a, edge) / dot(edge, edge), 0.0, 1.0);
    let offset = p - (a + edge * t);
    let distance = length(offset);
    if distance >= abs(best.z) {
        return best;
    }
    return vec3(normal, distance);
}

// The outward normal at the nearest point to `p` of the outline of a solid of this radius and half height, and the distance, negative
// inside.
fn outline(p: vec2<f32>, size: vec2<f32>, is_cone: bool) -> vec3<f32> {
    let bottom = vec2(0.0, -size.y);
    let rim = vec2(size.x, -size.y);
    let upper = select(vec2(size.x, size.y), vec2(0.0, size.y), is_cone);
    let top = vec2(0.0, size.y);
    var best = nearer(p, bottom, rim, vec3(1.0, 0.0, 3e38));
    best = nearer(p, rim, upper, best);
    let side = normalize(vec2(upper.y - rim.y, rim.x - upper.x));
    var is_inside = p.y > -size.y && dot(p - rim, side) < 0.0;
    if !is_cone {
        best = nearer(p, upper, top, best);
        is_inside = is_inside && p.y < size.y;
    }
    if is_inside {
        return vec3(best.xy, -best.z);
    }
    // Beside an edge the normal is the direction from its nearest point.
    var nearest = nearest_of(p, bottom, rim);
    var found = length(p - nearest);
    let on_side = nearest_of(p, rim, upper);
    if length(p - on_side) < found {
        nearest = on_side;
        found = length(p - on_side);
    }
    let on_top = nearest_of(p, upper, top);
    if !is_cone && length(p - on_top) < found {
        nearest = on_top;
        found = length(p - on_top);
    }
    return vec3(select(best.xy, (p - nearest) / found, found > 0.0), best.z);
}

fn nearest_of(p: vec2<f32>, a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let edge = b - a;
    return a + edge * clamp(dot(p - a, edge) / max(dot(edge, edge), 1e-30), 0.0, 1.0);
}
