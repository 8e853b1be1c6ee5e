// The pairs of a tile, or those of them that touch, in their order: with `is_listed` of the kernel, by a workgroup of 256.

const THREADS: u32 = 256u;
// The most pairs that are listed, eight to a thread.
const MOST: u32 = 2048u;
// Colours; pairs that none was free for are visited after all others, each alone.
const MOST_COLORS: u32 = 32u;

// A bit for each pair of the tile that is listed.
var<workgroup> list_bits: array<atomic<u32>, 256>;
// Pairs that are, from the tile's first on.
var<workgroup> listed: array<u32, 2048>;
var<workgroup> n_listed: u32;

// Number of pairs that are listed before one.
fn n_listed_before(at: u32) -> u32 {
    var n = 0u;
    for (var word = 0u; word < at / 32u; word++) {
        n += countOneBits(atomicLoad(&list_bits[word]));
    }
    if at % 32u == 0u {
        return n;
    }
    return n + countOneBits(atomicLoad(&list_bits[at / 32u]) & ((1u << (at % 32u)) - 1u));
}

// List the pairs of a tile. Returns their number; if there are more than the most, these are not there. All threads call it.
fn list_pairs(first: u32, end: u32, thread: u32) -> u32 {
    workgroupBarrier();
    atomicStore(&list_bits[thread], 0u);
    workgroupBarrier();
    for (var k = first + thread; k < end; k += THREADS) {
        if is_listed(k) {
            let at = k - first;
            atomicOr(&list_bits[at / 32u], 1u << (at % 32u));
        }
    }
    workgroupBarrier();
    for (var k = first + thread; k < end; k += THREADS) {
        if is_listed(k) {
            let at = n_listed_before(k - first);
            if at < MOST {
                listed[at] = k - first;
            }
        }
    }
    if thread == 0u {
        n_listed = n_listed_before(end - first - 1u) + select(0u, 1u, is_listed(end - 1u));
    }
    return workgroupUniformLoad(&n_listed);
}
