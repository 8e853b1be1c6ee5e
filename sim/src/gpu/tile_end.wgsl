// The impulses of the contacts are those of the visits of each tile, a workgroup for each tile.
// in   swept       [n_tiles]     of `tile_visits`
// in   contact_of  [n_pairs]     of `tile_visits`
// in   impulses    [n_pairs]     of the visits: N s, world
// in   round_start [10]          first tile of each round
// out  gamma       [n_contacts]  N s, world
// in   params      [3]           the index of this dispatch and the number of dispatches; number of rounds
@group(0) @binding(0) var<storage, read> swept: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> contact_of: array<u32>;
@group(0) @binding(2) var<storage, read> impulses: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> round_start: array<u32>;
@group(0) @binding(4) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var tile = group.x * params[1] + params[0]; tile < round_start[params[2]]; tile += groups.x * params[1]) {
        let first = swept[tile].x;
        for (var i = first + thread; i < first + swept[tile].y; i += 256u) {
            gamma[contact_of[i]] = impulses[i];
        }
    }
}
