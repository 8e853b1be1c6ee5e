// A sort key of 32 bits.
alias Key = u32;

// The 8-bit digit from bit `shift` on.
fn digit_of(key: Key, shift: u32) -> u32 {
    return (key >> shift) & 255u;
}
