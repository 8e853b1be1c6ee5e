// A visit of Gauss–Seidel to a contact of spheres: its impulse with those of all others as they are. An arm lies along the normal, so that
// N_ii is diagonal, a along the normal and b across: a projection in that metric, onto the cone of μ √(b/a) in stretched tangents. By
// Coulomb's law itself the normal has a problem of its own, and the tangents are projected onto the disc that its solution gives.
// Twin: cpu/solve/sphere_group.rs
#import project

// The impulse after the visit; `inverse` has 1/a and 1/b.
fn visited(row: Row, before: vec3<f32>, gradient: vec3<f32>, inverse: vec2<f32>, is_exact: bool) -> vec3<f32> {
    let n = row.normal;
    let before_n = dot(before, n);
    let gradient_n = dot(gradient, n);
    let normal = before_n - gradient_n * inverse.x;
    let tangent = before - n * before_n - (gradient - n * gradient_n) * inverse.y;
    if is_exact {
        let kept = max(normal, 0.0);
        let size = length(tangent);
        let most = row.friction * kept;
        return n * kept + tangent * select(most / size, 1.0, size <= most);
    }
    let stretch = sqrt(inverse.x / inverse.y);
    let z = project(n * normal + tangent * stretch, n, row.friction * stretch);
    let z_n = n * dot(z, n);
    return z_n + (z - z_n) / stretch;
}

// 1/a and 1/b of a contact.
fn inverse_of(row: Row, mass: vec2<f32>, moment: vec2<f32>) -> vec2<f32> {
    let a = mass.x + mass.y;
    return vec2(1.0 / a, 1.0 / (a + dot(row.reach * row.reach, moment)));
}
