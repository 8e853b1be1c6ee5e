// Numbers of surfaces in the range of an image: sums of them by any weights are numbers, too.

// The greatest, and its bits.
const GREATEST: f32 = 1e30;
const GREATEST_BITS: u32 = 0x7149f2cau;

// A number in that range; what is none stays none.
fn limited(x: f32) -> f32 {
    let size = bitcast<u32>(x) & 0x7fffffffu;
    let is_beyond = size > GREATEST_BITS && size <= 0x7f800000u;
    return select(x, select(GREATEST, -GREATEST, (bitcast<u32>(x) & 0x80000000u) != 0u), is_beyond);
}
