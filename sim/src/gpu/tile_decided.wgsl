// Whether another iteration of Gauss–Seidel follows, and the residual of the last: by one workgroup of 256, from the columns `moved` (the residual terms
// of the tiles squared, m²/s²), `scalars`, `work` (workgroups of the joints and of `closing`), `round_start` and `count` (n_contacts) of the kernel.
#import scalars
#import partial

// `rest` is the term of big tiles, in thread 0; `closing` tells whether that decides once the iterations of the settings are done.
fn decide(thread: u32, rest: f32, tolerance: f32, closing: bool, n_rounds: u32) {
    let is_active = scalars[0].goes_on == 1u;
    var sums = vec4(0.0);
    let n_tiles = select(0u, round_start[n_rounds], is_active);
    for (var i = thread; i < n_tiles; i += 1024u) {
        let first = vec4(moved[i], 0.0, 0.0, 0.0) + below(vec4(moved[min(i + 256u, n_tiles - 1u)], 0.0, 0.0, 0.0), i + 256u, n_tiles);
        sums += first + (below(vec4(moved[min(i + 512u, n_tiles - 1u)], 0.0, 0.0, 0.0), i + 512u, n_tiles) + below(vec4(moved[min(i + 768u, n_tiles - 1u)], 0.0, 0.0, 0.0), i + 768u, n_tiles));
    }
    sums = group_total(thread, sums);
    if thread != 0u || !is_active {
        return;
    }
    var s = scalars[0];
    s.trials++;
    s.residual = sqrt(sums.x + rest) / f32(blocks_of(count[0]));
    let is_done = s.trials >= s.limit;
    if is_done && closing {
        work[1] = dispatch_of(count[0]);
    }
    if s.residual <= tolerance || (is_done && !closing) {
        s.goes_on = 0u;
        work[0] = vec4(0u, 0u, 1u, 0u);
        work[1] = work[0];
    }
    scalars[0] = s;
}
