// Where no fixture is a surface.

fn surface_pairs(own: Aabb, s: u32, f: u32, place: u32, unit: f32) -> u32 {
    return 0u;
}
