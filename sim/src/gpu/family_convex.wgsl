// The family of pairs of convex shapes without a narrow phase of their own.
#import kinds

fn is_of_family(pair: vec2<u32>) -> bool {
    let kinds = kinds_of(pair);
    let is_round = (is_ball(kinds.x) || is_ball(kinds.y)) && all(kinds != vec2(ELLIPSOID));
    let has_own = kinds.y == PLANE || kinds.y == TRIANGLE || any(kinds == vec2(HULL)) || all(kinds == vec2(BOX));
    return !is_round && !has_own;
}
