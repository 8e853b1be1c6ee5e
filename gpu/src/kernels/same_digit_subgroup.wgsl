// The rank of a key among those of its digit in a block, by ballots of the subgroup.
#import lane

const SUBGROUPS: u32 = 256u / SUBGROUP_MIN;

// Keys of each digit that each subgroup has; then the rank of its next one: two digits a word.
var<workgroup> ranked: array<atomic<u32>, 128u * (256u / SUBGROUP_MIN)>;

fn subgroup_of(lane: Lane) -> u32 {
    return lane.group;
}

fn subgroup_size_of(lane: Lane) -> u32 {
    return lane.size;
}

fn place_of(lane: Lane) -> u32 {
    return lane.place;
}

fn ones(mask: vec4<u32>) -> u32 {
    let count = countOneBits(mask);
    return count.x + count.y + count.z + count.w;
}

// The places before this one.
fn places_before(place: u32) -> vec4<u32> {
    let word = vec4(0u, 1u, 2u, 3u);
    let partial = vec4((1u << (place % 32u)) - 1u);
    return select(select(vec4(0u), partial, word == vec4(place / 32u)), vec4(~0u), word < vec4(place / 32u));
}

// The first place in a mask, or `other` if there is none.
fn first_of(mask: vec4<u32>, other: u32) -> u32 {
    var first = select(96u + firstTrailingBit(mask.w), other, mask.w == 0u);
    first = select(64u + firstTrailingBit(mask.z), first, mask.z == 0u);
    first = select(32u + firstTrailingBit(mask.y), first, mask.y == 0u);
    return select(firstTrailingBit(mask.x), first, mask.x == 0u);
}

fn count_in_subgroup(lane: Lane, digit: u32) {
    atomicAdd(&ranked[lane.group * 128u + digit / 2u], 1u << (16u * (digit % 2u)));
}

// The rank of the subgroup's next key of this digit, lower places first. All threads call it.
fn rank_in_subgroup(lane: Lane, digit: u32, has_key: bool) -> u32 {
    // Places whose digit differs from this one in some bit.
    var differs = vec4(0u);
    for (var bit = 0u; bit < 8u; bit++) {
        let all_if_set = u32(extractBits(i32(digit), bit, 1u));
        differs |= subgroupBallot(all_if_set != 0u) ^ vec4(all_if_set);
    }
    let same = subgroupBallot(has_key) & ~differs;
    let earlier = ones(same & places_before(lane.place));
    let half = 16u * (digit % 2u);
    var before = 0u;
    // The first thread of a digit counts for all of them.
    if has_key && earlier == 0u {
        before = atomicAdd(&ranked[lane.group * 128u + digit / 2u], ones(same) << half) >> half;
    }
    return (subgroupShuffle(before, first_of(same, lane.place)) & 0xffffu) + earlier;
}
