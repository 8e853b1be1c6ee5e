// The sides of a pair, from the columns `sphere` and `fixture` of the kernel. Fixtures are numbered behind the moving shapes.
#import sphere
#import fixture

// What a contact needs of a side of a pair.
struct Side {
    shape: u32,
    body: u32,
    material: u32,
}

fn side_of(at: u32) -> Side {
    let n = arrayLength(&sphere);
    if at >= n {
        let f = at - n;
        return Side(fixture[f].shape, fixture[f].body, fixture[f].material);
    }
    return Side(sphere[at].shape, sphere[at].body, sphere[at].material);
}
