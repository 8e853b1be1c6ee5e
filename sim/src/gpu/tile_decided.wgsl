// Whether another iteration of Gauss–Seidel follows, and the residual of the last: by one workgroup of 256, from the columns `moved` (the residual terms
// of the tiles squared, m²/s²), `scalars`, `work` (workgroups of the joints and of `closing`), `round_start` and `count` (n_contacts) of the kernel.
#import scalars
#import partial

// The terms of a tile, if there are as many: what it adds to the residual, and to the number of tiles that are not settled.
fn terms_of(i: u32, n: u32) -> vec4<f32> {
    let own = moved[min(i, n - 1u)];
    return below(vec4(abs(own), select(0.0, 1.0, own > 0.0), 0.0, 0.0), i, n);
}

// `rest` is the term of big tiles, in thread 0; `closing` tells whether that decides once the iterations of the settings are done. There are up to
// `beyond` times as many iterations while some tile is not settled.
fn decide(thread: u32, rest: f32, tolerance: f32, closing: bool, n_rounds: u32, beyond: u32) {
    let is_active = scalars[0].goes_on == 1u;
    var sums = vec4(0.0);
    let n_tiles = select(0u, round_start[n_rounds], is_active);
    for (var i = thread; i < n_tiles; i += 1024u) {
        let first = terms_of(i, n_tiles) + terms_of(i + 256u, n_tiles);
        sums += first + (terms_of(i + 512u, n_tiles) + terms_of(i + 768u, n_tiles));
    }
    sums = group_total(thread, sums);
    if thread != 0u || !is_active {
        return;
    }
    var s = scalars[0];
    s.trials++;
    s.residual = sqrt(sums.x + abs(rest)) / f32(blocks_of(count[0]));
    let settles = s.trials < beyond * s.limit && (sums.y > 0.0 || rest > 0.0);
    let is_done = s.trials >= s.limit && !settles;
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
