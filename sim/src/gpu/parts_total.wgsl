// The sum of the rows that workgroups have left in the column `parts` of the kernel, in thread 0, by one workgroup of 256. All threads call it.
#import partial

fn parts_total(thread: u32, n: u32) -> vec4<f32> {
    var sums = vec4(0.0);
    for (var i = thread; i < n; i += 1024u) {
        let first = parts[i] + below(parts[min(i + 256u, n - 1u)], i + 256u, n);
        sums += first + (below(parts[min(i + 512u, n - 1u)], i + 512u, n) + below(parts[min(i + 768u, n - 1u)], i + 768u, n));
    }
    return group_total(thread, sums);
}
