// A visit of Gauss–Seidel to a contact of spheres, as the sweeps of tiles read it.

#import tile_most

// In place of the last word of one that is not made.
const NO_VISIT: u32 = 0xffffffffu;

struct TileVisit {
    // Unit normal out of A, and the offset Φ/h of an open gap.
    normal: vec4<f32>,
    // Lengths of the arms on A and B along the normal; 1/a and 1/b of N_ii.
    arms: vec4<f32>,
    // As bits the coefficient of friction, and w and c of `visit`; the places of A and B in the tile's list, nine bits each, and the colour, 14 bits.
    cone: vec4<u32>,
}
