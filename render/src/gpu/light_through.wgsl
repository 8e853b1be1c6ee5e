// The light that gets from one point to another, where some of what is in its way keeps a part of it: each surface that is met its opacity.
// The row of such an occluder has its opacity, and a number that is the same for all parts of a thing.
// Twin: cpu/view.rs, cpu/rays.rs

// Surfaces of late, of which the next may be the same again, and the most that a ray passes.
const LATE: u32 = 8u;
const MOST: u32 = 65535u;

// What a ray meets next.
struct Next {
    t: f32,
    // Index of the occluder; all bits if there is none.
    at: u32,
}

// What rounding makes of how far along a ray two facets are that share an edge, in parts of that and of where the ray begins.
const ROUNDING: f32 = 1e-5;

// How near an edge of a triangle, in parts of it, the triangle beyond it may be met as well.
const AT_EDGE: f32 = 1e-4;

// Whether another facet of a surface may be met where one is, too: on an edge that they share; so is all that is no triangle.
fn is_at_edge(start: vec3<f32>, way: vec3<f32>, at: u32) -> bool {
    let kind = world[at].x;
    if kind != 2u && kind != 3u {
        return true;
    }
    let met = meet_plane(start, way, world_row(at + 1u).xyz, world_row(at + 2u).xyz, world_row(at + 3u).xyz);
    return any(met.parts < vec3<f32>(AT_EDGE * met.size));
}

// How far on from where a ray enters what is round it may leave that.
fn step_of(t: f32, near: vec2<f32>) -> f32 {
    return max(near.x, 1e-5 * t);
}

// The nearest surface after one: of what is equally near, the next in the order of occluders; a sphere's other side is past the step.
fn next_after(last: Next, start: vec3<f32>, way: vec3<f32>, far: f32, own: u32, near: vec2<f32>) -> Next {
    let inverse = inverse_of(way);
    let head = world[0];
    var next = Next(far, 0xffffffffu);
    var k = 0u;
    while k < head.z {
        let at = head.x + 2u * k;
        let low = world[at];
        let high = world[at + 1u];
        if !meets_box(start, inverse, next.t, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz)) {
            k = low.w;
            continue;
        }
        k += 1u;
        let end = (high.w >> 3u) + (high.w & 7u);
        for (var i = high.w >> 3u; i < end; i += 1u) {
            var t = distance_beyond(start, way, head.y + 4u * i, own, near, 0.0);
            if t >= 0.0 && (t < last.t || (t == last.t && i <= last.at)) {
                // The far side of what has been met on this one.
                t = distance_beyond(start, way, head.y + 4u * i, own, near, t + step_of(t, near));
                if t < last.t || (t == last.t && i <= last.at) {
                    t = -1.0;
                }
            }
            if t >= 0.0 && t < far && (t < next.t || (t == next.t && i < next.at)) {
                next = Next(t, i);
            }
        }
    }
    return next;
}

fn light_along(start: vec3<f32>, lamp: vec3<f32>) -> vec3<f32> {
    if is_blocked(start, lamp) {
        return vec3<f32>();
    }
    let own = own_primitive();
    let near = near_of_start();
    let length_of = sqrt(dot(lamp - start, lamp - start));
    if !(length_of > 0.0) {
        return vec3<f32>(1.0);
    }
    let way = (lamp - start) / length_of;
    let far = length_of * 0.9999;
    let head = world[0];
    let rounding = ROUNDING * max(max(abs(start.x), abs(start.y)), abs(start.z));
    var open = vec3<f32>(1.0);
    var late: array<vec3<u32>, 8>;
    var n_late = 0u;
    var last = Next(-1.0, 0u);
    for (var passed = 0u; passed < MOST; passed += 1u) {
        last = next_after(last, start, way, far, own, near);
        if last.at == 0xffffffffu {
            break;
        }
        let row = world[head.y + 4u * last.at].w;
        let opacity = world_row(row).xyz;
        let whole = world[row].w;
        // An edge of two facets is met once.
        let at_edge = is_at_edge(start, way, head.y + 4u * last.at);
        var counts = true;
        for (var k = 0u; k < min(n_late, LATE); k += 1u) {
            let before = bitcast<f32>(late[k].y);
            let is_same = late[k].x == whole && last.t <= before + ROUNDING * abs(before) + rounding;
            counts = counts && !(is_same && (at_edge || late[k].z != 0u));
        }
        if !counts {
            continue;
        }
        late[n_late % LATE] = vec3<u32>(whole, bitcast<u32>(last.t), select(0u, 1u, at_edge));
        n_late += 1u;
        open *= clamp(1.0 - opacity, vec3<f32>(), vec3<f32>(1.0));
        if all(open < vec3<f32>(1e-3)) {
            return vec3<f32>();
        }
    }
    return open;
}
