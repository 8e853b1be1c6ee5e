// The same with what displays take besides colours.
#import blur
#import blur_weights
#import compose
#import layer_outputs

@group(0) @binding(6) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> opacities: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> grids: array<vec4<u32>>;
@group(0) @binding(9) var<storage, read> ends: array<u32>;
@group(0) @binding(10) var<storage, read> layers: array<vec2<u32>>;
@group(0) @binding(11) var<storage, read_write> depth: array<u32>;
@group(0) @binding(12) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> visible: array<u32>;
@group(0) @binding(14) var<storage, read> kinds: array<u32>;
@group(0) @binding(15) var<storage, read> outputs: array<f32>;
@group(0) @binding(16) var<storage, read_write> layer_sums: array<f32>;
@group(0) @binding(17) var<storage, read_write> sample_outputs: array<f32>;
@group(0) @binding(18) var<storage, read> params: array<u32>;
