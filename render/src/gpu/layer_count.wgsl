// How many layers samples have that stand still.
// in   depth   [n_samples]  the key of the depth of what is opaque
// in   planes  [2 n]        clipping planes: what counts times the depth, and what counts alone
// out  counts  [n]          of the samples that are taken; 0 so far
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
@group(0) @binding(6) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    if is_layer(sample, key, id) {
        atomicAdd(&counts[sample - params[13]], 1u);
    }
}
