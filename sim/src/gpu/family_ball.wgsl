// The family of pairs of a sphere and a solid that has a closed form, apart from those that the round narrow phase knows.
#import kinds

fn is_of_family(pair: vec2<u32>) -> bool {
    let kinds = kinds_of(pair);
    let is_closed = kinds.y != PLANE && kinds.y != TRIANGLE && all(kinds != vec2(ELLIPSOID)) && all(kinds != vec2(HULL));
    return is_closed && !is_round(pair) && (is_ball(kinds.x) || is_ball(kinds.y));
}
