// Move keys and their values to their places for one 8-bit digit; keys of equal digit keep their order.
// in    keys, values          [n]
// in    place                 [256 x n_blocks]  first place of each digit of each block
// out   keys_out, values_out  [n]
// in    count                 [1]               n
// in    params                [1]               the digit's lowest bit
// Twin: radix_sort.rs, sort_cpu
#import radix_block
#import key
#import same_digit

@group(0) @binding(0) var<storage, read> keys: array<Key>;
@group(0) @binding(1) var<storage, read> values: array<u32>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys_out: array<Key>;
@group(0) @binding(4) var<storage, read_write> values_out: array<u32>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

// First place of each digit of this block.
var<workgroup> start: array<u32, 256>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, lane: Lane) {
    let n = count[0];
    let block = block_of(group);
    let n_blocks = radix_blocks(n);
    let thread = thread_of(lane);
    if block < n_blocks {
        start[thread] = place[thread * n_blocks + block];
    }
    // A subgroup has consecutive keys, and a thread every size-th of them.
    let size = subgroup_size_of(lane);
    let first = block * RADIX_BLOCK + subgroup_of(lane) * KEYS * size + place_of(lane);
    for (var i = 0u; i < KEYS; i++) {
        let k = first + i * size;
        if k < n {
            count_in_subgroup(lane, digit_of(keys[k], params[0]));
        }
    }
    workgroupBarrier();
    // Keys of each digit in the subgroups before; no sum exceeds the block, so that halves do not carry.
    if thread < 128u {
        var sum = 0u;
        for (var g = 0u; g < SUBGROUPS; g++) {
            let counted = atomicLoad(&ranked[g * 128u + thread]);
            atomicStore(&ranked[g * 128u + thread], sum);
            sum += counted;
        }
    }
    workgroupBarrier();
    for (var i = 0u; i < KEYS; i++) {
        let k = first + i * size;
        let has_key = k < n;
        let key = keys[min(k, n - 1u)];
        let digit = digit_of(key, params[0]);
        let to = start[digit] + rank_in_subgroup(lane, digit, has_key);
        if has_key {
            keys_out[to] = key;
            values_out[to] = values[k];
        }
    }
}
