// Lookups in maps, where no others are named than shadow maps.

fn scene_map(map: u32, q: Lookup) -> vec4<f32> {
    return shadow_map(q);
}
