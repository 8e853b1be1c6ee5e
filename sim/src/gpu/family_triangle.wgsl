// The family of pairs of a solid and a triangle of a surface.
#import kinds

fn is_of_family(pair: vec2<u32>) -> bool {
    let kinds = kinds_of(pair);
    return kinds.y == TRIANGLE && kinds.x != BALL;
}
