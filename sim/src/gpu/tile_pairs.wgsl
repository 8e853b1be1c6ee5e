// The pairs in the order of their tiles, and where tiles begin.
// in   pairs   [n_pairs]
// in   key     [n_pairs]  sorted
// in   id      [n_pairs]  the pair
// out  sorted  [n_pairs]
// out  flag    [n_pairs]  1 for the first pair of a tile, else 0
// in   count   [1]        n_pairs if they are to be put into tiles, else 0
#import sphere

@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> key: array<u32>;
@group(0) @binding(2) var<storage, read> id: array<u32>;
@group(0) @binding(3) var<storage, read_write> sorted: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> flag: array<u32>;
@group(0) @binding(5) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    sorted[k] = pairs[id[k]];
    flag[k] = select(0u, 1u, k == 0u || key[max(k, 1u) - 1u] != key[k]);
}
