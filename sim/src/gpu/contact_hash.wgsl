// The place of a contact in a table of as many slots as a power of two, by its shapes and feature.

fn slot_of(key: vec4<u32>, n_slots: u32) -> u32 {
    var h = key.x * 0x9e3779b1u + key.y * 0x85ebca77u + key.z * 0xc2b2ae3du;
    h ^= h >> 15u;
    h *= 0x2c1b3c6du;
    h ^= h >> 13u;
    return h & (n_slots - 1u);
}
