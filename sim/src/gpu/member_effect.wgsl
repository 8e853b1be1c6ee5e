// What the contacts do to the bodies that joints, springs and loads act on.
// in   member      [n_members]  bodies
// in   row         [n_contacts]
// in   gamma       [n_contacts]    N s, world
// in   side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
// in   side_start  [n_bodies]      first side of each body, and the end
// in   roll        [n_contacts]    N m s, world
// in   contact     [n_contacts]
// in   push        [n_contacts]    N s, along the normal: recovery of overlaps
// in   displaced   [2 n_bodies]    the second: what keeps the angular momentum, J s
// in   share       [1]             share of the displacement that is made
// out  effect      [5 n_members]   impulse, N s, and the share; angular impulse, N m s; both of the pushes; J s
// in   sizes       [5]             n_members
// Twin: cpu/mechanism.rs
#import contact
#import body_impulse
#import displaced

@group(0) @binding(0) var<storage, read> member: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> rows: array<Row>;
@group(0) @binding(2) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> side: array<u32>;
@group(0) @binding(4) var<storage, read> side_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> roll: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> contact: array<Contact>;
@group(0) @binding(7) var<storage, read> push: array<f32>;
@group(0) @binding(8) var<storage, read> displaced: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> share: array<f32>;
@group(0) @binding(10) var<storage, read_write> effect: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read> sizes: array<u32>;

// The pushes on a body, as impulses.
fn push_on(body: u32) -> Impulse {
    var sum = Impulse(vec3(0.0), vec3(0.0));
    let range = side_start[body];
    for (var i = range.x; i < range.y; i++) {
        let k = side[i] / 2u;
        let is_b = (side[i] & 1u) == 1u;
        let p = contact[k].normal * push[k];
        sum.linear += select(-p, p, is_b);
        // Spheres are not turned by them.
        if DISPLACED == 3u {
            sum.angular += torque_of(rows[k], p, is_b);
        }
    }
    return sum;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let m = row_of(group, thread);
    if m >= sizes[0] {
        return;
    }
    let body = member[m].x;
    let own = impulse_on(body);
    effect[5u * m] = vec4(own.linear, share[0]);
    effect[5u * m + 1u] = vec4(own.angular, 0.0);
    if share[0] > 0.0 {
        let pushed = push_on(body);
        effect[5u * m + 2u] = vec4(pushed.linear, 0.0);
        effect[5u * m + 3u] = vec4(pushed.angular, 0.0);
        effect[5u * m + 4u] = vec4(displaced[DISPLACED * body + 1u].xyz, 0.0);
    }
}
