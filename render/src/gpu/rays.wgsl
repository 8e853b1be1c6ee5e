// Whether light gets from one point to another, and what a ray meets first.
// Nodes are two rows, in the order of a walk: a corner and the next node that is not below; the other corner and, of a leaf, 8 times its first
// occluder and their count, 0 of others. Occluders are four:
// kind and primitive, and last the row of what lets a part of light through, else 0; of a sphere, its middle and radius; of an ellipsoid, the rows of the matrix that makes it the unit sphere; of a
// triangle, its corners, and after the primitive how near the start of a ray it may be in its own way. Kinds: 0 sphere, 1 ellipsoid,
// 2 triangle of a flat patch, 3 triangle of a curved one, 4 triangle of a displaced surface, which is met as it is seen.
// Twin: cpu/bvh.rs, cpu/mesh.rs

// Not 0, of the same sign.
fn not_zero(x: f32) -> f32 {
    return select(x, select(1e-30, -1e-30, x < 0.0), abs(x) < 1e-30);
}

// The reciprocals of a direction, finite.
fn inverse_of(way: vec3<f32>) -> vec3<f32> {
    return 1.0 / vec3<f32>(not_zero(way.x), not_zero(way.y), not_zero(way.z));
}

// How near its start a ray of the point that is shaded meets nothing of others, and nothing of its own primitive.
fn near_of_start() -> vec2<f32> {
    return vec2<f32>(values[work.own + 2u], values[work.own + 3u]);
}

