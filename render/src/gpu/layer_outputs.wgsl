// What displays take of layers besides their colours: colours are composited like these, those of a surface by its opacity, other values are
// those of the first that is half opaque.
// in    kinds           [n]           of each number: 1 to 3 if it is the first to the third of a colour, 8 more if that counts by
//                               the opacity, else 0, 4 or 5
// in    outputs         [n × points]
// inout layer_sums      [n × n]       what the layers of a sample have come to
// inout sample_outputs  [n × samples]
// Twin: cpu/samples/layers.rs, cpu/samples/visible.rs

fn is_of_color(i: u32) -> bool {
    return (kinds[i] & 7u) >= 1u && (kinds[i] & 7u) <= 3u;
}

// The channel of the opacity that a number of a colour counts by.
fn channel_of(i: u32) -> u32 {
    return (kinds[i] & 7u) - 1u;
}

fn output_at(seen: Seen, point: u32, i: u32) -> f32 {
    let now = outputs[point * params[17] + i];
    return now + (outputs[(point + seen.next) * params[17] + i] - now) * seen.part;
}

fn lay_outputs(sum: Sum, k: u32, seen: Seen, opacity: vec3<f32>, takes: bool) {
    for (var i = 0u; i < params[17]; i += 1u) {
        let at = k * params[17] + i;
        let is_color = is_of_color(i);
        if !is_color && sum.n > 0u && !takes {
            continue;
        }
        // What is the same at all corners stays that to the bit.
        let a = output_at(seen, seen.corners.x, i);
        let b = output_at(seen, seen.corners.y, i);
        let c = output_at(seen, seen.corners.z, i);
        var own = select(a + (b - a) * seen.weights.y + (c - a) * seen.weights.z, 0.0, seen.is_matte);
        if kinds[i] > 8u {
            own *= opacity[channel_of(i)];
        }
        if is_color && sum.n > 0u {
            layer_sums[at] += sum.open[channel_of(i)] * own;
        } else {
            layer_sums[at] = own;
        }
    }
}

fn finish_outputs(sum: Sum, k: u32, sample: u32, closed: bool) {
    for (var i = 0u; i < params[17]; i += 1u) {
        let at = sample * params[17] + i;
        let own = layer_sums[k * params[17] + i];
        if closed || (!is_of_color(i) && sum.is_half) {
            sample_outputs[at] = own;
        } else if is_of_color(i) {
            sample_outputs[at] = own + sum.open[channel_of(i)] * sample_outputs[at];
        }
    }
    if sum.is_half || closed {
        let bits = bitcast<u32>(select(sum.first_z, sum.half_z, sum.is_half));
        depth[sample] = bits ^ select(0x80000000u, 0xffffffffu, (bits & 0x80000000u) != 0u);
    }
}
