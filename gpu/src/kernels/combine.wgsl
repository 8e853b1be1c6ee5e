// What a reduction combines by: the sum.
const IDENTITY: f32 = 0.0;

fn combine(a: f32, b: f32) -> f32 {
    return a + b;
}
