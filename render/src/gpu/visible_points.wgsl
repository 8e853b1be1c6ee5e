// The points that samples see: those whose colours they need.
// in   visible        [n_samples]        ids of what is visible
// in   micropolygons  [n_micropolygons]  first point, points of a row, 1 if smooth and 2 if matte, 0
// out  wanted         [n_points / 32]    a bit a point; none so far
// in   params         [1]                count of samples
// Twin: cpu/deferred.rs
#import want

@group(0) @binding(0) var<storage, read> visible: array<u32>;
@group(0) @binding(1) var<storage, read> micropolygons: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> wanted: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k >= params[0] || visible[k] == 0xffffffffu {
        return;
    }
    let id = visible[k];
    let m = micropolygons[id >> 1u];
    if (m.z & 2u) != 0u {
        return;
    }
    want_corners(id, m);
}
