// A triangle of a micropolygon on the raster, and where a sample meets it: to the bit what the processor finds.
// Twin: cpu/still.rs
#import exact

// Weights of the second and third corner for each pixel right and down; depth at the first corner and what the others add; the least and
// the greatest depth; the least weight of each corner inside. One without an area is met nowhere.
struct Triangle {
    second: vec2<f32>,
    third: vec2<f32>,
    depth: vec3<f32>,
    range: vec2<f32>,
    least: vec3<f32>,
    sound: bool,
}

struct Meeting {
    second: f32,
    third: f32,
    z: f32,
    inside: bool,
}

fn least_weight(x: f32, y: f32, inverse: f32) -> f32 {
    return -EDGE * rounded(abs(x) + abs(y)) * abs(inverse);
}

// Of the corners at a, a + u and a + v; z is a's depth. It is met nowhere, too, if the sign of its area is not that of side, unless this is 0.
fn triangle(z: f32, u: vec3<f32>, v: vec3<f32>, side: f32) -> Triangle {
    let area = rounded(u.x * v.y) - rounded(v.x * u.y);
    var t: Triangle;
    t.sound = abs(area) > 1e-30 && side * area >= 0.0;
    if !t.sound {
        return t;
    }
    let inverse = quotient(1.0, area);
    t.second = vec2<f32>(rounded(v.y * inverse), rounded(-v.x * inverse));
    t.third = vec2<f32>(rounded(-u.y * inverse), rounded(u.x * inverse));
    t.depth = vec3<f32>(z, u.z, v.z);
    t.range = vec2<f32>(z + min(min(u.z, v.z), 0.0), z + max(max(u.z, v.z), 0.0));
    t.least = vec3<f32>(
        least_weight(v.x - u.x, v.y - u.y, inverse),
        least_weight(v.x, v.y, inverse),
        least_weight(u.x, u.y, inverse),
    );
    return t;
}

// At a place from the first corner on.
fn meet(t: Triangle, d: vec2<f32>) -> Meeting {
    let w1 = rounded(rounded(t.second.x * d.x) + rounded(t.second.y * d.y));
    let w2 = rounded(rounded(t.third.x * d.x) + rounded(t.third.y * d.y));
    let w0 = rounded(1.0 - w1) - w2;
    let z = rounded(t.depth.x + rounded(t.depth.y * w1)) + rounded(t.depth.z * w2);
    let inside = t.sound && w0 >= t.least.x && w1 >= t.least.y && w2 >= t.least.z;
    return Meeting(w1, w2, min(max(z, t.range.x), t.range.y), inside);
}
