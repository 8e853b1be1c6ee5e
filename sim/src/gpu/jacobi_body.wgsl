// Projected Jacobi, second half of an iteration: the velocities of the bodies, v_free + M⁻¹ D γ. A body sums over its contacts in their
// order, so that a run repeats bit for bit.
// in   row         [n_contacts]
// in   gamma       [n_contacts]    N s, world
// in   free        [n_bodies]      m/s, rad/s
// in   side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
// in   side_start  [n_bodies]      first side of each body, and the end
// out  motion      [n_bodies]      m/s, rad/s
// Twin: cpu/solve/body_operator.rs
#import sphere
#import solve_row

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> free: array<Body>;
@group(0) @binding(3) var<storage, read> side: array<u32>;
@group(0) @binding(4) var<storage, read> side_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> motion: array<Body>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let body = row_of(group, thread);
    if body >= arrayLength(&free) {
        return;
    }
    var impulse = vec3(0.0);
    var turn = vec3(0.0);
    let range = side_start[body];
    for (var i = range.x; i < range.y; i++) {
        let k = side[i] / 2u;
        let is_b = (side[i] & 1u) == 1u;
        let z = gamma[k].xyz;
        impulse += select(-z, z, is_b);
        turn += cross(z, rows[k].normal) * select(rows[k].reach.x, rows[k].reach.y, is_b);
    }
    var own = free[body];
    own.v += impulse * own.inv_mass;
    own.w += turn * own.inv_inertia;
    motion[body] = own;
}
