// The family of pairs of boxes.
#import kinds

fn is_of_family(pair: vec2<u32>) -> bool {
    return all(kinds_of(pair) == vec2(BOX));
}
