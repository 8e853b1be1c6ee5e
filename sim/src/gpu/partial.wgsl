// Sums over the rows of a kernel: each workgroup leaves the sum of its 256 rows, and a kernel of one workgroup sums these, always in the same
// order. The same bits on any device. A barrier costs more than the additions that a tree of eight of them would save.

var<workgroup> partial_values: array<vec4<f32>, 256>;

// The sum over the threads of the workgroup, in thread 0. All threads call it.
fn group_total(thread: u32, value: vec4<f32>) -> vec4<f32> {
    workgroupBarrier();
    partial_values[thread] = value;
    workgroupBarrier();
    var sum = vec4(0.0);
    if thread < 16u {
        for (var i = thread; i < 256u; i += 16u) {
            sum += partial_values[i];
        }
        partial_values[thread] = sum;
    }
    workgroupBarrier();
    if thread == 0u {
        for (var i = 1u; i < 16u; i++) {
            sum += partial_values[i];
        }
    }
    return sum;
}

// A sum of the rows before the n-th, of which a kernel of one workgroup takes four at a time, so that none is waited for alone.
fn below(sum: vec4<f32>, i: u32, n: u32) -> vec4<f32> {
    return select(vec4(0.0), sum, i < n);
}

fn groups_of(n: u32) -> u32 {
    return n / 256u + select(0u, 1u, n % 256u != 0u);
}

// The row of indirect arguments for a kernel over `n` rows.
fn dispatch_of(n: u32) -> vec4<u32> {
    let groups = groups_of(n);
    return vec4(min(groups, 65535u), groups / 65535u + select(0u, 1u, groups % 65535u != 0u), 1u, 0u);
}

fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}
