// Micropolygons that move or are out of focus, as `sample_nearest` has those that stand still.
// inout nearest  [n_samples]  the key of its depth above, and below 1 more than its id: 0 of what has its colour, or of nothing
#import blur
#import blur_choice
#import blur_sampling
#import takes

@group(0) @binding(6) var<storage, read_write> nearest: array<atomic<u64>>;
@group(0) @binding(7) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    atomicMin(&nearest[sample], (u64(key) << 32u) | u64(id + 1u));
}
