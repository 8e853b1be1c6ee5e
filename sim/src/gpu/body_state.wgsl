// The state of a body on its way between the processor and the device.
#import sphere

struct BodyState {
    position: Fixed,
    body: u32,
    is_held: u32,
    orientation: vec4<f32>,
    velocity: vec4<f32>,
    spin: vec4<f32>,
}
