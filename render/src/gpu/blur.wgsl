// Micropolygons that move or are out of focus, and their samples, each at its moment from its place on the lens: as `sampling` has it for
// what stands still.
// in   points          [n_points × moments]  raster x and y, pixels, and depth; of a grid, all at its first moment, then at the next
// in   micropolygons   [n_micropolygons]     first point, points of a row, flags, grid
// in   offsets         [32 × 32 × samples]   places of samples in their pixels, which repeat
// in   moments         [2 × 32 × 32 × n]     of each pixel and stratum: time, place on the lens, number of the sample; then the same by the
//                                            numbers of samples
// in   strata          [3 × strata]          least and greatest time, place on the lens along x, and along y, of a stratum; 0
// in   tracks          [n_tracks]            of a grid: first point, first point at its first moment, points, first key; then count of keys,
//                                            whose rows are the times from and until which a key holds, when it begins and one over its length
// in   params          [13]                  first pixel's column and row; width and height; strata along x and y; 0; the first micropolygon
//                                            and their count; 1 if there is a lens; its reach, one over the depth that is sharp, and the least
//                                            depth, as bits
// Twin: cpu/blur/quad.rs, moving.rs, lens.rs
#import exact

@group(0) @binding(0) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> micropolygons: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> offsets: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> moments: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> strata: array<vec2<f32>>;
@group(0) @binding(5) var<storage, read> tracks: array<vec4<u32>>;

// Strata of time that the processor tests together: its box is that of all of them.
const GROUP: u32 = 8u;

fn nothing() -> u32 {
    return params[6];
}

fn has_lens() -> bool {
    return params[9] == 1u;
}

// A micropolygon that moves straight: each number of its corners is one at time 0 and one a unit of time.
struct Track {
    x0: vec4<f32>,
    x1: vec4<f32>,
    y0: vec4<f32>,
    y1: vec4<f32>,
    z0: vec4<f32>,
    z1: vec4<f32>,
    // How far the lens spreads each corner.
    s0: vec4<f32>,
    s1: vec4<f32>,
    // Least and greatest x and y of all corners at time 0, then a unit of time.
    low0: vec2<f32>,
    low1: vec2<f32>,
    high0: vec2<f32>,
    high1: vec2<f32>,
    spreads: vec2<f32>,
    slack: f32,
    // The sign of the area of triangles that are there, 0 if both are.
    side: f32,
}

fn rounded4(v: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(rounded(v.x), rounded(v.y), rounded(v.z), rounded(v.w));
}

fn rounded2(v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(rounded(v.x), rounded(v.y));
}

// How far the lens spreads a point at a depth, pixels.
fn confusion(z: f32) -> f32 {
    let near = bitcast<f32>(params[12]);
    return bitcast<f32>(params[10]) * rounded(bitcast<f32>(params[11]) - quotient(1.0, max(z, near)));
}

fn confusions(z: vec4<f32>) -> vec4<f32> {
    return rounded4(vec4<f32>(confusion(z.x), confusion(z.y), confusion(z.z), confusion(z.w)));
}

fn least4(v: vec4<f32>) -> f32 {
    return min(min(v.x, v.y), min(v.z, v.w));
}

