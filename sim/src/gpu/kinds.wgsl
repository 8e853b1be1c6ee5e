// The kinds of the shapes of a pair, from the columns `sphere`, `solid` and `fixture` of the kernel.
#import sphere
#import solid

// Kind of a shape; fixtures are numbered behind the moving shapes.
fn kind_at(at: u32) -> u32 {
    let n = arrayLength(&sphere);
    if at >= n {
        return fixture[at - n].kind;
    }
    return solid[at].kind;
}

fn kinds_of(pair: vec2<u32>) -> vec2<u32> {
    return vec2(kind_at(pair.x), kind_at(pair.y));
}

fn is_ball(kind: u32) -> bool {
    return kind == BALL || kind == SPHERE;
}

// Whether the round narrow phase knows a pair: spheres about their bodies' centres of mass, against each other and against fixtures that are
// no hulls.
fn is_round(pair: vec2<u32>) -> bool {
    let kinds = kinds_of(pair);
    return kinds.x == BALL && (kinds.y == BALL || (pair.y >= arrayLength(&sphere) && kinds.y != HULL));
}
