// The rows of the contact problem, and the two sides of each contact with their bodies.
// in   contact   [n_contacts]
// in   free      [n_bodies]      m/s, rad/s: velocities at the step's end without contacts
// in   friction  [n_laws]        coefficient of friction
// out  row       [n_contacts]
// out  side_body [2 n_contacts]  body of each side; that of a body held in place comes after all others
// out  side      [2 n_contacts]  twice the contact, and one more for B
// out  n_sides   [1]
// in   count     [1]             n_contacts
// in   params    [1]             as bits: 1 / h (1/s)
// Twin: cpu/contact_solve.rs
#import contact
#import solve_row

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> free: array<Body>;
@group(0) @binding(2) var<storage, read> friction: array<f32>;
@group(0) @binding(3) var<storage, read_write> rows: array<Row>;
@group(0) @binding(4) var<storage, read_write> side_body: array<u32>;
@group(0) @binding(5) var<storage, read_write> side: array<u32>;
@group(0) @binding(6) var<storage, read_write> n_sides: array<u32>;
@group(0) @binding(7) var<storage, read> count: array<u32>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let c = contact[k];
    let a = free[c.bodies.x];
    let b = free[c.bodies.y];
    let turns = c.reach * c.reach;
    let trace = 3.0 * (a.inv_mass + b.inv_mass) + 2.0 * (turns.x * a.inv_inertia + turns.y * b.inv_inertia);
    rows[k] = Row(c.normal, max(c.gap, 0.0) * bitcast<f32>(params[0]), c.reach, c.bodies, friction[c.law], 3.0 / trace);
    let held = arrayLength(&free);
    side_body[2u * k] = select(held, c.bodies.x, a.inv_mass > 0.0);
    side_body[2u * k + 1u] = select(held, c.bodies.y, b.inv_mass > 0.0);
    side[2u * k] = 2u * k;
    side[2u * k + 1u] = 2u * k + 1u;
    if k == 0u {
        n_sides[0] = 2u * count[0];
    }
}
