// Numbers as the processor has them to the bit, whatever compilers and dividers of devices do.

// As in cpu/samples.rs: pixels by which an edge is taken wider.
const EDGE: f32 = 1.5e-3;

// A number that no compiler joins with the next operation: `nothing` is 0, which it does not know.
fn rounded(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ nothing());
}

// a / b rounded to nearest, by whole numbers from an estimate; 0 where it is below the normal numbers. b is not 0, and both are finite.
fn quotient(a: f32, b: f32) -> f32 {
    let sign = (bitcast<u32>(a) ^ bitcast<u32>(b)) & 0x80000000u;
    let x = bitcast<u32>(a) & 0x7fffffffu;
    let y = bitcast<u32>(b) & 0x7fffffffu;
    if x < 0x800000u {
        return 0.0;
    }
    let m = (x & 0x7fffffu) | 0x800000u;
    let n = (y & 0x7fffffu) | 0x800000u;
    // The first 24 bits of the quotient of the mantissas.
    let shift = select(24u, 23u, m >= n);
    var q = u32(round(f32(m) / f32(n) * f32(1u << shift)));
    // What is left is small: it is known from its last 32 bits.
    var rest = bitcast<i32>((m << shift) - q * n);
    for (var k = 0u; k < 64u && rest < 0; k += 1u) {
        q -= 1u;
        rest += i32(n);
    }
    for (var k = 0u; k < 64u && rest >= i32(n); k += 1u) {
        q += 1u;
        rest -= i32(n);
    }
    let twice = 2 * rest;
    if twice > i32(n) || (twice == i32(n) && (q & 1u) == 1u) {
        q += 1u;
    }
    // One less than the exponent, since q has the bit that numbers do not show; it may have become 2^24.
    let exponent = i32(x >> 23u) - i32(y >> 23u) + 149 - i32(shift);
    if exponent < 0 {
        return 0.0;
    }
    return bitcast<f32>(sign | ((u32(exponent) << 23u) + q));
}
