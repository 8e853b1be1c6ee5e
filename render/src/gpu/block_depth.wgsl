// The greatest depth in blocks of 4 by 4 pixels, so that what is behind all of their samples is not diced.
// in   depth        [n_samples]  the key of the depth of what is nearest
// out  block_depth  [n_blocks]   key
// in   params       [4]          width and height, pixels; samples of a pixel; blocks
#import blocks

@group(0) @binding(0) var<storage, read> depth: array<u32>;
@group(0) @binding(1) var<storage, read_write> block_depth: array<u32>;
@group(0) @binding(2) var<storage, read> params: array<u32>;

fn depth_at(sample: u32) -> u32 {
    return depth[sample];
}
