// Bins: cubes of a power of two of the scale's step, of a level for each width of boxes. A box is in one bin, that of its low corner, of
// the first level whose bins are wider than the box: boxes that overlap are in bins beside each other. Bins have no bounds: their
// indices repeat from some bin on, and what is found there of another bin is told by its coordinates.

// Coordinates of a bin, and its level.
alias Bin = vec4<i32>;

// The level whose bins have twice the power of two below a width, in steps.
fn level_of(width: f32) -> u32 {
    return clamp((bitcast<u32>(width) >> 23u) - 126u, 0u, 63u);
}

// The bin of a point, in steps, on a level.
fn bin_of(point: vec3<f32>, level: u32) -> Bin {
    // The power of two is exact, and so is the quotient.
    return vec4(vec3<i32>(floor(point * exp_of_two(-i32(level)))), i32(level));
}

fn exp_of_two(power: i32) -> f32 {
    return bitcast<f32>(u32(power + 127) << 23u);
}

// The index of a bin: bins of a brick of 8³ are neighbours. `bits` are the bits of a coordinate along each axis that count, at least 3.
fn index_of(bin: Bin, bits: vec3<u32>) -> u32 {
    let at = vec3<u32>(bin.xyz + vec3(bin.w * 37));
    let inner = at & vec3(7u);
    let brick = (at >> vec3(3u)) & ((vec3(1u) << (bits - 3u)) - 1u);
    let outer = brick.x | (brick.y | brick.z << (bits.y - 3u)) << (bits.x - 3u);
    return outer << 9u | inner.z << 6u | inner.y << 3u | inner.x;
}
