// A sort key of 64 bits, low word first.
alias Key = vec2<u32>;

// The 8-bit digit from bit `shift` on.
fn digit_of(key: Key, shift: u32) -> u32 {
    return (select(key.x, key.y, shift >= 32u) >> (shift % 32u)) & 255u;
}
