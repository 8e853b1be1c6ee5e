// How many layers samples have that move or are out of focus.
// in   depth   [n_samples]  the key of the depth of what is opaque
// in   planes  [2 n]        clipping planes: what counts times the depth, and what counts alone
// out  counts  [n]          of the samples that are taken; 0 so far
#import blur
#import layer_ids
#import layer_edges
#import blur_layer_choice
#import blur_sampling
#import takes
#import layered
#import layer_takes

@group(0) @binding(6) var<storage, read> depth: array<u32>;
@group(0) @binding(7) var<storage, read> grids: array<vec4<u32>>;
@group(0) @binding(8) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    if is_layer(sample, key, id) {
        atomicAdd(&counts[sample - params[13]], 1u);
    }
}
