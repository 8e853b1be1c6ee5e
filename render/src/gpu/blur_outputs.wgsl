// What displays take, besides colours, of what moves or is out of focus.
#import blur
#import blur_weights
#import seen_outputs

@group(0) @binding(6) var<storage, read> visible: array<u32>;
@group(0) @binding(7) var<storage, read> outputs: array<f32>;
@group(0) @binding(8) var<storage, read_write> sample_outputs: array<f32>;
@group(0) @binding(9) var<storage, read> params: array<u32>;
