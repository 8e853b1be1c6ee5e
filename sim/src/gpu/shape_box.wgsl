// The box of a sphere about its body's centre of mass, from the columns `position` and `sphere` of the kernel.
// Twin: cpu/bounds.rs
#import tight
#import solid

fn shape_box(s: u32, margin: f32, unit: f32) -> Aabb {
    let own = sphere[s];
    return tight_box(position[own.body], vec3(f32(own.radius) * unit), margin, unit);
}

// Maximum speed of a shape's surface by the angular velocity of its body, m/s.
fn surface_speed(s: u32) -> f32 {
    return 0.0;
}
