// The triangle of a micropolygon that has a sample of layers at its moment: on an edge that two of them share, one of these.
// Twin: cpu/blur/quad.rs

fn choose(m: vec4<u32>, t: Track, place: vec2<f32>, moment: vec4<f32>, met: Met) -> Met {
    let at = corners_at(t, place, moment);
    let v = around(m, at[0], at[1], at[2], at[3]);
    let inside = insides(v);
    if !inside.x && !inside.y {
        return Met();
    }
    var chosen = met_in(t, moment, at, !inside.x);
    chosen.flags = edge_flags(v, chosen.is_second);
    return chosen;
}
