// Rotation of a body whose principal moments are equal over a step.
#import inertia

struct Spun {
    orientation: vec4<f32>,
    spin: vec3<f32>,
}

// Orientation and angular velocity in its own frame after a step `h` that begins with the angular velocity `w`.
fn spun(body: u32, w: vec3<f32>, h: f32, part: f32) -> Spun {
    let after = unit(product_of(rotation_by(w * h), orientation[body]));
    return Spun(after, turned_back(after, w));
}
