// The last of the sums of counts: how many layers there are.
// in   sums    [n + 1]
// out  total   [1]
// in   params  [1]  n

@group(0) @binding(0) var<storage, read> sums: array<u32>;
@group(0) @binding(1) var<storage, read_write> total: array<u32>;
@group(0) @binding(2) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    total[0] = sums[params[0]];
}
