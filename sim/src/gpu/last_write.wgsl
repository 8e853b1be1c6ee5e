// Keep the contacts of a step for the next one, unless the step is undone.
// in    contact     [n_contacts]
// in    gamma       [n_contacts]  N s, world
// out   last_key    [n_last]      shapes and feature
// out   last_gamma  [n_last]      N s, world
// out   n_last      [1]
// in    room        [2]           whether there was room for all pairs, second
// in    count       [1]           n_contacts
// in    roll        [n_contacts]  N m s, world, where there is rolling friction
// out   last_roll   [n_last]      N m s, world
#import contact
#import rolls

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> last_key: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> last_gamma: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> n_last: array<u32>;
@group(0) @binding(5) var<storage, read> room: array<u32>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> roll: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> last_roll: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if room[1] == 0u {
        return;
    }
    if k == 0u {
        n_last[0] = count[0];
    }
    if k < count[0] {
        last_key[k] = vec4(contact[k].shapes, contact[k].feature, 0u);
        last_gamma[k] = gamma[k];
        if ROLLS {
            last_roll[k] = roll[k];
        }
    }
}
