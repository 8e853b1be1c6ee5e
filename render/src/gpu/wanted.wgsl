// Points that are wanted, a bit each.

fn is_wanted(point: u32) -> bool {
    return (wanted[point >> 5u] >> (point & 31u) & 1u) == 1u;
}

// How many of the points from `first` on are wanted before another.
fn wanted_before(first: u32, point: u32) -> u32 {
    let begin = first >> 5u;
    let end = point >> 5u;
    let low = 0xffffffffu << (first & 31u);
    let below = (1u << (point & 31u)) - 1u;
    if begin == end {
        return countOneBits(wanted[end] & low & below);
    }
    var n = countOneBits(wanted[begin] & low) + countOneBits(wanted[end] & below);
    for (var word = begin + 1u; word < end; word += 1u) {
        n += countOneBits(wanted[word]);
    }
    return n;
}
