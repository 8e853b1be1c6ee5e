// APGD: keep the impulses of the best iterate.
// in   x        [n_contacts]  N s, world
// in   next     [n_contacts]  N s, world: x, if the last trial was taken
// out  best     [n_contacts]  N s, world
// in   scalars  [1]
// in   count    [1]           n_contacts
#import sphere
#import scalars

@group(0) @binding(0) var<storage, read> x_column: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> next: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> best: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(4) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k < count[0] {
        best[k] = select(x_column[k], next[k], scalars[0].accepted != 0u);
    }
}
