// Lookups in shadow maps of lights: whatever map is named, shadows are traced, to a disc where there is a blur. Elsewhere than in a light
// nothing is in shadow.
// Twin: cpu/view.rs

fn shadow_map(q: Lookup) -> vec4<f32> {
    if !q.has_light {
        return vec4<f32>();
    }
    let blur = max(q.blur.x, q.blur.y);
    let way = q.light - q.at;
    let far = sqrt(dot(way, way));
    let axis = select(vec3<f32>(0.0, 0.0, 1.0), way / far, far > 0.0);
    let side = select(1.0, -1.0, axis.z < 0.0);
    let a = -1.0 / (side + axis.z);
    let b = axis.x * axis.y * a;
    let across = vec3<f32>(1.0 + side * axis.x * axis.x * a, side * b, -side * axis.x);
    let up = vec3<f32>(b, side + axis.y * axis.y * a, -axis.y);
    let radius = select(0.0, blur * far, blur > 0.0);
    let n = select(1u, u32(clamp(q.samples, 1.0, 256.0)), blur > 0.0);
    var lit = 0.0;
    for (var k = 0u; k < n; k += 1u) {
        let at = sl_spread(k, q.at);
        let turn = at.y * 6.28318531;
        let off = (across * sl_cos(turn) + up * sl_sin(turn)) * (radius * sqrt(at.x));
        lit += light_along(q.at, q.light + off).x;
    }
    return vec4<f32>(1.0 - lit / f32(n));
}
