// The second pass over micropolygons that move or are out of focus: the first of those that are nearest at a sample, if it is nearer than
// what was there before.
// in   depth    [n_samples]  the key of the depth of what is nearest
// in   before   [n_samples]  the same before these micropolygons
// out  visible  [n_samples]  the id of what is visible: twice the micropolygon, and 1 more for its second triangle
#import blur
#import blur_choice
#import blur_sampling
#import takes

@group(0) @binding(6) var<storage, read> depth: array<u32>;
@group(0) @binding(7) var<storage, read> before: array<u32>;
@group(0) @binding(8) var<storage, read_write> visible: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read> params: array<u32>;

fn take(sample: u32, key: u32, id: u32) {
    if key == depth[sample] && key < before[sample] {
        atomicMin(&visible[sample], id);
    }
}
