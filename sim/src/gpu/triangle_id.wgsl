// The number of a triangle in the feature ids of contacts, from the column `fixture` of the kernel.
#import fixture

// What the feature ids of the points on a fixture begin with: of a triangle its number among those of its surface.
fn feature_of_fixture(f: u32) -> u32 {
    return select(0u, fixture[f].half.x.y << 17u, fixture[f].kind == TRIANGLE);
}
