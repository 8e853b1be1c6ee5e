// Exclusive prefix sum over the 256 threads of a workgroup, and the total, without subgroup operations.
#import lane

var<workgroup> group_sums: array<u32, 256>;

// The sum of the threads before, and of all. All threads call it; once in a kernel, or with a barrier before the next time.
fn group_sum(lane: Lane, value: u32) -> vec2<u32> {
    let thread = thread_of(lane);
    group_sums[thread] = value;
    for (var step = 1u; step < 256u; step <<= 1u) {
        workgroupBarrier();
        var left = 0u;
        if thread >= step {
            left = group_sums[thread - step];
        }
        workgroupBarrier();
        group_sums[thread] += left;
    }
    workgroupBarrier();
    return vec2(group_sums[thread] - value, group_sums[255]);
}
