// Gauss–Seidel with joints, which are solved behind all contacts: the residual of an iteration, and whether another follows.
// in    moved       [n_tiles]  residual terms squared, m²/s²
// in    rest        [1]        those of big tiles
// inout scalars     [1]
// inout work        [2]        workgroups of the joints and of `closing`
// in    round_start [10]       first tile of each round
// in    count       [1]        n_contacts
// in    params      [4]        as bits: tolerance (m/s); whether `closing` decides once the iterations of the settings are done; number of rounds; the
//                              most iterations for slow bodies over those of the settings, 0 for none
// Twin: cpu/solve/sweeps.rs
#import tile_decided

@group(0) @binding(0) var<storage, read> moved: array<f32>;
@group(0) @binding(1) var<storage, read> rest: array<f32>;
@group(0) @binding(2) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(3) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> round_start: array<u32>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    decide(thread, rest[0], bitcast<f32>(params[0]), params[1] == 1u, params[2], params[3]);
}
