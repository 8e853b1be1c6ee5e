// The sums of the rows that workgroups have left in the columns `of_contacts` and `of_bodies` of the kernel, in thread 0, by one workgroup of 256.
// All threads call them.
#import partial

fn contacts_total(thread: u32, n: u32) -> vec4<f32> {
    var sums = vec4(0.0);
    for (var i = thread; i < n; i += 1024u) {
        let first = of_contacts[i] + below(of_contacts[min(i + 256u, n - 1u)], i + 256u, n);
        sums += first + (below(of_contacts[min(i + 512u, n - 1u)], i + 512u, n) + below(of_contacts[min(i + 768u, n - 1u)], i + 768u, n));
    }
    return group_total(thread, sums);
}

fn bodies_total(thread: u32, n: u32) -> vec4<f32> {
    var sums = vec4(0.0);
    for (var i = thread; i < n; i += 1024u) {
        let first = of_bodies[i] + below(of_bodies[min(i + 256u, n - 1u)], i + 256u, n);
        sums += first + (below(of_bodies[min(i + 512u, n - 1u)], i + 512u, n) + below(of_bodies[min(i + 768u, n - 1u)], i + 768u, n));
    }
    return group_total(thread, sums);
}
