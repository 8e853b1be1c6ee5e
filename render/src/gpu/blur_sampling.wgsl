// The samples that meet a micropolygon that moves or is out of focus: `take` is told of each, with the key of its depth and the id of the
// triangle.
// Twin: cpu/blur/moving.rs, lens.rs

// The samples of one stratum, or of those that are tested together.
fn sample_strata(t: Track, index: u32, held: vec2<f32>, first: u32, last: u32) {
    let times = vec2<f32>(strata[3u * first].x, strata[3u * last].y);
    if times.y < held.x || times.x >= held.y {
        return;
    }
    var box = bound_of(t, times, vec2<f32>(), vec2<f32>());
    if has_lens() {
        box = bound_of(t, times, strata[3u * first + 1u], strata[3u * first + 2u]);
    }
    let corner = vec2<f32>(corner_of_image());
    let least = box.xy - corner - EDGE;
    let most = box.zw - corner + EDGE;
    let size = vec2<f32>(f32(params[2]), f32(params[3]));
    if !(most.x >= 0.0 && most.y >= 0.0 && least.x < size.x && least.y < size.y) {
        return;
    }
    let begin = vec2<u32>(max(least, vec2<f32>()));
    let end = min(vec2<u32>(min(most, size)) + 1u, vec2<u32>(params[2], params[3]));
    let n = params[4] * params[5];
    for (var y = begin.y; y < end.y; y += 1u) {
        for (var x = begin.x; x < end.x; x += 1u) {
            let pixel = vec2<u32>(x, y);
            for (var stratum = first; stratum <= last; stratum += 1u) {
                let moment = moments[in_pattern(pixel) * n + stratum];
                let sample = u32(moment.w);
                let place = place_of(pixel, sample);
                if any(place < box.xy) || any(place > box.zw) || moment.x < held.x || moment.x >= held.y {
                    continue;
                }
                var met = meet_at(t, place, moment);
                if met.is_met {
                    met = choose(micropolygons[index], t, place, moment, met);
                }
                if met.is_met {
                    take((y * params[2] + x) * n + sample, key_of(met.z), (2u * index + u32(met.is_second)) | met.flags);
                }
            }
        }
    }
}

fn sample_micropolygon(index: u32) {
    let m = micropolygons[index];
    let grid = tracks[m.w];
    let n_keys = tracks[m.w + 1u].x;
    let n = params[4] * params[5];
    for (var key = 0u; key < n_keys; key += 1u) {
        let row = bitcast<vec4<f32>>(tracks[grid.w + key]);
        let t = track_of(m, key, row);
        let together = select(GROUP, 1u, has_lens());
        for (var first = 0u; first < n; first += together) {
            sample_strata(t, index, row.xy, first, min(first + together, n) - 1u);
        }
    }
}
