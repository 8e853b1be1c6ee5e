// The contact points of a convex shape with a triangle of a mesh or a height field: the second of the two.
// Twin: cpu/collide/surface.rs
#import nearest
#import kinds
#import triangle

// A corner at the seam of two faces is that of one.
const BEYOND: f32 = 0.0;
// Whether all shapes are boxes, whose faces have been tried.
const ALL_BOXES: bool = false;
// Sine of the angle between a normal and that of a face from which on they differ: that between shapes that nearly touch is no better known.
const TILTED: f32 = 2e-3;
// What the shortest way out may be of that through the face, and this of the shape's width, for a shape that is beside the face.
const SHORTER: f32 = 0.1;
const DEEPER: f32 = 0.5;
// Gap over the greatest half length up to which the direction of the nearest points may be rounding.
const TRACE: f32 = 1e-5;
// Weight of a corner from which on a point is beside the others.
const WEIGHT: f32 = 1e-6;

// The corners about the origin of the pair, m.
fn corner_of(b: Placed, k: u32) -> vec3<f32> {
    return b.position + b.frame * local_corner[k];
}

// The triangle of a fixture about an origin.
fn placed_triangle(f: u32, origin: Fixed, fine: f32) -> Placed {
    let p = corner_about(f, 0u, origin) * (fine / FINE);
    let q = corner_about(f, 1u, origin) * (fine / FINE);
    let r = corner_about(f, 2u, origin) * (fine / FINE);
    let up = real_axis(fixture[f].z_axis);
    let along_edge = normalize(q - p);
    let frame = mat3x3(along_edge, cross(up, along_edge), up);
    let middle = (p + q + r) / 3.0;
    local_corner = array<vec3<f32>, 3>((p - middle) * frame, (q - middle) * frame, (r - middle) * frame);
    return Placed(TRIANGLE, vec3(0.0), middle, frame, 0u);
}

// The axis along which a shape and a triangle that touch or nearly do are farthest apart or overlap least: the best of the face's normal, the
// axes of the shape, and the cross products of these and the edges.
fn first_axis(a: Placed, b: Placed, away: vec3<f32>) -> vec4<f32> {
    var best = vec4(-b.frame[2], -3e38);
    try_axis(a, b, -b.frame[2], 0.0, &best);
    for (var i = 0u; i < 24u; i++) {
        var axis = a.frame[(i / 2u) % 3u];
        if i >= 6u {
            let k = (i - 6u) / 6u;
            axis = cross(axis, corner_of(b, (k + 1u) % 3u) - corner_of(b, k));
        }
        let size = length(axis);
        if size > 1e-6 {
            try_axis(a, b, select(axis, -axis, i % 2u == 1u) / size, 0.0, &best);
        }
    }
    return best;
}

// Weights of the point of a triangle nearest to a point.
fn weights_at(b: Placed, p: vec3<f32>) -> vec3<f32> {
    return in_triangle(corner_of(b, 0u) - p, corner_of(b, 1u) - p, corner_of(b, 2u) - p);
}

fn at_weights(b: Placed, w: vec3<f32>) -> vec3<f32> {
    return corner_of(b, 0u) * w.x + corner_of(b, 1u) * w.y + corner_of(b, 2u) * w.z;
}

// The bit of the edge or corner that weights are on; that of the face is none.
fn bit_of(w: vec3<f32>) -> u32 {
    let on = w > vec3(WEIGHT);
    if all(on) {
        return 31u;
    }
    if on.x && on.y {
        return 0u;
    }
    if on.y && on.z {
        return 1u;
    }
    if on.x && on.z {
        return 2u;
    }
    return select(select(5u, 4u, on.y), 3u, on.x);
}

// The face of a triangle as a feature.
fn triangle_face(b: Placed) -> Feature {
    var f = no_corners(1u);
    for (var k = 0u; k < 3u; k++) {
        push(&f, corner_of(b, k), k + 1u);
    }
    return f;
}

// The point of a shape that is deepest below a face, and its height over it; `height` is that of the origin.
fn deepest_of(a: Placed, face: vec3<f32>, height: f32) -> vec4<f32> {
    let p = support(a, -face) - face * radius_of(a);
    return vec4(p, dot(p, face) + height);
}

