// Two boxes, by the separating axis theorem: the axis of minimum overlap is either a face's normal (then the other box's face is clipped to
// it) or a cross product of edges (then the two edges' nearest points touch; boxes that are fast, or whose faces are hardly inclined to each
// other, have the points of these as well). Boxes that are apart, and nearest elsewhere than in front of that face or where those edges cross,
// have their nearest points.
// Twin: cpu/collide/boxes.rs
#import clip
#import nearest
#import ordered

// Of sides that clip, more than rounding: corners of faces that lie on each other keep their features from step to step.
const BEYOND: f32 = 2e-6;
// Whether all shapes are boxes, whose faces have been tried.
const ALL_BOXES: bool = true;
// The least squared sine of the angle between edges of which a cross product is taken: that of edges more parallel is not known in single
// precision, and lies between those of faces.
const PARALLEL: f32 = 1e-4;
// What a separation is more than another one, over the least half length, to be clearly greater.
const CLEARLY: f32 = 1e-3;
// The reach, over the least half length, beyond which boxes that meet at edges may meet at their faces within the step.
const FAST: f32 = 0.1;
// The overlap of faces, over the least half length, beyond which boxes that meet at edges are pushed apart by these alone.
const DEEP: f32 = 0.2;
// The cosine of the angle between the normals of edges that cross and of a face from which on slower boxes may meet at their faces, too, unless
// these edges carry already.
const FACING: f32 = 0.985;
// What the points of boxes that are apart may be farther from each other than the boxes along the axis, over the least half length.
const NEAR: f32 = 1e-3;

fn towards(axis: vec3<f32>, a: Placed, b: Placed) -> vec3<f32> {
    return select(axis, -axis, dot(axis, b.position - a.position) < 0.0);
}

fn least_of(v: vec3<f32>) -> f32 {
    return min(v.x, min(v.y, v.z));
}

// The contact points of two boxes with a gap of at most `reach`. Returns their count.
fn solid_points(first: Placed, second: Placed, reach: f32) -> u32 {
    // What compilers leave out is of other kinds.
    var a = first;
    var b = second;
    a.kind = BOX;
    b.kind = BOX;
    // B in the frame of A: its rotation, and the place of its middle.
    let r = transpose(a.frame) * b.frame;
    let middle = (b.position - a.position) * a.frame;
    let sizes = mat3x3(abs(r[0]), abs(r[1]), abs(r[2]));
    let of_a = abs(middle) - a.half - sizes * b.half;
    let of_b = abs(middle * r) - b.half - a.half * sizes;
    let size = min(least_of(a.half), least_of(b.half));
    let clearly = CLEARLY * size;
    var face = -3e38;
    var face_at = 0u;
    var greatest = -3e38;
    for (var i = 0u; i < 6u; i++) {
        let s = select(of_b[i % 3u], of_a[i % 3u], i < 3u);
        if s > reach {
            return 0u;
        }
        greatest = max(greatest, s);
        // A face of the first box is kept unless the second's is clearly better.
        if s > face + select(0.0, clearly, i >= 3u && face_at < 3u) {
            face = s;
            face_at = i;
        }
    }
    var edge = -3e38;
    var edges = vec2(0u);
    for (var i = 0u; i < 3u; i++) {
        let k = (i + 1u) % 3u;
        let l = (i + 2u) % 3u;
        for (var j = 0u; j < 3u; j++) {
            let column = r[j];
            let sine2 = column[k] * column[k] + column[l] * column[l];
            if sine2 < PARALLEL {
                continue;
            }
            let apart = abs(middle[l] * column[k] - middle[k] * column[l]);
            let reach_a = a.half[k] * sizes[j][l] + a.half[l] * sizes[j][k];
            let m = (j + 1u) % 3u;
            let n = (j + 2u) % 3u;
            let reach_b = b.half[m] * sizes[n][i] + b.half[n] * sizes[m][i];
            let s = (apart - reach_a - reach_b) / sqrt(sine2);
            if s > reach {
                return 0u;
            }
            if s > edge {
                edge = s;
                edges = vec2(i, j);
            }
        }
    }
    let is_crossing = edge > greatest + clearly;
    var point = Point();
    var has_faces = true;
    if is_crossing {
        point = edge_point(a, b, edge, edges);
        let is_facing = dot(point.normal, face_normal_of(a, b, face_at)) >= FACING;
        has_faces = reach > FAST * size || (edge > 0.0 && is_facing);
    }
    var n = 0u;
    if has_faces {
        n = face_points(a, b, face_at, reach);
    }
    // Nearest elsewhere than where the edges cross, or than in front of the face.
    var is_elsewhere = false;
    if is_crossing {
        is_elsewhere = edge > 0.0 && distance(point.on_first, point.on_second) > edge + NEAR * size;
        if !is_elsewhere {
            return with_edges(n, size, point);
        }
        corners[KEPT] = vec4(point.normal, edge);
    } else {
        is_elsewhere = face > 0.0;
        for (var k = 0u; k < n; k++) {
            is_elsewhere = is_elsewhere && found[k].gap > face + NEAR * size;
        }
        corners[KEPT] = vec4(face_normal_of(a, b, face_at), face);
    }
    if is_elsewhere {
        n = nearest_points(a, b, reach);
    }
    return n;
}

