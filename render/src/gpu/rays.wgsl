// Whether light gets from one point to another.
// Nodes are two rows: a corner and where it goes on, the other corner and its count of occluders, 0 for inner nodes. Occluders are four:
// kind and primitive; of a sphere, its middle and radius; of an ellipsoid, the rows of the matrix that makes it the unit sphere; of a
// triangle, a corner and two edges. Kinds: 0 sphere, 1 ellipsoid, 2 triangle of a flat patch, 3 triangle of a curved one.
// Twin: cpu/bvh.rs

// Not 0, of the same sign.
fn not_zero(x: f32) -> f32 {
    return select(x, select(1e-30, -1e-30, x < 0.0), abs(x) < 1e-30);
}

fn stops_ball(start: vec3<f32>, way: vec3<f32>, far: f32, ball: vec4<f32>) -> bool {
    let to = ball.xyz - start;
    let along = dot(to, way);
    let off = to - way * along;
    let left = ball.w * ball.w - dot(off, off);
    if left <= 0.0 {
        return false;
    }
    let half = sqrt(left);
    return along + half > 0.0 && along - half < far;
}

fn stops_ellipsoid(start: vec3<f32>, way: vec3<f32>, far: f32, at: u32) -> bool {
    let rows = array<vec4<f32>, 3>(world_row(at), world_row(at + 1u), world_row(at + 2u));
    let o = vec3<f32>(dot(rows[0].xyz, start) + rows[0].w, dot(rows[1].xyz, start) + rows[1].w, dot(rows[2].xyz, start) + rows[2].w);
    let d = vec3<f32>(dot(rows[0].xyz, way), dot(rows[1].xyz, way), dot(rows[2].xyz, way));
    let a = dot(d, d);
    let b = dot(o, d);
    let disc = b * b - a * (dot(o, o) - 1.0);
    if disc <= 0.0 {
        return false;
    }
    let root = sqrt(disc);
    return root - b > 0.0 && -b - root < far * a;
}

// Möller and Trumbore 1997. How far along the ray; negative where it is not met.
fn meet_triangle(start: vec3<f32>, way: vec3<f32>, a: vec3<f32>, ab: vec3<f32>, ac: vec3<f32>) -> f32 {
    let p = cross(way, ac);
    let det = dot(ab, p);
    if det == 0.0 {
        return -1.0;
    }
    let s = start - a;
    let u = dot(s, p) / det;
    let q = cross(s, ab);
    let v = dot(way, q) / det;
    if u < 0.0 || v < 0.0 || u + v > 1.0 {
        return -1.0;
    }
    return dot(ac, q) / det;
}

fn stops_triangle(start: vec3<f32>, way: vec3<f32>, far: f32, at: u32, flat: bool, own: bool) -> bool {
    let ab = world_row(at + 1u).xyz;
    let ac = world_row(at + 2u).xyz;
    let t = meet_triangle(start, way, world_row(at).xyz, ab, ac);
    // A facet of a curved surface stands off it: its own neighbourhood is not in its shadow.
    let size = sqrt(max(dot(ab, ab), dot(ac, ac)));
    let room = select(size * select(0.5, 2.0, own), 0.0, flat);
    return t > max(values[work.own + select(2u, 3u, own)], room) && t < far;
}

fn stops(start: vec3<f32>, way: vec3<f32>, far: f32, at: u32, own: u32) -> bool {
    let head = world[at];
    let is_own = head.y == own;
    switch head.x {
        case 0u: { return !is_own && stops_ball(start, way, far, world_row(at + 1u)); }
        case 1u: { return !is_own && stops_ellipsoid(start, way, far, at + 1u); }
        case 2u: { return !is_own && stops_triangle(start, way, far, at + 1u, true, false); }
        default: { return stops_triangle(start, way, far, at + 1u, false, is_own); }
    }
}

// Whether a ray meets a box within a length.
fn meets_box(start: vec3<f32>, inverse: vec3<f32>, far: f32, low: vec3<f32>, high: vec3<f32>) -> bool {
    let t0 = (low - start) * inverse;
    let t1 = (high - start) * inverse;
    let near = min(t0, t1);
    let last = max(t0, t1);
    return max(max(max(near.x, near.y), near.z), 0.0) <= min(min(min(last.x, last.y), last.z), far);
}

fn is_blocked(start: vec3<f32>, end: vec3<f32>) -> bool {
    let far = sqrt(dot(end - start, end - start));
    if world[0].z == 0u || !(far > 0.0) {
        return false;
    }
    let way = (end - start) / far;
    let inverse = 1.0 / vec3<f32>(not_zero(way.x), not_zero(way.y), not_zero(way.z));
    let own = own_primitive();
    var stack: array<u32, 64>;
    var top = 1u;
    while top > 0u {
        top -= 1u;
        let k = stack[top];
        let at = world[0].x + 2u * k;
        let low = world[at];
        let high = world[at + 1u];
        if !meets_box(start, inverse, far, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz)) {
            continue;
        }
        if high.w == 0u {
            stack[top] = low.w;
            stack[top + 1u] = k + 1u;
            top += 2u;
            continue;
        }
        for (var i = 0u; i < high.w; i += 1u) {
            if stops(start, way, far, world[0].y + 4u * (low.w + i), own) {
                return true;
            }
        }
    }
    return false;
}

fn scene_transmission(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    // What a lamp lies in, as in a ceiling, is not between.
    return select(vec3<f32>(1.0), vec3<f32>(), is_blocked(start, start + (end - start) * 0.9999));
}
