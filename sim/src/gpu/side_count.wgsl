// Number of contacts of each body.
// in   pair_side   [2 n_pairs]     sorted by body: twice the pair, and one more for B
// in   pair_start  [n_bodies]      first of these of each body, and the end
// in   place       [n_pairs + 1]   number of contacts of the pairs before each pair
// in   count       [1]             n_contacts; 0 where there is no room for them
// out  number      [n_bodies + 1]  the last is zero
#import sphere

@group(0) @binding(0) var<storage, read> pair_side: array<u32>;
@group(0) @binding(1) var<storage, read> pair_start: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read_write> number: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    let n = arrayLength(&pair_start);
    if b > n {
        return;
    }
    var own = 0u;
    if b < n && count[0] > 0u {
        for (var i = pair_start[b].x; i < pair_start[b].y; i++) {
            let pair = pair_side[i] / 2u;
            own += place[pair + 1u] - place[pair];
        }
    }
    number[b] = own;
}
