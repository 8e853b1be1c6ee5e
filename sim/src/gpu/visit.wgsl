// A visit of Gauss–Seidel to a contact of spheres: its impulse with those of all others as they are. An arm lies along the normal, so that
// N_ii is diagonal, a along the normal and b across: a projection in that metric, onto the cone of μ. By Coulomb's law itself the normal has a
// problem of its own, and the tangents are projected onto the disc that its solution gives.
// Twin: cpu/solve/sphere_group.rs
#import solve_row

// What a visit needs of N_ii: 1/a, 1/b, and of the projection of a normal p and a tangent of length t, which is onto (w t + p) c along the normal:
// w = μ b/a and c = 1 / (1 + μ w), or 0 and 1 by Coulomb's law itself.
fn metric_of(row: Row, mass: vec2<f32>, moment: vec2<f32>, is_exact: bool) -> vec4<f32> {
    let a = mass.x + mass.y;
    let b = a + dot(row.reach * row.reach, moment);
    let lift = select(row.friction * (b / a), 0.0, is_exact);
    return vec4(1.0 / a, 1.0 / b, lift, 1.0 / (1.0 + row.friction * lift));
}

// The impulse after the visit.
fn visited(n: vec3<f32>, friction: f32, before: vec3<f32>, gradient: vec3<f32>, metric: vec4<f32>) -> vec3<f32> {
    let before_n = dot(before, n);
    let gradient_n = dot(gradient, n);
    let normal = before_n - gradient_n * metric.x;
    let tangent = before - gradient * metric.y - n * (before_n - gradient_n * metric.y);
    let size2 = dot(tangent, tangent);
    // The least positive number of full precision: a tangent of no length keeps none.
    let per_size = inverseSqrt(max(size2, 1.2e-38));
    let most = friction * normal;
    let is_inside = normal >= 0.0 && size2 <= most * most;
    let outside = max((metric.z * (size2 * per_size) + normal) * metric.w, 0.0);
    return n * select(outside, normal, is_inside) + tangent * select(friction * outside * per_size, 1.0, is_inside);
}
