// Contact manifolds: the faces by which two convex shapes meet are clipped against each other. The kernel has `BEYOND`, what a side is moved
// outward by before it clips, over its length.
// Twin: cpu/collide/manifold.rs
#import placed

const MAX_CORNERS: u32 = 16u;
// Bit of the feature ids of points whose reference feature was the second shape's.
const OF_SECOND: u32 = 0x8000u;

// A face (three corners and more, in order), an edge (two) or a corner (one): its first corner in `corners`, and their number.
struct Feature {
    first: u32,
    n: u32,
}

// The corners of features, each with its id: those of the first shape, of the second, and two that clipping takes by turns. They are never
// copied as a whole, which would take all registers.
var<private> corners: array<vec4<f32>, 64>;

// A feature without corners, of one of the four places.
fn no_corners(place: u32) -> Feature {
    return Feature(place * MAX_CORNERS, 0u);
}

fn push(f: ptr<function, Feature>, p: vec3<f32>, id: u32) {
    if (*f).n < MAX_CORNERS {
        corners[(*f).first + (*f).n] = vec4(p, bitcast<f32>(id));
        (*f).n += 1u;
    }
}

// Unit normal of a face; zero of what is none.
fn face_normal(f: Feature) -> vec3<f32> {
    var sum = vec3(0.0);
    let first = corners[f.first].xyz;
    for (var k = 1u; k + 1u < f.n; k++) {
        sum += cross(corners[f.first + k].xyz - first, corners[f.first + k + 1u].xyz - first);
    }
    let size = length(sum);
    return select(vec3(0.0), sum / size, size > 0.0);
}

// The face of a box that faces a direction, as the feature of a place.
fn box_face(shape: Placed, direction: vec3<f32>, place: u32) -> Feature {
    let d = direction * shape.frame;
    // The last of equal axes, as on the CPU.
    var axis = 0u;
    if abs(d.y) >= abs(d.x) {
        axis = 1u;
    }
    if abs(d.z) >= abs(d[axis]) {
        axis = 2u;
    }
    let u = (axis + 1u) % 3u;
    let v = (axis + 2u) % 3u;
    let side = select(0u, 4u, d[axis] < 0.0);
    var f = no_corners(place);
    for (var k = 0u; k < 4u; k++) {
        var p = vec3(0.0);
        p[axis] = select(shape.half[axis], -shape.half[axis], d[axis] < 0.0);
        p[u] = select(-shape.half[u], shape.half[u], k == 0u || k == 3u);
        p[v] = select(-shape.half[v], shape.half[v], k < 2u);
        push(&f, shape.position + shape.frame * p, 8u * axis + side + k + 1u);
    }
    return f;
}

// Clip `other` against the sides of `reference` (a face, or an edge by its two ends) and keep the corners within `reach` of it along the
// normal, which points from the reference to the other. Returns the number of points.
fn clip(reference: Feature, other: Feature, normal: vec3<f32>, reach: f32) -> u32 {
    var f = other;
    let n_sides = reference.n;
    var face = normal;
    if n_sides >= 3u {
        face = face_normal(reference);
    }
    face = select(face, -face, dot(face, normal) < 0.0);
    var middle = vec3(0.0);
    for (var k = 0u; k < n_sides; k++) {
        middle += corners[reference.first + k].xyz / f32(n_sides);
    }
    for (var k = 0u; k < n_sides; k++) {
        let p = corners[reference.first + k].xyz;
        let q = corners[reference.first + (k + 1u) % n_sides].xyz;
        var outward = p - q;
        if n_sides != 2u {
            outward = cross(q - p, normal);
            outward = select(outward, -outward, dot(outward, middle - p) > 0.0);
        }
        let beyond = BEYOND * dot(q - p, q - p);
        var clipped = no_corners(2u + (k & 1u));
        for (var i = 0u; i < f.n; i++) {
            let u = corners[f.first + i];
            let du = dot(u.xyz - p, outward) - beyond;
            if du <= 0.0 {
                push(&clipped, u.xyz, bitcast<u32>(u.w));
            }
            // Two points of a segment are an open path, a face's are closed.
            if i + 1u == f.n && f.n <= 2u {
                break;
            }
            let v = corners[f.first + (i + 1u) % f.n];
            let dv = dot(v.xyz - p, outward) - beyond;
            if (du <= 0.0) != (dv <= 0.0) {
                let id = (bitcast<u32>(u.w) * 53u + bitcast<u32>(v.w)) * 17u + k + 1u;
                push(&clipped, u.xyz + (v.xyz - u.xyz) * (du / (du - dv)), id);
            }
        }
        f = clipped;
    }
    return kept_points(f, corners[reference.first].xyz, face, normal, reach);
}

// Clip the features of two shapes along a normal from A to B, against that of A or that of B. Returns the number of points.
fn clip_either(a: Feature, b: Feature, normal: vec3<f32>, reach: f32, is_second: bool) -> u32 {
    var reference = a;
    var other = b;
    if is_second {
        reference = b;
        other = a;
    }
    let n = clip(reference, other, select(normal, -normal, is_second), reach);
    for (var k = 0u; k < select(0u, n, is_second); k++) {
        found[k].feature |= OF_SECOND;
    }
    return select(n, swap_shapes(select(0u, n, is_second)), is_second);
}

// The corners of what was clipped within `reach` of the plane of the reference, as points; of more than there is room for, some all around.
fn kept_points(f: Feature, first: vec3<f32>, face: vec3<f32>, normal: vec3<f32>, reach: f32) -> u32 {
    let tilt = dot(face, normal);
    // Those that are near come first.
    var n = 0u;
    for (var i = 0u; i < f.n; i++) {
        let c = corners[f.first + i];
        if dot(c.xyz - first, face) / tilt <= reach {
            corners[f.first + n] = c;
            n++;
        }
    }
    let kept = min(n, MAX_POINTS);
    for (var k = 0u; k < kept; k++) {
        let c = corners[f.first + k * n / kept];
        let gap = dot(c.xyz - first, face) / tilt;
        found[k] = Point(normal, c.xyz - normal * gap, c.xyz, gap, (bitcast<u32>(c.w) * 2654435761u) >> 18u);
    }
    return kept;
}
