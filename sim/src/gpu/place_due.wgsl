// The number of places of contact points: one for each pair, and the end. No points are kept yet.
// out  place     [n_pairs + 1]  zero at the end
// out  n_places  [1]            n_pairs + 1
// in   count     [1]            n_pairs
// out  n_kept    [1]

@group(0) @binding(0) var<storage, read_write> place: array<u32>;
@group(0) @binding(1) var<storage, read_write> n_places: array<u32>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read_write> n_kept: array<u32>;

@compute @workgroup_size(1)
fn main() {
    place[count[0]] = 0u;
    n_places[0] = count[0] + 1u;
    n_kept[0] = 0u;
}
