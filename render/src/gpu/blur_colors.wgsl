// The colours of samples that see something that moves or is out of focus and has no colour yet.
// in    colors   [n_points]   colours of points
// inout visible  [n_samples]  ids of what is visible; then none
// out   color    [n_samples]  colour and coverage
#import blur
#import mixed

@group(0) @binding(6) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> visible: array<u32>;
@group(0) @binding(8) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> params: array<u32>;

fn smooth_color(k: u32, m: vec4<u32>, is_second: bool) -> vec4<f32> {
    let n = params[4] * params[5];
    let pixel = vec2<u32>(k / n % params[2], k / n / params[2]);
    let moment = moments[(1024u + in_pattern(pixel)) * n + k % n];
    let grid = tracks[m.w];
    var key = 0u;
    for (var next = 1u; next < tracks[m.w + 1u].x; next += 1u) {
        if moment.x >= bitcast<f32>(tracks[grid.w + next].x) {
            key = next;
        }
    }
    let met = meet_at(track_of(m, key, bitcast<vec4<f32>>(tracks[grid.w + key])), place_of(pixel, k % n), moment);
    return mixed(m, is_second, met.weights.y, met.weights.z);
}
