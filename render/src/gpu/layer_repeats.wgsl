// Which layers repeat one of their primitive.
// Twin: cpu/samples/layers.rs

// What one primitive's layers are apart at least, as a part of their depth; the id of none.
const SAME: f32 = 1e-4;
const NONE: u32 = 0xffffffffu;

// Whether a layer repeats one of its primitive before it.
fn repeats(first: u32, at: u32, z: f32, primitive: u32) -> bool {
    for (var k = at; k > first; k -= 1u) {
        let before = layers[k - 1u];
        if z - depth_of(before.x) > rounded(SAME * z) {
            return false;
        }
        if before.y != NONE && grids[grid_of(micropolygons[(before.y & 0x3fffffffu) >> 1u])].x == primitive {
            return true;
        }
    }
    return false;
}
