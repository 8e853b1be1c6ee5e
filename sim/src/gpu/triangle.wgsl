// Where no fixture is a triangle.

fn is_not_behind(f: u32, gap: f32, radius: u32, reach: f32) -> bool {
    return true;
}

fn touch_triangle(f: u32, centre: Fixed, radius: u32) -> vec4<f32> {
    return vec4(0.0, 0.0, 1.0, 3e38);
}
