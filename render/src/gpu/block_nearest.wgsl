// The greatest depth in blocks, as `block_depth` has it, where depths stand with ids.
// in   nearest      [n_samples]  id of what is nearest, and the key of its depth
// out  block_depth  [n_blocks]   key
// in   params       [4]          width and height, pixels; samples of a pixel; blocks
#import blocks

@group(0) @binding(0) var<storage, read> nearest: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> block_depth: array<u32>;
@group(0) @binding(2) var<storage, read> params: array<u32>;

fn depth_at(sample: u32) -> u32 {
    return nearest[sample].y;
}
