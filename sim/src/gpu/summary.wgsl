// The summary of a step, which the report is made of.
// in   of_bodies  [n_groups]  J: kinetic, potential, over the lowest; and h |F·v| of weights
// in   scalars    [1]         of the solve
// in   peaks      [2]         as bits: greatest speed squared, m²/s², and kinetic energy, J
// in   body       [2]         the bodies that have them
// in   worst      [1]         as bits: greatest overlap, m
// in   room       [3]         number of pairs that room is needed for, whether there is room, and the number of contacts
// in   count      [1]         n_contacts
// inout lasts     [1]         as bits: steps for which the pairs hold; none told out
// inout next      [1]         the same from the start of the next step on
// in   round_start [10]       first tile of each round
// out  summary    [1]
// in   params     [1]         n_bodies
#import scalars
#import partial

struct Summary {
    pairs: u32,
    has_room: u32,
    contacts: u32,
    iterations: u32,
    residual: f32,
    worst: f32,
    kinetic: f32,
    potential: f32,
    over_lowest: f32,
    oscillation: f32,
    speed2: f32,
    fastest: u32,
    greatest: f32,
    most_energetic: u32,
    needed: u32,
    lasts: f32,
    next: f32,
    rounds: u32,
}

@group(0) @binding(0) var<storage, read> of_bodies: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read> peaks: array<u32>;
@group(0) @binding(3) var<storage, read> body: array<u32>;
@group(0) @binding(4) var<storage, read> worst: array<u32>;
@group(0) @binding(5) var<storage, read> room: array<u32>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read_write> lasts: array<u32>;
@group(0) @binding(8) var<storage, read_write> next: array<u32>;
@group(0) @binding(9) var<storage, read> round_start: array<u32>;
@group(0) @binding(10) var<storage, read_write> summary: array<Summary>;
@group(0) @binding(11) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var sums = vec4(0.0);
    for (var i = thread; i < groups_of(params[0]); i += 256u) {
        sums += of_bodies[i];
    }
    sums = group_total(thread, sums);
    if thread != 0u {
        return;
    }
    summary[0].pairs = room[0];
    summary[0].has_room = room[1];
    summary[0].contacts = count[0];
    summary[0].iterations = scalars[0].trials;
    summary[0].residual = scalars[0].residual;
    summary[0].worst = bitcast<f32>(worst[0]);
    summary[0].kinetic = sums.x;
    summary[0].potential = sums.y;
    summary[0].over_lowest = sums.z;
    summary[0].oscillation = sums.w;
    summary[0].speed2 = bitcast<f32>(peaks[0]);
    summary[0].fastest = body[0];
    summary[0].greatest = bitcast<f32>(peaks[1]);
    summary[0].most_energetic = body[1];
    summary[0].needed = room[2];
    summary[0].lasts = bitcast<f32>(lasts[0]);
    summary[0].next = bitcast<f32>(next[0]);
    var rounds = 0u;
    for (var round = 0u; round < 9u; round++) {
        rounds |= select(0u, 1u << round, round_start[round + 1u] > round_start[round]);
    }
    summary[0].rounds = rounds;
    // More than any.
    lasts[0] = bitcast<u32>(3.4e38);
    next[0] = lasts[0];
}