// The axis along which the boxes are farthest apart, which is known.
fn first_axis(a: Placed, b: Placed, away: vec3<f32>) -> vec4<f32> {
    return corners[KEPT];
}

// The normal of a face, of A for the first three, from A to B.
fn face_normal_of(a: Placed, b: Placed, face_at: u32) -> vec3<f32> {
    var axis = b.frame[face_at % 3u];
    if face_at < 3u {
        axis = a.frame[face_at];
    }
    return towards(axis, a, b);
}

// The points of the face of a box clipped to that of the other.
fn face_points(a: Placed, b: Placed, face_at: u32, reach: f32) -> u32 {
    let normal = face_normal_of(a, b, face_at);
    return clip_either(box_face(a, normal, 0u), box_face(b, -normal, 1u), normal, reach, face_at >= 3u);
}

// The points of faces that are not deep, and that of crossing edges.
fn with_edges(n: u32, size: f32, point: Point) -> u32 {
    var kept = 0u;
    for (var k = 0u; k < min(n, MAX_POINTS - 1u); k++) {
        found[kept] = found[k];
        kept += select(0u, 1u, found[k].gap > -DEEP * size);
    }
    found[kept] = point;
    return kept + 1u;
}

// The middle of the edge of a box that is farthest in a direction.
fn farthest_edge(shape: Placed, along: u32, direction: vec3<f32>) -> vec3<f32> {
    let local = direction * shape.frame;
    var p = select(shape.half, -shape.half, local < vec3(0.0));
    p[along] = 0.0;
    return shape.position + shape.frame * p;
}

// The contact point of two edges that cross, with the gap along their cross product.
fn edge_point(a: Placed, b: Placed, gap: f32, edges: vec2<u32>) -> Point {
    let da = a.frame[edges.x];
    let db = b.frame[edges.y];
    let normal = towards(normalize(cross(da, db)), a, b);
    let pa = farthest_edge(a, edges.x, normal);
    let pb = farthest_edge(b, edges.y, -normal);
    // Nearest points of the two lines pa + s da and pb + t db.
    let d = dot(da, db);
    let w = pb - pa;
    let across = cross(da, db);
    let det = dot(across, across);
    let s = (dot(w, da) - d * dot(w, db)) / det;
    let t = (d * dot(w, da) - dot(w, db)) / det;
    let half = vec2(a.half[edges.x], b.half[edges.y]);
    let on_first = pa + da * clamp(s, -half.x, half.x);
    let on_second = pb + db * clamp(t, -half.y, half.y);
    return Point(normal, on_first, on_second, gap, (1u << 16u) | (edges.x * 3u + edges.y));
}
