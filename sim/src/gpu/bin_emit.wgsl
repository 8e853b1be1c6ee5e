// The bin of each sphere.
// in    fat_aabb   [n_spheres]  m
// out   bin        [n_spheres]  index of the bin; that of an inactive body comes after all others
// out   bin_shape  [n_spheres]  the sphere
// inout levels     [2]          mask of the levels that are used
// in    count      [1]          n_spheres if pairs are to be found, else 0
// in    grid       [3]          bits of a bin's coordinates
// in    params     [2]          n_bins, and as bits 1 / unit of the scale (1/m)
// Twin: cpu/bin_emit.rs
#import sphere
#import bins

@group(0) @binding(0) var<storage, read> fat_aabb: array<Aabb>;
@group(0) @binding(1) var<storage, read_write> bin: array<u32>;
@group(0) @binding(2) var<storage, read_write> bin_shape: array<u32>;
@group(0) @binding(3) var<storage, read_write> levels: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> grid: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let s = row_of(group, thread);
    if s >= count[0] {
        return;
    }
    bin_shape[s] = s;
    let own = fat_aabb[s];
    if own.low.x > own.high.x {
        bin[s] = params[0];
        return;
    }
    let scale = bitcast<f32>(params[1]);
    let edge = (own.high - own.low).xyz * scale;
    let level = level_of(max(edge.x, max(edge.y, edge.z)));
    bin[s] = index_of(bin_of(own.low.xyz * scale, level), vec3(grid[0], grid[1], grid[2]));
    let mask = 1u << (level % 32u);
    if (atomicLoad(&levels[level / 32u]) & mask) == 0u {
        atomicOr(&levels[level / 32u], mask);
    }
}