fn greatest4(v: vec4<f32>) -> f32 {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// The corners of a micropolygon at a moment, by component.
fn corners(first: u32, nu: u32) -> mat3x4<f32> {
    let a = points[first];
    let b = points[first + 1u];
    let c = points[first + nu + 1u];
    let d = points[first + nu];
    return mat3x4<f32>(vec4<f32>(a.x, b.x, c.x, d.x), vec4<f32>(a.y, b.y, c.y, d.y), vec4<f32>(a.z, b.z, c.z, d.z));
}

// A micropolygon from a moment on.
fn track_of(m: vec4<u32>, moment: u32, key: vec4<f32>) -> Track {
    let grid = tracks[m.w];
    let first = grid.y + (m.x - grid.x) + moment * grid.z;
    let a = corners(first, m.y);
    var b = a;
    if key.w != 0.0 {
        b = corners(first + grid.z, m.y);
    }
    var t: Track;
    t.side = f32((m.z >> 2u) & 1u) - f32((m.z >> 3u) & 1u);
    t.x1 = rounded4((b[0] - a[0]) * key.w);
    t.y1 = rounded4((b[1] - a[1]) * key.w);
    t.z1 = rounded4((b[2] - a[2]) * key.w);
    t.x0 = a[0] - rounded4(t.x1 * key.z);
    t.y0 = a[1] - rounded4(t.y1 * key.z);
    t.z0 = a[2] - rounded4(t.z1 * key.z);
    if has_lens() {
        let from_first = confusions(a[2]);
        let from_next = confusions(b[2]);
        t.s1 = rounded4((from_next - from_first) * key.w);
        t.s0 = from_first - rounded4(t.s1 * key.z);
        t.spreads = vec2<f32>(
            min(least4(from_first), least4(from_next)),
            max(greatest4(from_first), greatest4(from_next)),
        );
    }
    let low = vec4<f32>(least4(a[0]), least4(a[1]), least4(b[0]), least4(b[1]));
    let high = vec4<f32>(greatest4(a[0]), greatest4(a[1]), greatest4(b[0]), greatest4(b[1]));
    t.low1 = rounded2((low.zw - low.xy) * key.w);
    t.low0 = low.xy - rounded2(t.low1 * key.z);
    t.high1 = rounded2((high.zw - high.xy) * key.w);
    t.high0 = high.xy - rounded2(t.high1 * key.z);
    t.slack = -EDGE * max(rounded(t.spreads.y - t.spreads.x) + 2.0 * EDGE, greatest4(high - low));
    return t;
}

// Least x and y, and greatest, over times and places on the lens.
fn bound_of(t: Track, times: vec2<f32>, lens_x: vec2<f32>, lens_y: vec2<f32>) -> vec4<f32> {
    let low = min(t.low0 + rounded2(t.low1 * times.x), t.low0 + rounded2(t.low1 * times.y));
    let high = max(t.high0 + rounded2(t.high1 * times.x), t.high0 + rounded2(t.high1 * times.y));
    let x = rounded4(vec4<f32>(lens_x.x * t.spreads, lens_x.y * t.spreads));
    let y = rounded4(vec4<f32>(lens_y.x * t.spreads, lens_y.y * t.spreads));
    let least = rounded2(low + vec2<f32>(least4(x), least4(y)));
    let most = rounded2(high + vec2<f32>(greatest4(x), greatest4(y)));
    return vec4<f32>(least - EDGE, most + EDGE);
}

fn cross2(p: vec2<f32>, q: vec2<f32>) -> f32 {
    return rounded(p.x * q.y) - rounded(p.y * q.x);
}

// Whether the parts of a triangle's area are of its sign, or but little of the other, and it is there.
fn is_inside(parts: vec3<f32>, t: Track) -> bool {
    let area = rounded(parts.x + parts.y) + parts.z;
    let turned = bitcast<vec3<f32>>(bitcast<vec3<u32>>(parts) ^ vec3<u32>(bitcast<u32>(area) & 0x80000000u));
    return all(turned >= vec3<f32>(t.slack)) && area != 0.0 && t.side * area >= 0.0;
}

// Where a sample meets a micropolygon; and what is known of a layer there beside its id.
struct Met {
    is_met: bool,
    is_second: bool,
    weights: vec3<f32>,
    z: f32,
    flags: u32,
}

// The corners of a micropolygon at a moment, from a sample on.
fn corners_at(t: Track, place: vec2<f32>, moment: vec4<f32>) -> array<vec2<f32>, 4> {
    var x = rounded4(t.x0 + rounded4(t.x1 * moment.x)) - place.x;
    var y = rounded4(t.y0 + rounded4(t.y1 * moment.x)) - place.y;
    if has_lens() {
        let spread = rounded4(t.s0 + rounded4(t.s1 * moment.x));
        x = rounded4(x) + rounded4(moment.y * spread);
        y = rounded4(y) + rounded4(moment.z * spread);
    }
    return array<vec2<f32>, 4>(vec2<f32>(x.x, y.x), vec2<f32>(x.y, y.y), vec2<f32>(x.z, y.z), vec2<f32>(x.w, y.w));
}

// Twice the areas over against the corners of a triangle.
fn parts_of(at: array<vec2<f32>, 4>, is_second: bool) -> vec3<f32> {
    let diagonal = cross2(at[0], at[2]);
    if is_second {
        return vec3<f32>(cross2(at[2], at[3]), cross2(at[3], at[0]), diagonal);
    }
    return vec3<f32>(cross2(at[1], at[2]), -diagonal, cross2(at[0], at[1]));
}

// Where a sample meets a triangle.
fn met_in(t: Track, moment: vec4<f32>, at: array<vec2<f32>, 4>, is_second: bool) -> Met {
    let parts = parts_of(at, is_second);
    let area = rounded(parts.x + parts.y) + parts.z;
    var w = vec3<f32>(quotient(parts.x, area), quotient(parts.y, area), quotient(parts.z, area));
    if !has_lens() || any(w < vec3<f32>()) {
        w = max(w, vec3<f32>());
        let sum = rounded(w.x + w.y) + w.z;
        w = vec3<f32>(quotient(w.x, sum), quotient(w.y, sum), quotient(w.z, sum));
    }
    let z = t.z0 + rounded4(t.z1 * moment.x);
    let others = select(z.yz, z.zw, is_second);
    return Met(true, is_second, w, rounded(rounded(z.x * w.x) + rounded(others.x * w.y)) + rounded(others.y * w.z), 0u);
}

fn meet_at(t: Track, place: vec2<f32>, moment: vec4<f32>) -> Met {
    let at = corners_at(t, place, moment);
    let in_first = is_inside(parts_of(at, false), t);
    if !in_first && !is_inside(parts_of(at, true), t) {
        return Met();
    }
    return met_in(t, moment, at, !in_first);
}

// A micropolygon from the moment on that holds at a time.
fn track_at(m: vec4<u32>, time: f32) -> Track {
    let grid = tracks[m.w];
    var key = 0u;
    for (var next = 1u; next < tracks[m.w + 1u].x; next += 1u) {
        if time >= bitcast<f32>(tracks[grid.w + next].x) {
            key = next;
        }
    }
    return track_of(m, key, bitcast<vec4<f32>>(tracks[grid.w + key]));
}

fn corner_of_image() -> vec2<i32> {
    return vec2<i32>(bitcast<i32>(params[0]), bitcast<i32>(params[1]));
}

// The index of a pixel in the patterns, which repeat.
fn in_pattern(pixel: vec2<u32>) -> u32 {
    let at = (vec2<u32>(corner_of_image()) + pixel) & vec2<u32>(31u);
    return at.y * 32u + at.x;
}

fn place_of(pixel: vec2<u32>, sample: u32) -> vec2<f32> {
    let n = vec2<u32>(params[4], params[5]);
    let at = (vec2<u32>(corner_of_image()) + pixel) & vec2<u32>(31u);
    let k = (at.y * n.y + sample / n.x) * 32u * n.x + at.x * n.x + sample % n.x;
    return vec2<f32>(corner_of_image() + vec2<i32>(pixel)) + offsets[k];
}
