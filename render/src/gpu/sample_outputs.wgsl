// What displays take, besides colours, of what stands still.
#import triangle
#import raster
#import weights
#import seen_outputs

@group(0) @binding(3) var<storage, read> visible: array<u32>;
@group(0) @binding(4) var<storage, read> outputs: array<f32>;
@group(0) @binding(5) var<storage, read_write> sample_outputs: array<f32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;
