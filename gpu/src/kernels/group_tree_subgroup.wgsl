// Reduction over the 256 threads of a workgroup in the order of a binary tree: neighbours first, by subgroups. The tree is the same
// for any size of these.
#import lane
#import combine

var<workgroup> group_tree_values: array<f32, 256u / SUBGROUP_MIN>;

// The result, in thread 0. All threads call it; once in a kernel.
fn group_tree(lane: Lane, value: f32) -> f32 {
    var sum = value;
    for (var step = 1u; step < lane.size; step <<= 1u) {
        sum = combine(sum, subgroupShuffleXor(sum, step));
    }
    if lane.place == 0u {
        group_tree_values[lane.group] = sum;
    }
    let n = 256u / lane.size;
    let thread = thread_of(lane);
    for (var step = 1u; step < n; step <<= 1u) {
        workgroupBarrier();
        if thread < n && thread % (2u * step) == 0u {
            group_tree_values[thread] = combine(group_tree_values[thread], group_tree_values[thread + step]);
        }
    }
    return group_tree_values[0];
}
