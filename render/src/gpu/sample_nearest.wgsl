// Micropolygons in one pass, where devices have atomics of 64 bits: what is nearest at each sample, the first of those that are equally deep.
// inout nearest  [n_samples]  the key of its depth above, and below 1 more than its id: 0 of what has its colour, or of nothing
#import triangle
#import raster
#import choice
#import sampling
#import takes

@group(0) @binding(3) var<storage, read_write> nearest: array<atomic<u64>>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    atomicMin(&nearest[sample], (u64(key) << 32u) | u64(id + 1u));
}
