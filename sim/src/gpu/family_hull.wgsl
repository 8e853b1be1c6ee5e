// The family of pairs of a convex hull and any convex shape.
#import kinds

fn is_of_family(pair: vec2<u32>) -> bool {
    let kinds = kinds_of(pair);
    return any(kinds == vec2(HULL)) && kinds.y != PLANE && kinds.y != TRIANGLE;
}
