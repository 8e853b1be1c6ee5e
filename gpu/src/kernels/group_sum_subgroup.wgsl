// Exclusive prefix sum over the 256 threads of a workgroup, and the total, by subgroups.
#import lane

var<workgroup> group_sums: array<u32, 256u / SUBGROUP_MIN>;

// The sum of the threads before, and of all. All threads call it; once in a kernel, or with a barrier before the next time.
fn group_sum(lane: Lane, value: u32) -> vec2<u32> {
    var before = subgroupExclusiveAdd(value);
    if lane.place == lane.size - 1u {
        group_sums[lane.group] = before + value;
    }
    workgroupBarrier();
    var total = 0u;
    for (var g = 0u; g < 256u / lane.size; g++) {
        let sum = group_sums[g];
        before += select(0u, sum, g < lane.group);
        total += sum;
    }
    return vec2(before, total);
}
