// Number of counters of a radix sort: one for each digit of each block.
// in   count   [1]  n
// out  places  [1]  256 x n_blocks
#import radix_block

@group(0) @binding(0) var<storage, read> count: array<u32>;
@group(0) @binding(1) var<storage, read_write> places: array<u32>;

@compute @workgroup_size(1)
fn main() {
    places[0] = DIGITS * radix_blocks(count[0]);
}
