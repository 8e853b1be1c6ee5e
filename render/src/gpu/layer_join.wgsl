// The layers of samples that stand still.
#import triangle
#import raster
#import layer_ids
#import layer_edges
#import layer_slack
#import join

@group(0) @binding(3) var<storage, read> grids: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> ends: array<u32>;
@group(0) @binding(5) var<storage, read_write> layers: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> params: array<u32>;
