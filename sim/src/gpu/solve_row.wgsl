// The rows that the solver's kernels share.
#import row

// Velocity and inverse mass of a body, angular velocity and inverse moment of inertia, world.
struct Body {
    v: vec3<f32>,
    inv_mass: f32,
    w: vec3<f32>,
    inv_inertia: f32,
}

// The same as two vectors, each of which is read and written at once: a kernel that writes the column is twice as fast by these.
struct BodyRow {
    linear: vec4<f32>,
    angular: vec4<f32>,
}

fn body_row(body: Body) -> BodyRow {
    return BodyRow(vec4(body.v, body.inv_mass), vec4(body.w, body.inv_inertia));
}

fn body_of(row: BodyRow) -> Body {
    return Body(row.linear.xyz, row.linear.w, row.angular.xyz, row.angular.w);
}

// Whether joints act on a body, whose energy they then sum.
fn is_joined(body: Body) -> bool {
    return body.inv_inertia < 0.0;
}
