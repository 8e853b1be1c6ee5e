// Reduce each block of 1024 values in the order of a binary tree, neighbours first; the last level leaves a scalar.
// in   values   [n]
// out  results  [n_blocks], at least 1
// in   count    [1]  number of values of level 0
// in   params   [1]  level
// Twin: reduce.rs, reduce_cpu
#import block
#import group_tree

@group(0) @binding(0) var<storage, read> values: array<f32>;
@group(0) @binding(1) var<storage, read_write> results: array<f32>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, lane: Lane) {
    let n = values_of_level(count[0], params[0]);
    let block = block_of(group);
    let first = block * BLOCK + thread_of(lane) * PER_THREAD;
    var own = vec4(IDENTITY);
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < n {
            own[i] = values[first + i];
        }
    }
    let result = group_tree(lane, combine(combine(own.x, own.y), combine(own.z, own.w)));
    if thread_of(lane) == 0u && block < arrayLength(&results) {
        results[block] = result;
    }
}
