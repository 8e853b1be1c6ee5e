// How a sphere touches a sphere or a fixture, from the columns `position`, `sphere` and `fixture` of the kernel. Fixtures are numbered
// behind the spheres.
// Twin: cpu/collide/round.rs
#import sphere
#import fixture
#import outline
#import triangle_id
#import triangle

// What a contact needs of its two sides: radii in units, shapes, bodies and materials.
struct Sides {
    radii: vec2<u32>,
    shapes: vec2<u32>,
    bodies: vec2<u32>,
    materials: vec2<u32>,
}

fn sides_of(pair: vec2<u32>) -> Sides {
    let p = sphere[pair.x];
    let n = arrayLength(&sphere);
    if pair.y >= n {
        let f = pair.y - n;
        let held = vec3(fixture[f].shape, fixture[f].body, fixture[f].material);
        return Sides(vec2(p.radius, 0u), vec2(p.shape, held.x), vec2(p.body, held.y), vec2(p.material, held.z));
    }
    let q = sphere[pair.y];
    return Sides(vec2(p.radius, q.radius), vec2(p.shape, q.shape), vec2(p.body, q.body), vec2(p.material, q.material));
}

// The unit normal from the first to the second, and the gap, units.
fn touch(pair: vec2<u32>) -> vec4<f32> {
    let n = arrayLength(&sphere);
    let p = sphere[pair.x];
    if pair.y < n {
        let q = sphere[pair.y];
        let offset = subtract_fixed(position[q.body], position[p.body]);
        return normal_and_gap(offset, add64(vec2(p.radius, 0u), vec2(q.radius, 0u)));
    }
    let f = pair.y - n;
    if fixture[f].kind == TRIANGLE {
        return touch_triangle(f, position[p.body], p.radius);
    }
    let offset = fine_difference(position[p.body], fixture[f].position);
    let radius = f32(p.radius);
    let z = along(offset, fixture[f].z_axis);
    if fixture[f].kind == PLANE {
        // A whole number before it is rounded: a height may be small beside the radius.
        let height = subtract64(z, vec2(p.radius << 10u, p.radius >> 22u));
        return vec4(-real_axis(fixture[f].z_axis), real64(height) * FINE);
    }
    let x = along(offset, fixture[f].x_axis);
    let y = along(offset, fixture[f].y_axis);
    let half = fixture[f].half;
    if fixture[f].kind != BOX {
        // A solid of revolution: a problem in the half plane of the distance from the axis and the height.
        let across = vec2(real64(x), real64(y)) * FINE;
        let radial = length(across);
        let around = select(vec2(1.0, 0.0), across / radial, radial > 0.0);
        var found = vec3(0.0);
        if fixture[f].kind == CAPSULE {
            let from_core = vec2(radial, beyond(z, half.z) * FINE);
            let size = length(from_core);
            found = vec3(select(vec2(1.0, 0.0), from_core / size, size > 0.0), size - real64(half.x) * FINE);
        } else {
            let size = vec2(real64(half.x), real64(half.z)) * FINE;
            found = outline(vec2(radial, real64(z) * FINE), size, fixture[f].kind == CONE);
        }
        let outward = vec3(around * found.x, found.y);
        return vec4(out_of_frame(f, -outward), found.z - radius);
    }
    let away = vec3(beyond(x, half.x), beyond(y, half.y), beyond(z, half.z)) * FINE;
    let distance = length(away);
    if distance > 0.0 {
        return vec4(out_of_frame(f, -away / distance), distance - radius);
    }
    // The centre is inside: out through the nearest face.
    let depth = vec3(inside(x, half.x), inside(y, half.y), inside(z, half.z)) * FINE;
    var outward = vec3(0.0, 0.0, sign_of(z));
    var least = depth.z;
    if depth.y <= least {
        outward = vec3(0.0, sign_of(y), 0.0);
        least = depth.y;
    }
    if depth.x <= least {
        outward = vec3(sign_of(x), 0.0, 0.0);
        least = depth.x;
    }
    return vec4(out_of_frame(f, -outward), -least - radius);
}

// Whether a gap of a pair is within its reach, units.
fn is_met(pair: vec2<u32>, gap: f32, reach: f32) -> bool {
    let n = arrayLength(&sphere);
    if pair.y >= n && fixture[pair.y - n].kind == TRIANGLE && !is_not_behind(pair.y - n, gap, sphere[pair.x].radius, reach) {
        return false;
    }
    return gap <= reach;
}

fn sign_of(x: vec2<u32>) -> f32 {
    return select(1.0, -1.0, x.y >= 0x80000000u);
}

// What of a coordinate is beyond a half length, fine units.
fn beyond(x: vec2<u32>, half: vec2<u32>) -> f32 {
    let size = select(x, negate64(x), x.y >= 0x80000000u);
    let over = subtract64(size, half);
    return select(real64(over) * sign_of(x), 0.0, over.y >= 0x80000000u);
}

// How far a coordinate is inside a half length, fine units.
fn inside(x: vec2<u32>, half: vec2<u32>) -> f32 {
    let size = select(x, negate64(x), x.y >= 0x80000000u);
    return real64(subtract64(half, size));
}

fn out_of_frame(f: u32, v: vec3<f32>) -> vec3<f32> {
    return real_axis(fixture[f].x_axis) * v.x + real_axis(fixture[f].y_axis) * v.y + real_axis(fixture[f].z_axis) * v.z;
}
