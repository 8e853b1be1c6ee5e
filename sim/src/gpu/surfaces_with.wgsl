// The triangles of meshes and height fields that a shape may touch, by a walk through the tree of their boxes, from the columns `node` and
// `fixture` of the kernel.
// Twin: geometry.rs, Surface

// The end of a walk.
const END: u32 = 0xffffffffu;

// Write the pairs of a moving shape and the triangles of a surface whose boxes its own box overlaps, from a place on. Returns their number.
fn surface_pairs(own: Aabb, s: u32, f: u32, place: u32, unit: f32) -> u32 {
    let at = real_fixed(fixture[f].position) * (FINE * unit);
    let frame = mat3x3(real_axis(fixture[f].x_axis), real_axis(fixture[f].y_axis), real_axis(fixture[f].z_axis));
    let centre = 0.5 * (own.low.xyz + own.high.xyz);
    let half = 0.5 * (own.high.xyz - own.low.xyz);
    let local = (centre - at) * frame;
    // More than the roundings of the places and of what is turned.
    let rounding = 1e-6 * (length(centre) + length(at) + length(half));
    let reach = half * mat3x3(abs(frame[0]), abs(frame[1]), abs(frame[2])) + rounding;
    let low = local - reach;
    let high = local + reach;
    var found = 0u;
    var i = fixture[f].part;
    for (var k = 0u; k < arrayLength(&node) && i != END; k++) {
        let box = node[i];
        if any(box.low > high) || any(low > box.high) {
            i = box.next;
            continue;
        }
        if box.leaf == 0u {
            i += 1u;
            continue;
        }
        for (var t = 0u; t < (box.leaf & 7u); t++) {
            write_pair(place + found, vec2(s, count[0] + (box.leaf >> 3u) + t));
            found++;
        }
        i = box.next;
    }
    return found;
}
