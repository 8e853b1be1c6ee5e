// Gauss–Seidel: whether iterations go on beyond those of the settings, since a gap still closes too fast or the residual is too great.
// inout fastest  [1]   as bits, m/s
// inout scalars  [1]
// inout work     [2]   workgroups of the joints and of `closing`
// in    params   [4]   as bits: the speed, m/s, and the residual, m/s; the most iterations, over those of the settings; whether a pass stands for two
// Twin: cpu/solve/sweeps.rs
#import scalars

@group(0) @binding(0) var<storage, read_write> fastest: array<u32>;
@group(0) @binding(1) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    if work[1].x == 0u {
        return;
    }
    let s = scalars[0];
    let is_enough = bitcast<f32>(fastest[0]) <= bitcast<f32>(params[0]) && s.residual <= bitcast<f32>(params[1]);
    fastest[0] = 0u;
    work[1] = vec4(0u, 0u, 1u, 0u);
    // Beyond those of the settings a pass counts as one iteration, of which the host submits no more.
    if is_enough || s.trials >= params[2] * s.limit * (1u + params[3]) {
        scalars[0].goes_on = 0u;
        work[0] = vec4(0u, 0u, 1u, 0u);
    }
}
