// The points that layers need: those of all of them, since what they hide is known when they are shaded.
// in   layers         [n_layers]         key of the depth, and id
// in   micropolygons  [n_micropolygons]  first point, points of a row, flags, track
// out  wanted         [n_points / 32]    a bit a point
// in   params         [1]                count of layers
// Twin: cpu/deferred.rs
#import want
#import layer_ids

@group(0) @binding(0) var<storage, read> layers: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> micropolygons: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> wanted: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k >= params[0] {
        return;
    }
    let id = layers[k].y & ID;
    let m = micropolygons[id >> 1u];
    want_corners(id, m);
}
