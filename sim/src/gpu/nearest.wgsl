// The nearest points of two convex shapes (Gilbert, Johnson, Keerthi 1988), and the contact points of the features by which they meet.
//
// Single precision does not know the direction between cores that nearly touch. Such shapes are moved apart along an axis, the best of those
// of their frames, and the direction between them then is the next axis: along that of the least overlap it stays what it is.
// Twin: cpu/collide/convex.rs, cpu/collide/manifold.rs
#import support
#import feature
#import clip

const ROUNDS: u32 = 32u;
// Distance of cores over their size that is none, and below which their direction is found by moving them apart, by a share of their size.
const NOTHING: f32 = 1e-6;
const NEAR_BY: f32 = 3e-3;
const MOVED: f32 = 2e-2;
// The most moves, and what the separation has to grow by over the size.
const MOVES: u32 = 16u;
const GROWS: f32 = 2e-7;
// What the bounds of a distance may differ by over the size, once it is known.
const EARLY: f32 = 1e-6;
// Sine of the angle to the plane across an axis up to which a direction is across it.
const ASIDE: f32 = 1e-5;
// Cosine of the angle between an axis and a normal that may be the same, and what the separations along both may differ by over the size: the
// rounding.
const ALIGNED: f32 = 0.9995;
const SAME: f32 = 5e-7;
// The greatest ratio of the length of a step to that of the last one that is made use of.
const MOST_RATIO: f32 = 0.95;

// A vertex of the Minkowski difference A − B, with its points on both.
struct Vertex {
    w: vec3<f32>,
    a: vec3<f32>,
    b: vec3<f32>,
}

// Up to four vertices, with the weights of the point nearest to the origin. Their points on both shapes are in `corners`, where there are no
// features yet, two rows for each, and behind them those of the nearest point: they are asked for at the end alone.
var<private> simplex: array<vec3<f32>, 4>;
var<private> weight: vec4<f32>;
var<private> n_simplex: u32;

fn vertex_of(a: Placed, b: Placed, direction: vec3<f32>) -> Vertex {
    let pa = support(a, direction);
    let pb = support(b, -direction);
    return Vertex(pa - pb, pa, pb);
}

