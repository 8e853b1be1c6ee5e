// A visit of Gauss–Seidel to the contacts of a pair of shapes of any kind, one after the other, while the velocities of the bodies are in
// registers. With N_ii n = a n + k, k along the tangents, and b the largest eigenvalue of the tangents' part of N_ii, a visit to a contact is,
// by Coulomb's law itself: the normal's own problem, with a (or, where that is greater, two thirds of a + μ |k|: the response of what slides
// and is lifted by friction); then the tangents, which see k times the normal's change, step by 1/b and are projected onto the disc that the
// normal's solution gives. By the relaxed law: a step in the metric (a, b, b) times 1 + |k|/√(ab), which is an
// upper bound of N_ii, and in that metric the projection onto the cone. A rolling impulse follows its contact.
// The kernel has the columns `rows`, `visits` (1/a and 1/b of the step, k in the tangents), `gamma`, `roll`, `roll_row`, `mass`, `orientation`.
// Twin: cpu/solve/manifold_group.rs, cpu/solve/visit.rs
#import project
#import roll
#import tensor

// The velocities of A and B, and their inertia.
struct Two {
    va: vec3<f32>,
    mass_a: f32,
    wa: vec3<f32>,
    mass_b: f32,
    vb: vec3<f32>,
    wb: vec3<f32>,
    a: Tensor,
    b: Tensor,
}

// Steps of projected gradients on the own problem of a rolling block.
const INNER: u32 = 4u;

// The impulse after the visit, with the adhesion; `own` is the row of `visits`.
fn visited(row: Row, before: vec3<f32>, v: vec3<f32>, own: vec4<f32>, is_exact: bool) -> vec3<f32> {
    let n = row.normal;
    let before_n = dot(before, n);
    let v_n = dot(v, n);
    let normal = before_n - (v_n + row.offset) * own.x;
    let v_t = v - n * v_n;
    if is_exact {
        let kept = max(normal, 0.0);
        let axes = tangents(n);
        let coupled = (axes.u * own.z + axes.w * own.w) * (kept - before_n);
        let tangent = before - n * before_n - (v_t + coupled) * own.y;
        let size = length(tangent);
        let most = row.friction * kept;
        return n * kept + tangent * select(most / size, 1.0, size <= most);
    }
    let tangent = before - n * before_n - v_t * own.y;
    // √(b/a).
    let stretch = sqrt(own.x / own.y);
    let z = project(n * normal + tangent * stretch, n, row.friction * stretch);
    let z_n = n * dot(z, n);
    return z_n + (z - z_n) / stretch;
}

// Visit the rolling block of a contact. Returns its residual term squared, as a velocity of the contact.
fn visit_roll(k: u32, two: ptr<function, Two>, row: Row, omega: f32) -> f32 {
    let of_roll = roll_row[k];
    let before = roll[k].xyz;
    let gradient = (*two).wb - (*two).wa;
    let both = Tensor((*two).a.diagonal + (*two).b.diagonal, (*two).a.across + (*two).b.across);
    let step = 1.0 / largest_of(both);
    var z = before;
    for (var i = 0u; i < INNER; i++) {
        z = project_roll(z - (gradient + times(both, z - before)) * step, row, gamma[k].xyz, of_roll);
    }
    let d = (z - before) * omega;
    roll[k] = vec4(before + d, 0.0);
    (*two).wa -= times((*two).a, d);
    (*two).wb += times((*two).b, d);
    return dot(d, d) / (of_roll.z * of_roll.z) * of_roll.w;
}

// Visit a contact. Returns its residual term squared.
fn visit(k: u32, two: ptr<function, Two>, is_exact: bool, omega: f32) -> f32 {
    let row = rows[k];
    let tip = row.normal * row.adhesion;
    let before = gamma[k].xyz;
    let v = (*two).vb - (*two).va + rolling_of(row, (*two).wa, (*two).wb);
    let z = visited(row, before + tip, v, visits[k], is_exact) - tip;
    let d = (z - before) * omega;
    gamma[k] = vec4(before + d, 0.0);
    (*two).va -= d * (*two).mass_a;
    (*two).vb += d * (*two).mass_b;
    (*two).wa += times((*two).a, torque_of(row, d, false));
    (*two).wb += times((*two).b, torque_of(row, d, true));
    var term = dot(d, d) / (row.eta * row.eta);
    if ROLLS {
        term += visit_roll(k, two, row, omega);
    }
    return term;
}
