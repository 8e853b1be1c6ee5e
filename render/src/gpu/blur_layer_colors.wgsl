// The layers of samples that move or are out of focus, composited over what is opaque.
#import blur
#import blur_weights
#import compose
#import no_outputs

@group(0) @binding(6) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> opacities: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> grids: array<vec4<u32>>;
@group(0) @binding(9) var<storage, read> ends: array<u32>;
@group(0) @binding(10) var<storage, read> layers: array<vec2<u32>>;
@group(0) @binding(11) var<storage, read> depth: array<u32>;
@group(0) @binding(12) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> visible: array<u32>;
@group(0) @binding(14) var<storage, read> params: array<u32>;
