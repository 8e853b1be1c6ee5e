// What a reduction combines by: the maximum.
const IDENTITY: f32 = -3.4028234e38;

fn combine(a: f32, b: f32) -> f32 {
    return max(a, b);
}
