// The velocities that impulses give a body, v_free + M⁻¹ D γ, from the columns `rows`, `gamma`, `free`, `side` and `side_start` of the
// kernel, and where inertia is not isotropic from `mass` and `orientation`, and `roll`, where there is rolling friction. A body sums over its contacts in their order, so that a run repeats bit for bit.
#import solve_row
#import inertia
#import rolls

fn response_of(body: u32) -> Body {
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
    var own = free[body];
    own.v += impulse * own.inv_mass;
    own.w += turned_by(body, own, turn);
    return own;
}
