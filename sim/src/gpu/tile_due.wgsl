// The pairs that are to be put into tiles: all where they were found in this step, else none, and the tiles stay.
// in    spheres  [1]  not zero if the pairs were found in this step
// in    n_pairs  [1]
// out   n_due    [1]  n_pairs or 0
// inout n_tiles  [1]  0 where there are no pairs any more
// inout n_big    [1]
@group(0) @binding(0) var<storage, read> spheres: array<u32>;
@group(0) @binding(1) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(2) var<storage, read_write> n_due: array<u32>;
@group(0) @binding(3) var<storage, read_write> n_tiles: array<u32>;
@group(0) @binding(4) var<storage, read_write> n_big: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let is_due = spheres[0] != 0u;
    n_due[0] = select(0u, n_pairs[0], is_due);
    if is_due && n_pairs[0] == 0u {
        n_tiles[0] = 0u;
        n_big[0] = 0u;
    }
}
