// The first pass over micropolygons that move or are out of focus: the least depth at each sample.
// out  depth   [n_samples]  the key of the depth of what is nearest
#import blur
#import blur_choice
#import blur_sampling
#import takes

@group(0) @binding(6) var<storage, read_write> depth: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    atomicMin(&depth[sample], key);
}
