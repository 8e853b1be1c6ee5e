// Reduction over the 256 threads of a workgroup in the order of a binary tree: neighbours first. Without subgroup operations.
#import lane
#import combine

var<workgroup> group_tree_values: array<f32, 256>;

// The result, in thread 0. All threads call it; once in a kernel.
fn group_tree(lane: Lane, value: f32) -> f32 {
    let thread = thread_of(lane);
    group_tree_values[thread] = value;
    for (var step = 1u; step < 256u; step <<= 1u) {
        workgroupBarrier();
        if thread % (2u * step) == 0u {
            group_tree_values[thread] = combine(group_tree_values[thread], group_tree_values[thread + step]);
        }
    }
    return group_tree_values[thread];
}
