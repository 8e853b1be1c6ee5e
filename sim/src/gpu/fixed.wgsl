// Positions in fixed point: three signed numbers of 64 bits, low word first, in fine units, of 1/1024 of the scale's unit.
// Differences are exact before they are rounded to units, and so is the square of a distance less that of the sum of radii, from which
// gaps follow.
// Twin: fixed.rs
struct Fixed {
    x: vec2<u32>,
    y: vec2<u32>,
    z: vec2<u32>,
}

fn negate64(a: vec2<u32>) -> vec2<u32> {
    let low = ~a.x + 1u;
    return vec2(low, ~a.y + select(0u, 1u, low == 0u));
}

fn add64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn subtract64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

// The nearest number of single precision, to three roundings.
fn real64(a: vec2<u32>) -> f32 {
    let is_negative = a.y >= 0x80000000u;
    let size = select(a, negate64(a), is_negative);
    let value = f32(size.y) * 4294967296.0 + f32(size.x);
    return select(value, -value, is_negative);
}

fn product64(a: u32, b: u32) -> vec2<u32> {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let first = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let second = (a & 0xffffu) * (b >> 16u) + (first & 0xffffu);
    return vec2((second << 16u) | (low & 0xffffu), (a >> 16u) * (b >> 16u) + (first >> 16u) + (second >> 16u));
}

// The square, modulo 2^64.
fn square64(a: vec2<u32>) -> vec2<u32> {
    return add64(product64(a.x, a.x), vec2(0u, 2u * a.x * a.y));
}

// Fine units over units.
const FINE: f32 = 0.0009765625;

// A number of fine units, to the nearest unit.
fn round64(a: vec2<u32>) -> vec2<u32> {
    let b = add64(a, vec2(512u, 0u));
    return vec2((b.x >> 10u) | (b.y << 22u), bitcast<u32>(bitcast<i32>(b.y) >> 10u));
}

// A length in fine units, to the nearest.
fn fixed64(x: f32) -> vec2<u32> {
    let size = floor(abs(x) + 0.5);
    let high = floor(size * 2.3283064e-10);
    let words = vec2(u32(size - high * 4294967296.0), u32(high));
    return select(words, negate64(words), x < 0.0);
}

fn move_fixed(a: Fixed, by: vec3<f32>) -> Fixed {
    return Fixed(add64(a.x, fixed64(by.x)), add64(a.y, fixed64(by.y)), add64(a.z, fixed64(by.z)));
}

// The difference, fine units.
fn fine_difference(a: Fixed, b: Fixed) -> Fixed {
    return Fixed(subtract64(a.x, b.x), subtract64(a.y, b.y), subtract64(a.z, b.z));
}

// The difference, units.
fn subtract_fixed(a: Fixed, b: Fixed) -> Fixed {
    let d = fine_difference(a, b);
    return Fixed(round64(d.x), round64(d.y), round64(d.z));
}

// The product over 2^60, to less than one.
fn product60(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let is_negative = ((a.y ^ b.y) >> 31u) == 1u;
    let p = select(a, negate64(a), a.y >= 0x80000000u);
    let q = select(b, negate64(b), b.y >= 0x80000000u);
    let low = product64(p.x, q.x);
    let first = product64(p.x, q.y);
    let second = product64(p.y, q.x);
    let high = product64(p.y, q.y);
    var sum = vec2(high.x << 4u, (high.y << 4u) | (high.x >> 28u));
    sum = add64(sum, vec2((first.x >> 28u) | (first.y << 4u), first.y >> 28u));
    sum = add64(sum, vec2((second.x >> 28u) | (second.y << 4u), second.y >> 28u));
    sum = add64(sum, vec2(low.y >> 28u, 0u));
    return select(sum, negate64(sum), is_negative);
}

// The component along an axis that is given over 2^60.
fn along(a: Fixed, axis: Fixed) -> vec2<u32> {
    return add64(product60(a.x, axis.x), add64(product60(a.y, axis.y), product60(a.z, axis.z)));
}

// An axis in single precision.
fn real_axis(axis: Fixed) -> vec3<f32> {
    return real_fixed(axis) * 8.6736174e-19;
}

fn real_fixed(a: Fixed) -> vec3<f32> {
    return vec3(real64(a.x), real64(a.y), real64(a.z));
}

// The unit normal from the first of two spheres to the second, and the gap between them in steps, from the difference of their centres
// and the sum of their radii. Of concentric spheres the normal is z.
fn normal_and_gap(offset: Fixed, radii: vec2<u32>) -> vec4<f32> {
    let d = real_fixed(offset);
    let distance = length(d);
    let reach = real64(radii);
    let normal = select(vec3(0.0, 0.0, 1.0), d / distance, distance > 0.0);
    // |d| - R = (d² - R²) / (|d| + R), whose numerator is exact, unless it exceeds 63 bits: then the gap is of the size of R itself.
    if abs(distance - reach) * (distance + reach) > 4e18 {
        return vec4(normal, distance - reach);
    }
    let squares = add64(square64(offset.x), add64(square64(offset.y), square64(offset.z)));
    return vec4(normal, real64(subtract64(squares, square64(radii))) / (distance + reach));
}
