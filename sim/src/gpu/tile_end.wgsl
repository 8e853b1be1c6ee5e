// The impulses of the visits of each tile are those of its contacts, a workgroup for each tile.
// in   tiles       [n_tiles]     of `tile_order`
// in   order       [n_pairs]     of `tile_order`
// in   place       [n_pairs + 1] number of contacts of the pairs before each pair
// in   impulses    [n_pairs]     of the visits: N s, world
// in   round_start [10]          first tile of each round
// out  gamma       [n_contacts]  N s, world
// in   params      [3]           the index of this dispatch and the number of dispatches; number of rounds
@group(0) @binding(0) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> impulses: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> round_start: array<u32>;
@group(0) @binding(5) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var tile = group.x * params[1] + params[0]; tile < round_start[params[2]]; tile += groups.x * params[1]) {
        let first = tiles[tile].x;
        for (var i = thread; i < tiles[tile].y; i += 256u) {
            let pair = first + (order[first + i].x & 0xffffu);
            if place[pair + 1u] > place[pair] {
                gamma[place[pair]] = impulses[first + i];
            }
        }
    }
}
