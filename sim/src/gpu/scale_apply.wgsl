// Scaling of the starting point: the impulses times the factor.
// inout gamma    [n_contacts]  N s, world
// in    scalars  [1]
// in    count    [1]           n_contacts
// inout roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
#import sphere
#import scalars
#import rolls

@group(0) @binding(0) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read_write> roll: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k < count[0] {
        gamma[k] *= scalars[0].factor;
        if ROLLS {
            roll[k] *= scalars[0].factor;
        }
    }
}
