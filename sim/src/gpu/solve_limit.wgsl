// The most iterations of the first round of a solve.
// inout scalars  [1]
// in    limit    [1]
#import scalars

@group(0) @binding(0) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(1) var<storage, read> limit: array<u32>;

@compute @workgroup_size(1)
fn main() {
    scalars[0].limit = limit[0];
}
