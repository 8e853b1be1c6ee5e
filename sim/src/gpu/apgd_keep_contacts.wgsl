// APGD: keep the impulses of the best iterate.
// in   x        [n_contacts or twice as many]  N s, world: the half that has it
// in   next     [n_contacts]  N s, world: x, if the last trial was taken
// out  best     [n_contacts]  N s, world
// in   scalars  [1]
// in   count    [1]           n_contacts
// in   roll_x, roll_next  N m s, world: the same of rolling and spinning impulses
// out  roll_best [n_contacts]  N m s, world
#import sphere
#import scalars
#import rolls

@group(0) @binding(0) var<storage, read> x_column: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> next: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> best: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> roll_x: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> roll_next: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> roll_best: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k < count[0] {
        best[k] = select(x_column[k + scalars[0].half * (arrayLength(&x_column) / 2u)], next[k], scalars[0].accepted != 0u);
        if ROLLS {
            roll_best[k] = select(roll_x[k + scalars[0].half * (arrayLength(&roll_x) / 2u)], roll_next[k], scalars[0].accepted != 0u);
        }
    }
}
