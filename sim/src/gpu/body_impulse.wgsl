// What impulses do to a body, from the columns `rows`, `gamma`, `side`, `side_start` and, where there is rolling friction, `roll` of the
// kernel. A body sums over its contacts in their order, so that a run repeats bit for bit.
#import solve_row
#import impulse
#import rolls

fn impulse_on(body: u32) -> Impulse {
    var impulse = vec3(0.0);
    var turn = vec3(0.0);
    let range = side_start[body];
    for (var i = range.x; i < range.y; i++) {
        let k = side[i] / 2u;
        let is_b = (side[i] & 1u) == 1u;
        let z = gamma[k].xyz;
        impulse += select(-z, z, is_b);
        turn += torque_of(rows[k], z, is_b);
        if ROLLS {
            turn += select(-roll[k].xyz, roll[k].xyz, is_b);
        }
    }
    return Impulse(impulse, turn);
}