// Weights of the point of a triangle nearest to the origin (Ericson 2005, §5.1.5).
fn in_triangle(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let ab = b - a;
    let ac = c - a;
    let d1 = -dot(ab, a);
    let d2 = -dot(ac, a);
    if d1 <= 0.0 && d2 <= 0.0 {
        return vec3(1.0, 0.0, 0.0);
    }
    let d3 = -dot(ab, b);
    let d4 = -dot(ac, b);
    if d3 >= 0.0 && d4 <= d3 {
        return vec3(0.0, 1.0, 0.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return vec3(1.0 - t, t, 0.0);
    }
    let d5 = -dot(ab, c);
    let d6 = -dot(ac, c);
    if d6 >= 0.0 && d5 <= d6 {
        return vec3(0.0, 0.0, 1.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return vec3(1.0 - t, 0.0, t);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return vec3(0.0, 1.0 - t, t);
    }
    let sum = va + vb + vc;
    return select(vec3(1.0, 0.0, 0.0), vec3(va, vb, vc) / sum, sum > 0.0);
}

// Rows of the nearest point, of the last step of the axis, and of what the part that imports this one keeps there during the search: in registers
// it would be all the while.
const NEAREST: u32 = 8u;
const LAST_STEP: u32 = 10u;
const KEPT: u32 = 11u;

fn put_vertex(i: u32, v: Vertex) {
    simplex[i] = v.w;
    corners[2u * i] = vec4(v.a, 0.0);
    corners[2u * i + 1u] = vec4(v.b, 0.0);
}

// The point of the simplex nearest to the origin.
fn nearest_of_simplex() -> vec3<f32> {
    var sum = vec3(0.0);
    for (var i = 0u; i < n_simplex; i++) {
        sum += simplex[i] * weight[i];
    }
    return sum;
}

// Keep its points on both shapes.
fn keep_nearest() {
    var a = vec3(0.0);
    var b = vec3(0.0);
    for (var i = 0u; i < n_simplex; i++) {
        a += corners[2u * i].xyz * weight[i];
        b += corners[2u * i + 1u].xyz * weight[i];
    }
    corners[NEAREST] = vec4(a, 0.0);
    corners[NEAREST + 1u] = vec4(b, 0.0);
}

// Leave out the vertices without weight.
fn drop_unweighted() {
    var n = 0u;
    for (var i = 0u; i < n_simplex; i++) {
        if weight[i] > 0.0 {
            simplex[n] = simplex[i];
            corners[2u * n] = corners[2u * i];
            corners[2u * n + 1u] = corners[2u * i + 1u];
            weight[n] = weight[i];
            n++;
        }
    }
    n_simplex = n;
}

// The faces of a tetrahedron, and the vertex that is not on each.
fn face_of(i: u32) -> vec4<u32> {
    return array<vec4<u32>, 4>(vec4(0u, 1u, 2u, 3u), vec4(0u, 3u, 1u, 2u), vec4(0u, 2u, 3u, 1u), vec4(1u, 3u, 2u, 0u))[i];
}

// Reduce a tetrahedron to the face nearest to the origin; false if the origin is inside, which it is not where `is_apart` is known.
fn reduce_tetrahedron(is_apart: bool) -> bool {
    var best = 3e38;
    var weights = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let f = face_of(i);
        let p = simplex[f.x];
        let normal = cross(simplex[f.y] - p, simplex[f.z] - p);
        let here = -dot(p, normal);
        let there = dot(simplex[f.w] - p, normal);
        // The origin is beyond this face, or the tetrahedron is flat, so that round-off may hide which face that is.
        if is_apart || here * there <= 0.0 || abs(there) <= 1e-6 * length(normal) * length(simplex[f.w]) {
            let own = in_triangle(p, simplex[f.y], simplex[f.z]);
            let at = p * own.x + simplex[f.y] * own.y + simplex[f.z] * own.z;
            if dot(at, at) < best {
                best = dot(at, at);
                weights = vec4(0.0);
                weights[f.x] = own.x;
                weights[f.y] = own.y;
                weights[f.z] = own.z;
            }
        }
    }
    weight = weights;
    drop_unweighted();
    return best < 3e38;
}

// Reduce the simplex to the least one with the point nearest to the origin; false if the origin is inside, which it is not where
// `is_apart` is known.
fn reduce_simplex(is_apart: bool) -> bool {
    if n_simplex == 4u {
        return reduce_tetrahedron(is_apart);
    }
    if n_simplex == 3u {
        weight = vec4(in_triangle(simplex[0], simplex[1], simplex[2]), 0.0);
    } else if n_simplex == 2u {
        let along = simplex[1] - simplex[0];
        let size = dot(along, along);
        let t = select(0.0, clamp(-dot(simplex[0], along) / size, 0.0, 1.0), size > 0.0);
        weight = vec4(1.0 - t, t, 0.0, 0.0);
    }
    drop_unweighted();
    return true;
}

// What the search of the nearest points has found: cores apart by more than the reach, nearest points, or cores that touch.
const APART: u32 = 0u;
const KNOWN: u32 = 1u;
const TOUCHING: u32 = 2u;

// Search for the nearest points of the cores with a distance of at most `reach`, from a direction from A to B: `nearest` is that of their
// difference.
fn search(a: Placed, b: Placed, start: vec3<f32>, reach: f32, scale: f32, nearest: ptr<function, vec3<f32>>) -> u32 {
    n_simplex = 1u;
    weight = vec4(1.0, 0.0, 0.0, 0.0);
    put_vertex(0u, vertex_of(a, b, start));
    keep_nearest();
    var best = simplex[0];
    for (var k = 0u; k < ROUNDS; k++) {
        let v = best;
        let distance2 = dot(v, v);
        if distance2 <= NOTHING * NOTHING * scale * scale {
            *nearest = best;
            return TOUCHING;
        }
        let next = vertex_of(a, b, -v);
        // v·w bounds the distance from below.
        let lower = dot(v, next.w);
        if lower > 0.0 && lower * lower > distance2 * reach * reach {
            return APART;
        }
        if distance2 - lower <= 1e-6 * distance2 {
            break;
        }
        put_vertex(n_simplex, next);
        n_simplex += 1u;
        if !reduce_simplex(lower > 0.0) {
            *nearest = best;
            return TOUCHING;
        }
        let nearer = nearest_of_simplex();
        if dot(nearer, nearer) >= distance2 {
            break;
        }
        best = nearer;
        keep_nearest();
    }
    *nearest = best;
    return KNOWN;
}

// Separation of the cores along a unit direction from A to B.
fn separation(a: Placed, b: Placed, direction: vec3<f32>) -> f32 {
    return -dot(vertex_of(a, b, direction).w, direction);
}

// Whether the separation along an axis is greater than that along the best one so far, which it then becomes.
fn try_axis(a: Placed, b: Placed, axis: vec3<f32>, more: f32, best: ptr<function, vec4<f32>>) -> bool {
    let apart = separation(a, b, axis);
    if apart <= (*best).w + more {
        return false;
    }
    *best = vec4(axis, apart);
    return true;
}

// Whether what was found of capsules holds for the cylinders in their place: the cores are apart, and the direction is across the axes.
fn is_aside(a: Placed, b: Placed, at: vec3<f32>, distance: f32) -> bool {
    let of_a = select(0.0, abs(dot(at, a.frame[2])), a.kind == CYLINDER);
    let of_b = select(0.0, abs(dot(at, b.frame[2])), b.kind == CYLINDER);
    return max(of_a, of_b) <= ASIDE * distance;
}

// The nearest points, or those by which an overlap is least, in `found[0]`; false if the gap is above `reach`. `first_axis` is that of the
// part that imports this one: an axis along which cores that touch or nearly do are apart, or overlap little.
fn find_nearest(a: Placed, b: Placed, reach: f32) -> bool {
    let away = b.position - a.position;
    as_capsules = false;
    let scale = length(support(a, away) - a.position) + length(support(b, -away) - b.position)
        + radius_of(a) + radius_of(b);
    // Cylinders are taken as capsules first, whose cores are their axes. Where they meet on their sides they are the same shapes, and the direction
    // between the cores is known however near they are.
    as_capsules = !ALL_BOXES && (a.kind == CYLINDER || b.kind == CYLINDER);
    var best = vec4(away + vec3(1e-12), 0.0);
    var shift = 0.0;
    corners[LAST_STEP] = vec4(0.0);
    var at = vec3(0.0);
    for (var k = select(1u, 0u, as_capsules); k <= MOVES + 1u; k++) {
        var moved = b;
        moved.position += best.xyz * shift;
        let round = radius_of(a) + radius_of(b);
        let outcome = search(a, moved, best.xyz, select(3e38, reach + round, k < 2u), scale, &at);
        let distance = length(at);
        let next = -at / distance;
        if outcome == APART {
            return false;
        }
        if k == 0u {
            if outcome == KNOWN && distance >= NEAR_BY * scale && is_aside(a, b, at, distance) {
                best = vec4(next, distance);
                break;
            }
            as_capsules = false;
            continue;
        }
        if k > 1u {
            let before = best;
            let step = next - before.xyz;
            let last = corners[LAST_STEP].xyz;
            if outcome != KNOWN || !try_axis(a, b, next, GROWS * scale, &best) {
                // What is left of the growth is rounding: the last step leads nearer to the axis, as each has.
                if outcome == KNOWN && (k == 2u || dot(step, step) < dot(last, last)) {
                    try_axis(a, b, next, -GROWS * scale, &best);
                }
                break;
            }
            // Steps become shorter by a ratio that is known from the second on: where they lead is tried at once.
            let ratio = clamp(dot(step, last) / max(dot(last, last), 1e-30), 0.0, MOST_RATIO);
            corners[LAST_STEP] = vec4(select(step, vec3(0.0), ratio > 0.0), 0.0);
            if ratio > 0.0 {
                try_axis(a, b, normalize(next + step * (ratio / (1.0 - ratio))), 0.0, &best);
            }
        } else if outcome == KNOWN && distance >= NEAR_BY * scale {
            best = vec4(next, separation(a, b, next));
            if distance - best.w <= EARLY * scale {
                break;
            }
            // Rounding has ended the search early.
        } else {
            best = first_axis(a, b, away);
            if outcome == KNOWN {
                try_axis(a, b, next, 0.0, &best);
            }
        }
        shift = max(-best.w, 0.0) + MOVED * scale;
    }
    let of_a = radius_of(a);
    let of_b = radius_of(b);
    as_capsules = false;
    if !ALL_BOXES {
        align(a, b, of_a + of_b - radius_of(a) - radius_of(b), scale, &best);
    }
    let normal = best.xyz;
    let on_a = corners[NEAREST].xyz;
    // What the points lie beside each other by is rounding.
    let on_b = on_a + normal * (dot(corners[NEAREST + 1u].xyz - on_a, normal) - shift);
    let gap = best.w - of_a - of_b;
    found[0] = Point(normal, on_a + normal * of_a, on_b - normal * of_b, gap, 1u << 16u);
    return gap <= reach;
}

// The face of a shape that faces a direction, or the line of its side, by its outward normal; zero of what has neither.
fn facing_normal(shape: Placed, direction: vec3<f32>) -> vec3<f32> {
    let d = direction * shape.frame;
    var normal = vec3(0.0);
    if shape.kind == BOX {
        var axis = select(0u, 1u, abs(d.y) >= abs(d.x));
        axis = select(axis, 2u, abs(d.z) >= abs(d[axis]));
        normal[axis] = select(1.0, -1.0, d[axis] < 0.0);
    } else if shape.kind == HULL {
        var far = -3e38;
        for (var k = 0u; k < hull_size(shape).y; k++) {
            let own = hull_normal(shape, k);
            let here = dot(own, d);
            normal = select(normal, own, here > far);
            far = max(far, here);
        }
    } else if shape.kind == TRIANGLE || (shape.kind == CYLINDER && abs(d.z) > 0.7) || (shape.kind == CONE && d.z < -0.7) {
        normal.z = select(1.0, -1.0, d.z < 0.0 && shape.kind != TRIANGLE);
    } else if shape.kind == CYLINDER || shape.kind == CONE {
        let size = length(d.xy);
        let out = select(vec2(0.0), d.xy / size, size > 0.0);
        normal = normalize(vec3(out * 2.0 * shape.half.z, select(0.0, shape.half.x, shape.kind == CONE)));
    }
    return shape.frame * normal;
}

// Let an axis that is nearly the normal of a face or of a side that meets the other shape be that normal, if the shapes are no less apart along
// it. `more` is the radius around the cores that the separation of `best` leaves out.
fn align(a: Placed, b: Placed, more: f32, scale: f32, best: ptr<function, vec4<f32>>) {
    for (var k = 0u; k < 2u; k++) {
        var axis = facing_normal(a, (*best).xyz);
        if k == 1u {
            axis = -facing_normal(b, -(*best).xyz);
        }
        if dot(axis, (*best).xyz) < ALIGNED {
            continue;
        }
        let apart = separation(a, b, axis) + more;
        if apart >= (*best).w - SAME * scale {
            *best = vec4(axis, apart);
        }
    }
}

// The contact points of two convex shapes. Returns their count.
fn nearest_points(a: Placed, b: Placed, reach: f32) -> u32 {
    if !find_nearest(a, b, reach) {
        return 0u;
    }
    let nearest = found[0];
    let fa = feature_of(a, nearest.normal, 0u);
    let fb = feature_of(b, -nearest.normal, 1u);
    let size = min(min(a.half.x, min(a.half.y, a.half.z)), min(b.half.x, min(b.half.y, b.half.z)));
    let extent = max(max(a.half.x, max(a.half.y, a.half.z)), max(b.half.x, max(b.half.y, b.half.z)));
    if is_side(a, fa) && is_side(b, fb) {
        return with_nearest(side_points(a, b, fa, fb, nearest.normal, reach), nearest, vec2(size, extent));
    }
    return feature_points(fa, fb, nearest, reach, vec2(size, extent));
}

// Whether a shape is a cylinder or a capsule that is met at its side.
fn is_side(shape: Placed, feature: Feature) -> bool {
    return feature.n == 2u && (shape.kind == CYLINDER || shape.kind == CAPSULE);
}

// The way from the axis of a shape to a point across it, and how far along it that is; for a capsule the way from the nearest point of the axis.
fn from_axis(shape: Placed, point: vec3<f32>) -> vec4<f32> {
    let offset = point - shape.position;
    let at = dot(shape.frame[2], offset);
    let foot = select(at, clamp(at, -shape.half.z, shape.half.z), shape.kind == CAPSULE);
    return vec4(offset - shape.frame[2] * foot, at);
}

// The points of two shapes that meet side by side: at both ends of where they lie along each other, each with the gap and the normal that it
// has there. Returns their number.
// Twin: cpu/collide/sides.rs
fn side_points(a: Placed, b: Placed, fa: Feature, fb: Feature, normal: vec3<f32>, reach: f32) -> u32 {
    // Cosine between the normal of a point and that of the nearest ones, at least: axes that cross have no other points.
    const TOWARDS: f32 = 0.5;
    // How far beyond the end of a cylinder a point may be that is taken for one beside it, over its radius.
    const BEYOND: f32 = 1e-2;
    let n = clip_either(fa, fb, normal, 3e38, false);
    let along = b.frame[2];
    var kept = 0u;
    for (var k = 0u; k < n; k++) {
        let at = dot(along, found[k].on_second - b.position);
        let on_axis = b.position + along * clamp(at, -b.half.z, b.half.z);
        var out = from_axis(a, on_axis).xyz;
        if b.kind == CYLINDER {
            // Across the axis a cylinder reaches as far, along it no farther than its end.
            out -= along * dot(along, out);
        }
        let on_second = on_axis - out * (b.half.x / max(length(out), 1e-30));
        let own = from_axis(a, on_second);
        let distance = length(own.xyz);
        let gap = distance - a.half.x;
        let is_beyond = a.kind == CYLINDER && abs(own.w) > a.half.z + BEYOND * a.half.x;
        if gap <= reach && dot(own.xyz, normal) > TOWARDS * distance && !is_beyond {
            let unit = own.xyz / distance;
            found[kept] = Point(unit, on_second - unit * gap, on_second, gap, found[k].feature);
            kept++;
        }
    }
    return kept;
}

// The corners of two clipped features, and the nearest point where none of them is as near, for the least and the greatest half length of
// the shapes. Returns the number of points.
fn feature_points(fa: Feature, fb: Feature, nearest: Point, reach: f32, size: vec2<f32>) -> u32 {
    // What the points of parallel edges may lie beside each other by, over the least half length.
    const BESIDE: f32 = 1e-2;
    let n = nearest.normal;
    let of_a = abs(dot(face_normal(fa), n));
    let of_b = abs(dot(face_normal(fb), n));
    let has_face = max(of_a, of_b) > 0.5;
    var kept = 0u;
    if has_face || (fa.n == 2u && fb.n == 2u) {
        kept = clip_either(fa, fb, n, reach, has_face && of_a < of_b - 1e-6);
    }
    if !has_face && kept > 0u {
        // Edges that cross touch at their nearest points alone.
        let p = corners[fa.first].xyz;
        let side = cross(corners[fa.first + 1u].xyz - p, n);
        let across = select(vec3(0.0), normalize(side), length(side) > 0.0);
        for (var k = 0u; k < kept; k++) {
            if abs(dot(found[k].on_second - p, across)) > BESIDE * size.x {
                kept = 0u;
            }
        }
    }
    return with_nearest(kept, nearest, size);
}

// The nearest points are put after `n` others where none of these is as near. Returns the number of points.
fn with_nearest(n: u32, nearest: Point, size: vec2<f32>) -> u32 {
    // What the nearest point may be nearer than all others by, over the least half length, and over the greatest, by rounding.
    const NEAR: f32 = 1e-5;
    const ROUND: f32 = 1e-6;
    var kept = n;
    var least = 3e38;
    for (var k = 0u; k < kept; k++) {
        least = min(least, found[k].gap);
    }
    if least > nearest.gap + max(NEAR * size.x, ROUND * size.y) {
        kept = min(kept, MAX_POINTS - 1u);
        found[kept] = nearest;
        kept += 1u;
    }
    return kept;
}
