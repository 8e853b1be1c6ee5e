// The layers of samples that stand still, in the lists of these, in no order.
// in    depth   [n_samples]  the key of the depth of what is opaque
// in    planes  [2 n]        clipping planes: what counts times the depth, and what counts alone
// inout ends    [n]          where the next layer of a sample is put; then where its list ends
// out   layers  [n_layers]   key of the depth, and id
#import triangle
#import raster
#import layer_ids
#import layer_edges
#import layer_choice
#import sampling
#import takes
#import layered
#import layer_takes

@group(0) @binding(3) var<storage, read> depth: array<u32>;
@group(0) @binding(4) var<storage, read> grids: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> ends: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> layers: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    if is_layer(sample, key, id) {
        layers[atomicAdd(&ends[sample - params[13]], 1u)] = vec2<u32>(key, id);
    }
}
