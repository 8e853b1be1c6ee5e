// Recovery of overlaps: the velocities that the pushes give the bodies at rest, and their energy, summed over a workgroup; without gravity
// also what keeps the angular momentum.
// in   contact     [n_contacts]
// in   push        [n_contacts]    N s, along the normal
// in   motion      [n_bodies]      m/s, rad/s: velocities at the step's end
// in   side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
// in   side_start  [n_bodies]      first side of each body, and the end
// out  displaced   [2 n_bodies]    m/s: displacement over h; J s: sum of push × relative velocity; a third, rad/s, where arms are of any
//                                  direction
// out  parts       [n_groups]      J, twice
// in   row         [n_contacts]
// in   mass        [n_bodies]      1/kg, and principal, 1/(kg m²)
// in   orientation [n_bodies]
// in   params      [1]             whether the angular momentum counts
// Twin: cpu/solve/overlaps.rs
#import contact
#import solve_row
#import partial
#import displaced
#import inertia

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> push: array<f32>;
@group(0) @binding(2) var<storage, read> motion: array<Body>;
@group(0) @binding(3) var<storage, read> side: array<u32>;
@group(0) @binding(4) var<storage, read> side_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> displaced: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> rows: array<Row>;
@group(0) @binding(8) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    var energy = vec4(0.0);
    if b < arrayLength(&motion) {
        var impulse = vec3(0.0);
        var turn = vec3(0.0);
        var torque = vec3(0.0);
        let range = side_start[b];
        for (var i = range.x; i < range.y; i++) {
            let k = side[i] / 2u;
            let p = contact[k].normal * push[k];
            impulse += select(-p, p, (side[i] & 1u) == 1u);
            if DISPLACED == 3u {
                torque += torque_of(rows[k], p, (side[i] & 1u) == 1u);
            }
            if params[0] == 1u {
                let first = motion[contact[k].bodies.x];
                let second = motion[contact[k].bodies.y];
                if first.inv_mass > 0.0 && second.inv_mass > 0.0 {
                    turn += cross(p, second.v - first.v);
                }
            }
        }
        let inv_mass = motion[b].inv_mass;
        displaced[DISPLACED * b] = vec4(impulse * inv_mass, 0.0);
        displaced[DISPLACED * b + 1u] = vec4(turn, 0.0);
        energy.x = dot(impulse, impulse) * inv_mass;
        if DISPLACED == 3u {
            let moved = turned_by(b, motion[b], torque);
            displaced[DISPLACED * b + 2u] = vec4(moved, 0.0);
            energy.x += dot(moved, torque);
        }
        if is_joined(motion[b]) {
            energy.x = 0.0;
        }
    }
    let sum = group_total(thread, energy);
    if thread == 0u && b / 256u < arrayLength(&parts) {
        parts[b / 256u] = sum;
    }
}
