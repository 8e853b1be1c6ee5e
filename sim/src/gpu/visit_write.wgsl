// What the visits of Gauss–Seidel to a contact of shapes of any kind need of N_ii.
// in   row         [n_contacts]
// in   mass        [n_bodies]    1/kg, and principal, 1/(kg m²)
// in   orientation [n_bodies]    of the principal frames
// out  visits      [n_contacts]  step lengths along the normal and the tangents, kg; the tangential part of N n along both tangents, 1/kg
// in   count       [1]           n_contacts
// in   params      [1]           whether Coulomb's law is exact
// Twin: cpu/solve/manifold_group.rs
#import sphere
#import solve_row
#import tensor

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> visits: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

// The change of the relative velocity by an impulse.
fn respond(row: Row, inverse: f32, a: Tensor, b: Tensor, d: vec3<f32>) -> vec3<f32> {
    let wa = times(a, torque_of(row, d, false));
    let wb = times(b, torque_of(row, d, true));
    return d * inverse + rolling_of(row, wa, wb);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let row = rows[k];
    let inverse = mass[row.bodies.x].x + mass[row.bodies.y].x;
    let a = tensor_of(row.bodies.x);
    let b = tensor_of(row.bodies.y);
    let axes = tangents(row.normal);
    let of_n = respond(row, inverse, a, b, row.normal);
    let of_u = respond(row, inverse, a, b, axes.u);
    let of_w = respond(row, inverse, a, b, axes.w);
    let uu = dot(of_u, axes.u);
    let ww = dot(of_w, axes.w);
    let uw = dot(of_u, axes.w);
    let spread = 0.5 * (uu - ww);
    let along = dot(of_n, row.normal);
    let across = 0.5 * (uu + ww) + sqrt(spread * spread + uw * uw);
    let coupled = vec2(dot(of_n, axes.u), dot(of_n, axes.w));
    if params[0] == 1u {
        let lifted = (along + row.friction * length(coupled)) * (2.0 / 3.0);
        visits[k] = vec4(1.0 / max(along, lifted), 1.0 / across, coupled);
    } else {
        let bound = 1.0 + sqrt(dot(coupled, coupled) / (along * across));
        visits[k] = vec4(1.0 / (bound * along), 1.0 / (bound * across), coupled);
    }
}
