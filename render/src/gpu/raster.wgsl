// The samples of a part of the image, and the micropolygons that may be visible there.
// in   points          [n_points]          raster x and y, pixels, and depth
// in   micropolygons   [n_micropolygons]   first point, points of a row, what it is, 0: 1 if smooth, 2 if matte, 4 if triangles of
//                                          positive area alone are there, 8 if those of negative
// in   offsets         [32 × 32 × strata]  places of samples in their pixels, which repeat
// in   params          [9]                 first pixel's column and row; width and height, pixels; strata along x and y; 0; the first
//                                          micropolygon and their count

@group(0) @binding(0) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> micropolygons: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> offsets: array<vec2<f32>>;

fn nothing() -> u32 {
    return params[6];
}

fn corner(x: u32, y: u32) -> vec2<i32> {
    return vec2<i32>(bitcast<i32>(x), bitcast<i32>(y));
}

// The place of a sample, pixels from the first pixel's corner on.
fn place(pixel: vec2<u32>, stratum: vec2<u32>) -> vec2<f32> {
    let at = (vec2<u32>(corner(params[0], params[1])) + pixel) & vec2<u32>(31u);
    let strata = vec2<u32>(params[4], params[5]);
    let k = (at.y * strata.y + stratum.y) * 32u * strata.x + at.x * strata.x + stratum.x;
    return vec2<f32>(pixel) + offsets[k];
}

// The corners of a micropolygon around it: the first, from the first pixel's corner on, and the others from the first on.
struct Quad {
    // The sign of the area of triangles that are there, 0 if both are.
    side: f32,
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

fn quad(m: vec4<u32>) -> Quad {
    let a = points[m.x].xyz;
    let b = points[m.x + 1u].xyz - a;
    let c = points[m.x + m.y + 1u].xyz - a;
    let d = points[m.x + m.y].xyz - a;
    return Quad(f32((m.z >> 2u) & 1u) - f32((m.z >> 3u) & 1u), a - vec3<f32>(vec2<f32>(corner(params[0], params[1])), 0.0), b, c, d);
}