fn greatest(v: vec3<f32>) -> f32 {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

// How deep within a sphere a point where another surface touches it may be found, in parts of the radius.
const ON_ROUND: f32 = 1e-5;

// Whether a ray begins on a sphere, or hardly within, and goes outwards; `near` is the most that this may be.
fn leaves_ball(start: vec3<f32>, way: vec3<f32>, ball: vec4<f32>, near: f32) -> bool {
    let to = ball.xyz - start;
    let least = ball.w - min(near, ON_ROUND * ball.w + 4e-6 * greatest(start));
    return dot(to, way) <= 0.0 && dot(to, to) >= least * least;
}

// The same of an ellipsoid, by the rows of the matrix that makes it the unit sphere.
fn leaves_ellipsoid(start: vec3<f32>, way: vec3<f32>, x: vec4<f32>, y: vec4<f32>, z: vec4<f32>, near: f32) -> bool {
    let turned = vec3<f32>(dot(x.xyz, start), dot(y.xyz, start), dot(z.xyz, start));
    let o = turned + vec3<f32>(x.w, y.w, z.w);
    let d = vec3<f32>(dot(x.xyz, way), dot(y.xyz, way), dot(z.xyz, way));
    let least = 1.0 - min(ON_ROUND + 4e-6 * greatest(turned), near * sqrt(dot(d, d)));
    return dot(o, d) >= 0.0 && dot(o, o) >= least * least;
}

// A sphere's middle and radius.
fn stops_ball(start: vec3<f32>, way: vec3<f32>, far: f32, ball: vec4<f32>) -> bool {
    let to = ball.xyz - start;
    let along = dot(to, way);
    let off = to - way * along;
    let left = ball.w * ball.w - dot(off, off);
    let half = sqrt(max(left, 0.0));
    return left > 0.0 && along + half > 0.0 && along - half < far;
}

// The rows of the matrix that makes an ellipsoid the unit sphere.
fn stops_ellipsoid(start: vec3<f32>, way: vec3<f32>, far: f32, x: vec4<f32>, y: vec4<f32>, z: vec4<f32>) -> bool {
    let o = vec3<f32>(dot(x.xyz, start) + x.w, dot(y.xyz, start) + y.w, dot(z.xyz, start) + z.w);
    let d = vec3<f32>(dot(x.xyz, way), dot(y.xyz, way), dot(z.xyz, way));
    let a = dot(d, d);
    let b = dot(o, d);
    let disc = b * b - a * (dot(o, o) - 1.0);
    let root = sqrt(max(disc, 0.0));
    return disc > 0.0 && root - b > 0.0 && -b - root < far * a;
}

// How far beside a facet of a curved surface, in parts of it, a ray still meets it; and beside one of a flat surface, as far as devices round.
const BESIDE: f32 = 1e-5;
const BESIDE_FLAT: f32 = 1e-6;

// A triangle as a ray meets its plane.
struct Crossed {
    // On which side of its edges the ray passes, in parts of `size`, twice its area across the ray.
    parts: vec3<f32>,
    size: f32,
    // How far along the ray.
    t: f32,
}

// How a ray meets the plane of a triangle, given by its corners: these are taken as they are seen along the ray, and on which side of an edge that passes
// depends on the ends of the edge alone (Woop, Benthin and Wald 2013).
fn meet_plane(start: vec3<f32>, way: vec3<f32>, p: vec3<f32>, q: vec3<f32>, r: vec3<f32>) -> Crossed {
    // Two directions across the ray (Duff et al. 2017).
    let side = select(1.0, -1.0, way.z < 0.0);
    let s = -1.0 / (side + way.z);
    let t = way.x * way.y * s;
    let right = vec3<f32>(1.0 + side * way.x * way.x * s, side * t, -side * way.x);
    let up = vec3<f32>(t, side + way.y * way.y * s, -way.y);
    let a = vec3<f32>(dot(p - start, right), dot(p - start, up), dot(p - start, way));
    let b = vec3<f32>(dot(q - start, right), dot(q - start, up), dot(q - start, way));
    let c = vec3<f32>(dot(r - start, right), dot(r - start, up), dot(r - start, way));
    let parts = vec3<f32>(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    let area = parts.x + parts.y + parts.z;
    let size = abs(area);
    let turned = select(parts, -parts, area < 0.0);
    let w = turned / select(1.0, size, size > 0.0);
    return Crossed(turned, size, a.z + w.y * (b.z - a.z) + w.z * (c.z - a.z));
}

// How far along a ray a triangle is met; -1 where it is not.
fn meet_triangle(start: vec3<f32>, way: vec3<f32>, p: vec3<f32>, q: vec3<f32>, r: vec3<f32>, is_flat: bool) -> f32 {
    let met = meet_plane(start, way, p, q, r);
    let least = -select(BESIDE, BESIDE_FLAT, is_flat) * met.size;
    return select(-1.0, met.t, met.size > 0.0 && all(met.parts >= vec3<f32>(least)));
}

// A facet of a curved surface stands off it: its own neighbourhood is not in its shadow. 0 of what is flat.
fn facet_room(head: vec4<u32>, is_own: bool) -> f32 {
    return bitcast<f32>(head.z) * select(0.5, 2.0, is_own);
}

// How near the start a triangle does not count: of the surface's own where it may have been shaded, of others where rounding may put it,
// and as far as it stands off its own curved surface.
fn near_start(head: vec4<u32>, is_own: bool, ab: vec3<f32>, ac: vec3<f32>, start: vec3<f32>, near: vec2<f32>) -> f32 {
    let room = facet_room(head, is_own);
    let size = sqrt(max(dot(ab, ab), dot(ac, ac)));
    let far = max(max(abs(start.x), abs(start.y)), abs(start.z));
    return max(select(min(near.x, 1e-5 * size + 4e-6 * far), near.y, is_own), room);
}

// The same of a triangle of any kind: of what is displaced only rounding leaves room.
fn near_triangle(head: vec4<u32>, is_own: bool, ab: vec3<f32>, ac: vec3<f32>, start: vec3<f32>, near: vec2<f32>) -> f32 {
    if head.x == 4u {
        return bitcast<f32>(head.z);
    }
    return near_start(head, is_own, ab, ac, start, near);
}

fn stops(start: vec3<f32>, way: vec3<f32>, far: f32, at: u32, own: u32, near: vec2<f32>) -> bool {
    let head = world[at];
    let is_own = head.y == own;
    // Neither spheres nor what is flat shadow themselves, and what is translucent stops nothing by itself.
    if (is_own && head.x < 3u) || head.w != 0u {
        return false;
    }
    let a = world_row(at + 1u);
    if head.x == 0u {
        return stops_ball(start, way, far, a) && !leaves_ball(start, way, a, near.x);
    }
    let b = world_row(at + 2u);
    let c = world_row(at + 3u);
    if head.x == 1u {
        return stops_ellipsoid(start, way, far, a, b, c) && !leaves_ellipsoid(start, way, a, b, c, near.x);
    }
    let t = meet_triangle(start, way, a.xyz, b.xyz, c.xyz, head.x == 2u);
    return t < far && t > near_triangle(head, is_own, b.xyz - a.xyz, c.xyz - a.xyz, start, near);
}

// Whether a ray meets a box within a length.
fn meets_box(start: vec3<f32>, inverse: vec3<f32>, far: f32, low: vec3<f32>, high: vec3<f32>) -> bool {
    let t0 = (low - start) * inverse;
    let t1 = (high - start) * inverse;
    let near = min(t0, t1);
    let last = max(t0, t1);
    return max(max(max(near.x, near.y), near.z), 0.0) <= min(min(min(last.x, last.y), last.z), far);
}

// Whether anything stands between two points; what a lamp lies in, as in a ceiling, does not.
fn is_blocked(start: vec3<f32>, lamp: vec3<f32>) -> bool {
    let end = start + (lamp - start) * 0.9999;
    let far = sqrt(dot(end - start, end - start));
    if !(far > 0.0) {
        return false;
    }
    let way = (end - start) / far;
    let inverse = inverse_of(way);
    let own = own_primitive();
    let near = near_of_start();
    let head = world[0];
    let n_nodes = head.z;
    let first = head.y;
    var k = 0u;
    var blocked = false;
    while k < n_nodes && !blocked {
        let at = head.x + 2u * k;
        let low = world[at];
        let high = world[at + 1u];
        if !meets_box(start, inverse, far, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz)) {
            k = low.w;
            continue;
        }
        k += 1u;
        let last = (high.w >> 3u) + (high.w & 7u);
        for (var i = high.w >> 3u; i < last && !blocked; i += 1u) {
            blocked = stops(start, way, far, first + 4u * i, own, near);
        }
    }
    return blocked;
}

// The nearer of the roots of a t² + 2 b t + c that is beyond a number; negative if none is.
fn root(a: f32, b: f32, c: f32, near: f32) -> f32 {
    let disc = b * b - a * c;
    let half = sqrt(max(disc, 0.0));
    let first = (-b - half) / a;
    let second = (-b + half) / a;
    return select(-1.0, select(select(-1.0, second, second > near), first, first > near), disc > 0.0);
}

// How far along a ray from a surface an occluder is met, beyond `least`; negative if it is not. `near` says how near the start a surface does
// not count, others and its own.
fn distance_beyond(start: vec3<f32>, way: vec3<f32>, at: u32, own: u32, near: vec2<f32>, least: f32) -> f32 {
    let head = world[at];
    let is_own = head.y == own;
    // Of a displaced sphere nobody knows where it was met, and what is flat does not meet itself.
    if is_own && (head.x == 2u || (head.x < 2u && near.y > near.x)) {
        return -1.0;
    }
    let a = world_row(at + 1u);
    if head.x == 0u {
        if !is_own && leaves_ball(start, way, a, near.x) {
            return -1.0;
        }
        let o = start - a.xyz;
        let room = select(0.0, min(near.y, 0.5 * a.w), is_own);
        return root(1.0, dot(o, way), dot(o, o) - a.w * a.w, max(room, least));
    }
    let b = world_row(at + 2u);
    let c = world_row(at + 3u);
    if head.x == 1u {
        if !is_own && leaves_ellipsoid(start, way, a, b, c, near.x) {
            return -1.0;
        }
        let o = vec3<f32>(dot(a.xyz, start) + a.w, dot(b.xyz, start) + b.w, dot(c.xyz, start) + c.w);
        let d = vec3<f32>(dot(a.xyz, way), dot(b.xyz, way), dot(c.xyz, way));
        return root(dot(d, d), dot(o, d), dot(o, o) - 1.0, max(select(0.0, near.y, is_own), least));
    }
    let t = meet_triangle(start, way, a.xyz, b.xyz, c.xyz, head.x == 2u);
    return select(-1.0, t, t > max(near_triangle(head, is_own, b.xyz - a.xyz, c.xyz - a.xyz, start, near), least));
}

// How far along a ray anything is met within a length, negative if nothing is. `near` says how near the start a surface does not count.
fn nearest_within(start: vec3<f32>, way: vec3<f32>, length: f32, near: vec2<f32>) -> f32 {
    let inverse = inverse_of(way);
    let own = own_primitive();
    let head = world[0];
    var far = length;
    var k = 0u;
    while k < head.z {
        let at = head.x + 2u * k;
        let low = world[at];
        let high = world[at + 1u];
        if !meets_box(start, inverse, far, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz)) {
            k = low.w;
            continue;
        }
        k += 1u;
        let last = (high.w >> 3u) + (high.w & 7u);
        for (var i = high.w >> 3u; i < last; i += 1u) {
            let t = distance_beyond(start, way, head.y + 4u * i, own, near, 0.0);
            far = select(far, t, t >= 0.0 && t < far);
        }
    }
    return select(far, -1.0, far >= length);
}

// How far along a ray from the surface that is shaded anything is met; negative if nothing is.
fn nearest(place: vec3<f32>, way: vec3<f32>) -> f32 {
    let near = near_of_start();
    let flat = vec3<f32>(values[work.own + 4u], values[work.own + 5u], values[work.own + 6u]);
    var start = place;
    if any(flat != vec3<f32>()) {
        // From a flat surface a ray is lifted off a little, and begun a little earlier, unless it would be lifted over what it meets first.
        let off = 0.05 * near.x;
        let along = dot(flat, way);
        let first = nearest_within(place, way, off * (2.0 - abs(along)) / max(abs(along), 0.05), near);
        if first >= 0.0 {
            return first;
        }
        start = place + (2.0 * flat * select(1.0, -1.0, along < 0.0) - way) * off;
    }
    let far = nearest_within(start, way, 1e30, near);
    // From the place itself, not from where the ray starts beside it.
    return select(max(far + dot(start - place, way), 0.0), -1.0, far < 0.0);
}