// Whether the centre of a shape that is behind a face is right under it.
fn is_under(a: Placed, b: Placed, most: f32) -> bool {
    let face = b.frame[2];
    let away = a.position - at_weights(b, weights_at(b, a.position));
    return dot(away, face) < 0.0 && length(away - face * dot(away, face)) <= 1e-6 * most;
}

// The points of a shape and a triangle with the bits of its edges and corners that count, `over` whose plane the origin is. Returns their count.
fn triangle_points(a: Placed, b: Placed, bits: u32, over: f32, reach: f32) -> u32 {
    corners[KEPT] = vec4(over, bitcast<f32>(bits), 0.0, 0.0);
    if !find_nearest(a, b, reach) {
        return 0u;
    }
    let height = corners[KEPT].x;
    let sharp = bitcast<u32>(corners[KEPT].y);
    let face = b.frame[2];
    let size = min(a.half.x, min(a.half.y, a.half.z));
    let most = max(a.half.x, max(a.half.y, a.half.z));
    var nearest = found[0];
    let deepest = deepest_of(a, face, height);
    let is_other = nearest.gap > SHORTER * deepest.w && -deepest.w > DEEPER * size;
    if nearest.gap <= 0.0 || dot(nearest.normal, face) >= 0.0 {
        // It has passed through: the way back out of the face.
        var is_apart = is_other;
        if nearest.gap > TRACE * most {
            is_apart = !is_under(a, b, most);
        }
        if deepest.w > reach || is_apart {
            return 0u;
        }
        nearest = Point(-face, deepest.xyz, deepest.xyz - face * deepest.w, deepest.w, 1u << 16u);
    }
    let bit = bit_of(weights_at(b, nearest.on_second));
    let is_convex = bit == 31u || ((sharp >> bit) & 1u) == 1u;
    let tilt = -dot(nearest.normal, face);
    let is_face = length(cross(nearest.normal, face)) <= TILTED && tilt > 0.0;
    if a.kind == ELLIPSOID {
        found[0] = nearest;
        found[0].feature = 0u;
        return select(0u, 1u, is_convex || is_face);
    }
    let is_round = a.kind == CAPSULE || a.kind == CYLINDER || a.kind == CONE;
    if !is_convex && !select(tilt > 0.99, is_face, is_round) {
        // Edges that do not stand out are no features: a contact on one is a contact on the face. What is round would feel the edge ahead of it by any
        // tilt.
        if deepest.w > reach || is_other {
            return 0u;
        }
        let on_second = at_weights(b, weights_at(b, deepest.xyz));
        nearest = Point(-face, deepest.xyz, on_second, deepest.w, 1u << 16u);
        if length(on_second - (deepest.xyz - face * deepest.w)) > 1e-5 * most {
            // The deepest point is over another triangle.
            return swap_shapes(clip(triangle_face(b), feature_of(a, -face, 0u), face, reach));
        }
    }
    return feature_points(feature_of(a, nearest.normal, 0u), triangle_face(b), nearest, reach, vec2(size));
}

// The points of a pair of a solid and a triangle, about an origin, with normals from the shape of the lower id. Returns their count.
fn points_of(pair: vec2<u32>, origin: Fixed, fine: f32, reach: f32) -> u32 {
    let f = pair.y - arrayLength(&sphere);
    let a = placed(pair.x, origin, fine);
    var n = 0u;
    if a.kind == SPHERE {
        let unit = fine / FINE;
        let radius = u32(floor(a.half.x / unit + 0.5));
        let at = touch_triangle(f, move_fixed(origin, a.position / fine), radius);
        let gap = at.w * unit;
        found[0] = Point(at.xyz, a.position + at.xyz * a.half.x, a.position + at.xyz * (a.half.x + gap), gap, 0u);
        n = select(0u, 1u, gap <= reach && is_not_behind(f, at.w, radius, reach / unit));
    } else {
        let b = placed_triangle(f, origin, fine);
        let height = real64(along(fine_difference(origin, fixture[f].position), fixture[f].z_axis)) * fine;
        let own_height = height + dot(a.position, b.frame[2]);
        n = triangle_points(at_home(a), seen_from(b, a), fixture[f].half.x.x, own_height, reach);
        // Placed again, so that it is not kept all the while: there are never more points.
        leave_home(placed(select(pair.x, 0u, n > MAX_POINTS), origin, fine), n);
    }
    if fixture[f].shape < sphere[pair.x].shape {
        return swap_shapes(n);
    }
    return n;
}
