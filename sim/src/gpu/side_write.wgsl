// The sides of the contacts of each body, in the order of the contacts.
// in   pair_side   [2 n_pairs]     sorted by body: twice the pair, and one more for B
// in   pair_start  [n_bodies]      first of these of each body, and the end
// in   place       [n_pairs + 1]   number of contacts of the pairs before each pair
// in   number      [n_bodies + 1]  number of sides of the bodies before each body, and of all
// out  side        [2 n_contacts]  twice the contact, and one more for B
// out  side_start  [n_bodies]      first side of each body, and the end
#import sphere

@group(0) @binding(0) var<storage, read> pair_side: array<u32>;
@group(0) @binding(1) var<storage, read> pair_start: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> number: array<u32>;
@group(0) @binding(4) var<storage, read_write> side: array<u32>;
@group(0) @binding(5) var<storage, read_write> side_start: array<vec2<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b >= arrayLength(&pair_start) {
        return;
    }
    let end = number[b + 1u];
    var at = number[b];
    side_start[b] = vec2(at, end);
    for (var i = pair_start[b].x; i < pair_start[b].y && at < end; i++) {
        let pair = pair_side[i] / 2u;
        for (var k = place[pair]; k < place[pair + 1u]; k++) {
            side[at] = 2u * k + (pair_side[i] & 1u);
            at++;
        }
    }
}
