// The family of pairs of a sphere and a solid that has a closed form, apart from those that the round narrow phase knows.
#import kinds

fn is_of_family(pair: vec2<u32>) -> bool {
    let kinds = kinds_of(pair);
    let has_closed_form = all(kinds != vec2(PLANE)) && all(kinds != vec2(ELLIPSOID));
    return has_closed_form && !is_round(pair) && (is_ball(kinds.x) || is_ball(kinds.y));
}
