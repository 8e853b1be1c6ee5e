// What the impulses of an iterate do to a body, from the columns `gamma`, `spin`, `side`, `side_start` and, where there is rolling friction,
// `roll` of the kernel: as `body_impulse`, but with less to read, since the kernel over contacts has left what the impulses turn bodies by.
#import solve_row
#import impulse
#import rolls
#import spin

fn impulse_on(body: u32) -> Impulse {
    var impulse = vec3(0.0);
    var turn = vec3(0.0);
    let range = side_start[body];
    for (var i = range.x; i < range.y; i++) {
        let k = side[i] / 2u;
        let is_b = (side[i] & 1u) == 1u;
        let z = gamma[k];
        impulse += select(-z.xyz, z.xyz, is_b);
        turn += spin_on(side[i], z);
        if ROLLS {
            turn += select(-roll[k].xyz, roll[k].xyz, is_b);
        }
    }
    return Impulse(impulse, turn);
}
