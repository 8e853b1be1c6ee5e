// The points of a pair of convex shapes, that of the lower id first, by `solid_points`. They are looked for somewhat farther, as on the CPU,
// which keeps them.
// Twin: cpu/recycle.rs

const FARTHER: f32 = 0.15;

fn points_of(pair: vec2<u32>, origin: Fixed, fine: f32, reach: f32) -> u32 {
    let sides = select(pair, pair.yx, side_of(pair.y).shape < side_of(pair.x).shape);
    let a = placed(sides.x, origin, fine);
    let b = placed(sides.y, origin, fine);
    let n = solid_points(at_home(a), seen_from(b, a), reach * (1.0 + FARTHER));
    var kept = 0u;
    for (var k = 0u; k < n; k++) {
        if found[k].gap <= reach {
            found[kept] = found[k];
            kept++;
        }
    }
    // Placed again, so that it is not kept all the while: there are never more points.
    leave_home(placed(select(sides.x, sides.y, n > MAX_POINTS), origin, fine), kept);
    return kept;
}
