// Workgroups of indirect dispatches over the blocks of each level, of a count on the device.
// in   count  [1]         n
// out  args   [n_levels]  x, y, z and a pad
// in   params [2]         values of a block, n_levels
@group(0) @binding(0) var<storage, read> count: array<u32>;
@group(0) @binding(1) var<storage, read_write> args: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    var n = count[0];
    for (var level = 0u; level < params[1]; level++) {
        n = n / params[0] + select(0u, 1u, n % params[0] != 0u);
        args[level] = vec4(min(n, 65535u), n / 65535u + select(0u, 1u, n % 65535u != 0u), 1u, 0u);
    }
}
