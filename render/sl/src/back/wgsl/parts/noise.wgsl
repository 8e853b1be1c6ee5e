// Noise and random numbers: the same lattice, hash and order of operations as the grid machine's.

fn sl_hash(x: i32, y: i32, z: i32, channel: u32) -> u32 {
    var h = (bitcast<u32>(x) * 0x8da6b343u) ^ (bitcast<u32>(y) * 0xd8163841u) ^ (bitcast<u32>(z) * 0xcb1ab31fu);
    h ^= channel * 0x9e3779b9u;
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return h ^ (h >> 16u);
}

fn sl_slope(hash: u32, x: f32, y: f32, z: f32) -> f32 {
    let h = hash & 15u;
    let u = select(y, x, h < 8u);
    let v = select(select(z, x, h == 12u || h == 14u), y, h < 4u);
    return select(-u, u, (h & 1u) == 0u) + select(-v, v, (h & 2u) == 0u);
}

fn sl_fade(t: f32) -> f32 {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

fn sl_lerp(t: f32, a: f32, b: f32) -> f32 {
    return a + t * (b - a);
}

// The remainder of Euclid; of a period of 0 the number itself.
fn sl_wrap(c: i32, period: i32) -> i32 {
    if period == 0 {
        return c;
    }
    let r = c % period;
    return select(r, r + period, r < 0);
}

fn sl_corner(cell: vec3<i32>, d: vec3<i32>, at: vec3<f32>, period: vec3<i32>, channel: u32) -> f32 {
    let c = cell + d;
    let hash = sl_hash(sl_wrap(c.x, period.x), sl_wrap(c.y, period.y), sl_wrap(c.z, period.z), channel);
    return sl_slope(hash, at.x - f32(d.x), at.y - f32(d.y), at.z - f32(d.z));
}

// Gradient noise that repeats with whole periods; with a period of 0 it does not.
fn sl_lattice(p: vec3<f32>, period: vec3<i32>, channel: u32) -> f32 {
    let low = floor(p);
    let at = p - low;
    let cell = vec3<i32>(sl_whole(low.x), sl_whole(low.y), sl_whole(low.z));
    var corners: array<f32, 8>;
    for (var k = 0; k < 8; k += 1) {
        corners[k] = sl_corner(cell, vec3<i32>(k & 1, (k >> 1u) & 1, k >> 2u), at, period, channel);
    }
    let u = sl_fade(at.x);
    let v = sl_fade(at.y);
    let w = sl_fade(at.z);
    let near = sl_lerp(v, sl_lerp(u, corners[0], corners[1]), sl_lerp(u, corners[2], corners[3]));
    let far = sl_lerp(v, sl_lerp(u, corners[4], corners[5]), sl_lerp(u, corners[6], corners[7]));
    return clamp(0.5 + 0.5 * sl_lerp(w, near, far), 0.0, 1.0);
}

fn sl_noise1(p: vec3<f32>) -> f32 {
    return sl_lattice(p, vec3<i32>(), 0u);
}

fn sl_noise3(p: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(sl_noise1(p), sl_lattice(p, vec3<i32>(), 1u), sl_lattice(p, vec3<i32>(), 2u));
}

fn sl_periods(period: vec3<f32>) -> vec3<i32> {
    let p = abs(period);
    return max(vec3<i32>(sl_whole(p.x), sl_whole(p.y), sl_whole(p.z)), vec3<i32>(1));
}

fn sl_periodic1(p: vec3<f32>, period: vec3<f32>) -> f32 {
    return sl_lattice(p, sl_periods(period), 0u);
}

fn sl_periodic3(p: vec3<f32>, period: vec3<f32>) -> vec3<f32> {
    let whole = sl_periods(period);
    return vec3<f32>(sl_lattice(p, whole, 0u), sl_lattice(p, whole, 1u), sl_lattice(p, whole, 2u));
}

fn sl_layer(p: vec3<f32>, layer: f32, period: vec3<i32>, channel: u32) -> f32 {
    return sl_lattice(p, period, (bitcast<u32>(sl_whole(layer)) * 0x2545f491u) ^ channel);
}

// Noise of a point and a number.
fn sl_timed1(p: vec3<f32>, t: f32, channel: u32) -> f32 {
    let cell = floor(t);
    let near = sl_layer(p, cell, vec3<i32>(), channel);
    return sl_lerp(sl_fade(t - cell), near, sl_layer(p, cell + 1.0, vec3<i32>(), channel));
}

fn sl_timed3(p: vec3<f32>, t: f32) -> vec3<f32> {
    return vec3<f32>(sl_timed1(p, t, 0u), sl_timed1(p, t, 1u), sl_timed1(p, t, 2u));
}

fn sl_timed_periodic1(p: vec3<f32>, t: f32, period: vec3<f32>, period_of_t: f32, channel: u32) -> f32 {
    let cell = floor(t);
    let whole = sl_periods(period);
    let turns = max(floor(abs(period_of_t)), 1.0);
    let near = sl_layer(p, cell - turns * floor(cell / turns), whole, channel);
    let next = cell + 1.0;
    return sl_lerp(sl_fade(t - cell), near, sl_layer(p, next - turns * floor(next / turns), whole, channel));
}

fn sl_timed_periodic3(p: vec3<f32>, t: f32, period: vec3<f32>, period_of_t: f32) -> vec3<f32> {
    return vec3<f32>(
        sl_timed_periodic1(p, t, period, period_of_t, 0u),
        sl_timed_periodic1(p, t, period, period_of_t, 1u),
        sl_timed_periodic1(p, t, period, period_of_t, 2u),
    );
}

fn sl_cell(p: vec3<f32>, channel: u32) -> f32 {
    let c = floor(p);
    return f32(sl_hash(sl_whole(c.x), sl_whole(c.y), sl_whole(c.z), channel + 77u)) / 4294967296.0;
}

fn sl_cell3(p: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(sl_cell(p, 0u), sl_cell(p, 1u), sl_cell(p, 2u));
}

fn sl_timed_cell1(p: vec3<f32>, t: f32, channel: u32) -> f32 {
    return sl_cell(p, (bitcast<u32>(sl_whole(floor(t))) * 0x2545f491u) ^ channel);
}

fn sl_timed_cell3(p: vec3<f32>, t: f32) -> vec3<f32> {
    return vec3<f32>(sl_timed_cell1(p, t, 0u), sl_timed_cell1(p, t, 1u), sl_timed_cell1(p, t, 2u));
}

// A random number of a place, of the call in the source and of the turns of the loops around it.
fn sl_random1(call: f32, place: vec3<f32>, turn: u32, c: u32) -> f32 {
    let bits = bitcast<vec3<u32>>(place);
    let cell = vec3<f32>(f32(bits.x), f32(bits.y), f32(bits.z)) * 0.618034;
    let seed = sl_unsigned(call) * 0x9e3779b9u + turn;
    return sl_cell(cell, (c + 1u) * 0x85ebca6bu + bits[c] + seed);
}

fn sl_random3(call: f32, place: vec3<f32>, turn: u32) -> vec3<f32> {
    return vec3<f32>(
        sl_random1(call, place, turn, 0u),
        sl_random1(call, place, turn, 1u),
        sl_random1(call, place, turn, 2u),
    );
}
