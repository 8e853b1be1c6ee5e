// The box about a point with half lengths and a margin, rounded outwards.
#import sphere

fn tight_box(position: Fixed, half_lengths: vec3<f32>, margin: f32, step: f32) -> Aabb {
    let centre = real_fixed(position) * (step * FINE);
    let half = half_lengths + margin;
    // More than the roundings of the centre, the half and their sum.
    let rounding = (abs(centre) + half) * 5e-7;
    return Aabb(vec4(centre - half - rounding, 0.0), vec4(centre + half + rounding, 0.0));
}
