// The colours of samples that see something that moves or is out of focus and has no colour yet.
// in    colors   [n_points]   colours of points
// inout visible  [n_samples]  ids of what is visible; then none
// out   color    [n_samples]  colour and coverage
#import blur
#import blur_weights
#import mixed

@group(0) @binding(6) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> visible: array<u32>;
@group(0) @binding(8) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> params: array<u32>;
