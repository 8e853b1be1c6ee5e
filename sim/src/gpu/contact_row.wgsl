// The row of a contact whose arms lie along its normal, from the columns of `solve_rows`.
// Twin: cpu/contact_solve.rs

// Velocity of B relative to A at a contact, at the step's start.
fn velocity_between(k: u32, c: Contact) -> vec3<f32> {
    let a = turned(orientation[c.bodies.x], spin[c.bodies.x].xyz);
    let b = turned(orientation[c.bodies.y], spin[c.bodies.y].xyz);
    let rolling = cross(c.normal, a * c.reach.x + b * c.reach.y);
    return velocity[c.bodies.y].xyz - velocity[c.bodies.x].xyz + rolling;
}

fn contact_row(k: u32, c: Contact) -> Row {
    let a = mass[c.bodies.x];
    let b = mass[c.bodies.y];
    let turns = c.reach * c.reach;
    let trace = 3.0 * (a.x + b.x) + 2.0 * (turns.x * a.y + turns.y * b.y);
    let speed = dot(velocity[c.bodies.y].xyz - velocity[c.bodies.x].xyz, c.normal);
    let offset = offset_of(c, max(c.gap, 0.0) * bitcast<f32>(params[1]), speed);
    return Row(c.normal, offset, c.reach, c.bodies, law[c.law].x, 3.0 / trace, adhesion_of(c), 0u);
}
