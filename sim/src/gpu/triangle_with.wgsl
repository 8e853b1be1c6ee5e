// A sphere and a triangle of a mesh or a height field, from the column `fixture` of the kernel. It is solid behind its face; edges and
// corners that do not stand out, or belong to a neighbour, are not felt. The corners are in place of the position and of two axes of the
// fixture; the first words of `half` are the bits of edges and corners that count, the number of the triangle, and whether all below it is
// solid, as of a height field.
// Twin: cpu/collide/surface.rs

// What a centre may be beside a triangle and still be over its face, over the distance, and over the size: the rounding.
const BESIDE: f32 = 4.5e-5;
const ROUNDING: f32 = 4e-7;

// A corner about a place, in units.
fn corner_about(f: u32, k: u32, centre: Fixed) -> vec3<f32> {
    if k == 0u {
        return real_fixed(fine_difference(fixture[f].position, centre)) * FINE;
    }
    if k == 1u {
        return real_fixed(fine_difference(fixture[f].x_axis, centre)) * FINE;
    }
    return real_fixed(fine_difference(fixture[f].y_axis, centre)) * FINE;
}

// Whether a sphere at a gap is not so far behind a triangle of a mesh that it cannot have come through it within its reach, units.
fn is_not_behind(f: u32, gap: f32, radius: u32, reach: f32) -> bool {
    return fixture[f].half.y.x == 1u || -gap <= 2.0 * f32(radius) + reach;
}

// The unit normal from the sphere to the triangle, and the gap, units; one beyond all reach where they do not touch.
fn touch_triangle(f: u32, centre: Fixed, radius: u32) -> vec4<f32> {
    let up = real_axis(fixture[f].z_axis);
    let height = along(fine_difference(centre, fixture[f].position), fixture[f].z_axis);
    let over = real64(height) * FINE;
    // How far the centre is beside the face, in the plane; the way there, and the bit of the edge or corner that is nearest.
    var beside = 0.0;
    var way = vec3(0.0);
    var bit = 0u;
    var size = 0.0;
    for (var k = 0u; k < 3u; k++) {
        let next = select(k + 1u, 0u, k == 2u);
        let p = corner_about(f, k, centre);
        let q = corner_about(f, next, centre);
        let edge = q - p;
        size = max(size, length(p));
        // Outside of this edge.
        if dot(p, cross(edge, up)) < 0.0 {
            let at = -dot(p, edge) / dot(edge, edge);
            var nearest = p + edge * clamp(at, 0.0, 1.0);
            nearest -= up * dot(nearest, up);
            let distance = length(nearest);
            if way.x == 0.0 && way.y == 0.0 && way.z == 0.0 || distance < beside {
                beside = distance;
                way = nearest;
                bit = select(select(k, 3u + k, at <= 0.0), 3u + next, at >= 1.0);
            }
        }
    }
    let none = vec4(-up, 3e38);
    let is_behind = over <= 0.0;
    let is_sharp = ((fixture[f].half.x.x >> bit) & 1u) == 1u;
    if beside <= ROUNDING * size || (!is_behind && !is_sharp && beside <= BESIDE * over) {
        // A whole number before it is rounded: a gap may be small beside the radius.
        return vec4(-up, real64(subtract64(height, vec2(radius << 10u, radius >> 22u))) * FINE);
    }
    if is_behind || !is_sharp {
        return none;
    }
    let distance = length(vec2(over, beside));
    return vec4((way - up * over) / distance, distance - f32(radius));
}
