// Which triangle of a micropolygon has a sample of layers that lies near one of its edges, and whether it is near a side of the grid: to the bit
// what the processor finds.
// Twin: cpu/samples/edges.rs

// Parts of `EDGE` beside a side of a grid within which a sample lies at that side.
const BAND: f32 = 3.0;

// Parts of `EDGE` inside an edge of the primitive up to which a sample lies on it.
const ON_RIM: f32 = 0.65;

// A micropolygon around a sample: its corners from the sample on, and which sides are sides of the grid, and of the primitive, a bit each: from
// its first corner to the second, to the third, to the fourth, and back; the sign of the area of triangles that are there, 0 if both are.
struct Around {
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    d: vec2<f32>,
    outer: u32,
    rims: u32,
    side: f32,
}

fn around(m: vec4<u32>, a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, d: vec2<f32>) -> Around {
    let row = grids[grid_of(m) + 1u];
    let k = m.x - row.z;
    let i = k % m.y;
    let j = k / m.y;
    let outer = u32(j == 0u) | (u32(i + 2u == m.y) << 1u) | (u32(j + 2u == grids[grid_of(m)].y / m.y) << 2u) | (u32(i == 0u) << 3u);
    // The least and the greatest u, the least and the greatest v.
    let rims = ((row.w >> 2u) & 1u) | (row.w & 2u) | ((row.w >> 1u) & 4u) | ((row.w & 1u) << 3u);
    return Around(a, b, c, d, outer, rims, f32((m.z >> 2u) & 1u) - f32((m.z >> 3u) & 1u));
}

fn area_of(p: vec2<f32>, q: vec2<f32>) -> f32 {
    return rounded(p.x * q.y) - rounded(p.y * q.x);
}

fn length_of(p: vec2<f32>, q: vec2<f32>) -> f32 {
    return rounded(abs(q.x - p.x) + abs(q.y - p.y));
}

// Whether the sample lies to the left of an edge: twice the area between them, and what counts on the edge itself.
fn is_left(area: f32, p: vec2<f32>, q: vec2<f32>) -> bool {
    return area > 0.0 || (area == 0.0 && (q.y > p.y || (q.y == p.y && q.x > p.x)));
}

// Whether the sample lies on the side of an edge where a triangle is.
fn has(p: vec2<f32>, q: vec2<f32>, area: f32, is_outer: bool, positive: bool) -> bool {
    if is_outer {
        return select(-area, area, positive) >= -rounded(EDGE * length_of(p, q));
    }
    return is_left(area, p, q) == positive;
}

// Whether the first triangle has the sample, and whether the second has.
fn insides(v: Around) -> vec2<bool> {
    let areas = vec4<f32>(area_of(v.a, v.b), area_of(v.b, v.c), area_of(v.c, v.d), area_of(v.d, v.a));
    let diagonal = area_of(v.a, v.c);
    let left = is_left(diagonal, v.a, v.c);
    let first = rounded(rounded(areas.x + areas.y) - diagonal);
    let second = rounded(rounded(areas.z + areas.w) + diagonal);
    let one = first > 0.0;
    let two = second > 0.0;
    return vec2<bool>(
        first != 0.0 && v.side * first >= 0.0 && left != one && has(v.a, v.b, areas.x, (v.outer & 1u) != 0u, one)
            && has(v.b, v.c, areas.y, (v.outer & 2u) != 0u, one),
        second != 0.0 && v.side * second >= 0.0 && left == two && has(v.c, v.d, areas.z, (v.outer & 4u) != 0u, two)
            && has(v.d, v.a, areas.w, (v.outer & 8u) != 0u, two),
    );
}

// What is known beside its id of a layer at a side from p to q; the triangle that has the sample has it to the left if `positive`.
fn side_flags(p: vec2<f32>, q: vec2<f32>, is_outer: bool, is_rim: bool, positive: bool) -> u32 {
    let band = rounded(BAND * EDGE);
    let area = area_of(p, q);
    let inside = select(-area, area, positive);
    let length = length_of(p, q);
    if !is_outer || any(min(p, q) > vec2<f32>(band)) || any(max(p, q) < vec2<f32>(-band)) || !(abs(inside) <= rounded(band * length)) {
        return 0u;
    }
    return AT_SIDE | select(0u, AT_RIM, is_rim && inside <= rounded(rounded(ON_RIM * EDGE) * length));
}

fn edge_flags(v: Around, is_second: bool) -> u32 {
    var area = rounded(rounded(area_of(v.a, v.b) + area_of(v.b, v.c)) - area_of(v.a, v.c));
    if is_second {
        area = rounded(rounded(area_of(v.c, v.d) + area_of(v.d, v.a)) + area_of(v.a, v.c));
    }
    let positive = area > 0.0;
    return side_flags(v.a, v.b, (v.outer & 1u) != 0u, (v.rims & 1u) != 0u, positive)
        | side_flags(v.b, v.c, (v.outer & 2u) != 0u, (v.rims & 2u) != 0u, positive)
        | side_flags(v.c, v.d, (v.outer & 4u) != 0u, (v.rims & 4u) != 0u, positive)
        | side_flags(v.d, v.a, (v.outer & 8u) != 0u, (v.rims & 8u) != 0u, positive);
}

// How far the depth of a triangle changes within the band, but no further than it changes at all.
fn slack_in(v: Around, is_second: bool, depths: vec4<f32>) -> f32 {
    let q = select(v.b, v.c, is_second);
    let r = select(v.c, v.d, is_second);
    let u = q - v.a;
    let w = r - v.a;
    let du = select(depths.y, depths.z, is_second) - depths.x;
    let dw = select(depths.z, depths.w, is_second) - depths.x;
    let area = abs(rounded(u.x * w.y) - rounded(w.x * u.y));
    let x = abs(rounded(rounded(du * w.y) - rounded(dw * u.y)));
    let y = abs(rounded(rounded(dw * u.x) - rounded(du * w.x)));
    let change = rounded(rounded(BAND * EDGE) * rounded(x + y));
    let range = rounded(max(max(du, dw), 0.0) - min(min(du, dw), 0.0));
    if change < rounded(range * area) {
        return quotient(change, area);
    }
    return range;
}
