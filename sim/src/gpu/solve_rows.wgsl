// The rows of the contact problem; the starting point is projected onto the cones.
// in    contact   [n_contacts]
// in    mass      [n_bodies]      1/kg, and principal, 1/(kg m²)
// in    velocity  [n_bodies]      m/s, at the step's start
// in    law       [n_laws]        coefficients of friction, of restitution, of rolling and of spinning friction (m)
// inout gamma     [n_contacts]    N s, world
// out   row       [n_contacts]
// inout worst     [1]             as bits: the greatest overlap, m; zero in
// in    count     [1]             n_contacts
// in    arms      [n_contacts]    m, where they are of any direction
// in    orientation, spin [n_bodies]  rad/s, in the bodies' frames
// out   slip      [n_contacts]    m/s, by Coulomb's law itself: the offset without slip, and the slip that is to be fed, twice
// inout roll      [n_contacts]    N m s, world, where there is rolling friction
// out   roll_row  [n_contacts]
// in    cohesions [n_laws]        N
// in    params    [9]             as bits: h (s), 1 / h (1/s), the least speed that bounces (m/s), the gap of rest of faces (m), ten times
//                                 the overlap that is left as it is (m), the maximum speed of recovery (m/s), the least slip over μ
//                                 that is fed (m/s); whether slip is fed; range of cohesion (m)
// Twin: cpu/contact_solve.rs
#import contact
#import project
#import contact_row
#import creep
#import roll
#import turn

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> law: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> rows: array<Row>;
@group(0) @binding(6) var<storage, read_write> worst: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read> count: array<u32>;
@group(0) @binding(8) var<storage, read> arms: array<Arms>;
@group(0) @binding(9) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read_write> slip: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read_write> roll: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> roll_row: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read> cohesions: array<f32>;
@group(0) @binding(15) var<storage, read> params: array<u32>;

// Φ/h of a contact: open gaps close within the step; impacts leave at their share of the speed.
fn offset_of(c: Contact, opening: f32, speed: f32) -> f32 {
    let restitution = law[c.law].y;
    if restitution > 0.0 && speed < -bitcast<f32>(params[2]) && c.gap + bitcast<f32>(params[0]) * speed <= 0.0 {
        return min(opening, restitution * speed);
    }
    return opening;
}

// Adhesion of a contact, N s: the depth of its cone's tip below zero.
fn adhesion_of(c: Contact) -> f32 {
    let cohesion = cohesions[c.law];
    return select(0.0, cohesion * bitcast<f32>(params[0]), cohesion > 0.0 && c.gap <= bitcast<f32>(params[8]));
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let c = contact[k];
    rows[k] = contact_row(k, c);
    let start = project_row(gamma[k].xyz, rows[k]);
    gamma[k] = vec4(start, 0.0);
    if params[7] == 1u {
        let fed = slip_of(velocity_between(k, c), start, c.normal, law[c.law].x, bitcast<f32>(params[6]));
        slip[k] = vec4(rows[k].offset, fed, fed, 0.0);
    }
    if ROLLS {
        let moments = mass[c.bodies.x].yzw + mass[c.bodies.y].yzw;
        let eta = 3.0 / (moments.x + moments.y + moments.z);
        roll_row[k] = vec4(law[c.law].zw, eta, eta / rows[k].eta);
        roll[k] = vec4(project_roll(roll[k].xyz, rows[k], start, roll_row[k]), 0.0);
    }
    let overlap = bitcast<u32>(max(-c.gap, 0.0));
    if overlap > atomicLoad(&worst[0]) {
        atomicMax(&worst[0], overlap);
    }
}
