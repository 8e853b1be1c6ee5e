// The row of a contact whose arms lie along its normal, from the columns of `solve_rows`.
// Twin: cpu/contact_solve.rs

fn contact_row(k: u32, c: Contact) -> Row {
    let a = mass[c.bodies.x];
    let b = mass[c.bodies.y];
    let turns = c.reach * c.reach;
    let trace = 3.0 * (a.x + b.x) + 2.0 * (turns.x * a.y + turns.y * b.y);
    let speed = dot(velocity[c.bodies.y].xyz - velocity[c.bodies.x].xyz, c.normal);
    let offset = offset_of(c, max(c.gap, 0.0) * bitcast<f32>(params[1]), speed);
    return Row(c.normal, offset, c.reach, c.bodies, law[c.law].x, 3.0 / trace);
}
