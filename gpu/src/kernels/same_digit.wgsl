// The rank of a key among those of its digit in a block, without subgroup operations: within 32 consecutive threads.
#import lane

const SUBGROUPS: u32 = 8u;

// Keys of each digit that each subgroup has; then the rank of its next one: two digits a word.
var<workgroup> ranked: array<atomic<u32>, 1024>;
// Threads of each subgroup whose digit has each bit, and those that have a key.
var<workgroup> having: array<atomic<u32>, 72>;

fn subgroup_of(lane: Lane) -> u32 {
    return lane.thread / 32u;
}

fn subgroup_size_of(lane: Lane) -> u32 {
    return 32u;
}

fn place_of(lane: Lane) -> u32 {
    return lane.thread % 32u;
}

fn count_in_subgroup(lane: Lane, digit: u32) {
    atomicAdd(&ranked[subgroup_of(lane) * 128u + digit / 2u], 1u << (16u * (digit % 2u)));
}

// The rank of the subgroup's next key of this digit, lower places first. All threads call it.
fn rank_in_subgroup(lane: Lane, digit: u32, has_key: bool) -> u32 {
    let subgroup = subgroup_of(lane);
    let own = 1u << place_of(lane);
    if lane.thread < 72u {
        atomicStore(&having[lane.thread], 0u);
    }
    workgroupBarrier();
    if has_key {
        atomicOr(&having[subgroup * 9u + 8u], own);
        for (var bit = 0u; bit < 8u; bit++) {
            if ((digit >> bit) & 1u) == 1u {
                atomicOr(&having[subgroup * 9u + bit], own);
            }
        }
    }
    workgroupBarrier();
    var same = atomicLoad(&having[subgroup * 9u + 8u]);
    for (var bit = 0u; bit < 8u; bit++) {
        same &= atomicLoad(&having[subgroup * 9u + bit]) ^ (((digit >> bit) & 1u) - 1u);
    }
    let word = subgroup * 128u + digit / 2u;
    let half = 16u * (digit % 2u);
    let before = (atomicLoad(&ranked[word]) >> half) & 0xffffu;
    workgroupBarrier();
    let earlier = countOneBits(same & (own - 1u));
    if has_key && earlier == 0u {
        atomicAdd(&ranked[word], countOneBits(same) << half);
    }
    return before + earlier;
}
