// The first pass over micropolygons: the least depth at each sample.
// out  depth   [n_samples]  the key of the depth of what is nearest
#import triangle
#import raster
#import choice
#import sampling
#import takes

@group(0) @binding(3) var<storage, read_write> depth: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    atomicMin(&depth[sample], key);
}
