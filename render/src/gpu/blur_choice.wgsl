// Of the triangles of a micropolygon that a sample meets, the first.

fn choose(m: vec4<u32>, t: Track, place: vec2<f32>, moment: vec4<f32>, met: Met) -> Met {
    return met;
}
