// The layers of samples that move or are out of focus.
#import blur
#import blur_weights
#import layer_ids
#import layer_edges
#import blur_layer_slack
#import join

@group(0) @binding(6) var<storage, read> grids: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> ends: array<u32>;
@group(0) @binding(8) var<storage, read_write> layers: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read> params: array<u32>;
