// The colours of samples that see something without a colour yet: between those of the corners where it is smooth.
// in    colors   [n_points]   colours of points
// inout visible  [n_samples]  ids of what is visible; then none
// out   color    [n_samples]  colour and coverage
#import triangle
#import raster
#import weights
#import mixed

@group(0) @binding(3) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> visible: array<u32>;
@group(0) @binding(5) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> params: array<u32>;
