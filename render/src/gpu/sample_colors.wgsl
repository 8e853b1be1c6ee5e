// The colours of samples that see something without a colour yet: between those of the corners where it is smooth.
// in    colors   [n_points]   colours of points
// inout visible  [n_samples]  ids of what is visible; then none
// out   color    [n_samples]  colour and coverage
#import triangle
#import raster
#import mixed

@group(0) @binding(3) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> visible: array<u32>;
@group(0) @binding(5) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

fn smooth_color(k: u32, m: vec4<u32>, is_second: bool) -> vec4<f32> {
    let strata = vec2<u32>(params[4], params[5]);
    let n = strata.x * strata.y;
    let pixel = vec2<u32>(k / n % params[2], k / n / params[2]);
    let q = quad(m);
    let d = place(pixel, vec2<u32>(k % n % strata.x, k % n / strata.x)) - q.a.xy;
    if is_second {
        let p = meet(triangle(q.a.z, q.c, q.d), d);
        return mixed(m, true, p.second, p.third);
    }
    let p = meet(triangle(q.a.z, q.b, q.c), d);
    return mixed(m, false, p.second, p.third);
}
