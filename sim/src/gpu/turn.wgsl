// Rotations as quaternions, x, y, z, w.

fn turned(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

fn turned_back(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    return turned(vec4(-q.xyz, q.w), v);
}

fn product_of(p: vec4<f32>, q: vec4<f32>) -> vec4<f32> {
    return vec4(p.w * q.xyz + q.w * p.xyz + cross(p.xyz, q.xyz), p.w * q.w - dot(p.xyz, q.xyz));
}

// A rotation whose square is 1 to rounding. The devices' reciprocal roots are off by some roundings to one side, by which a momentum that is
// turned to and fro in every step would grow.
fn unit(q: vec4<f32>) -> vec4<f32> {
    let p = normalize(q);
    return p * (1.5 - 0.5 * dot(p, p));
}

// The rotation by a rotation vector, rad. The devices' sines are coarse: series in the square of the half angle, which is halved until it
// is small, and as many squares of the rotation.
fn rotation_by(angle: vec3<f32>) -> vec4<f32> {
    var part = 0.5 * angle;
    var squares = 0u;
    for (var i = 0u; i < 32u && dot(part, part) > 0.25; i++) {
        part *= 0.5;
        squares++;
    }
    let q = dot(part, part);
    let sine = 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0)));
    let cosine = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0)));
    var r = vec4(part * sine, cosine);
    for (var i = 0u; i < squares; i++) {
        r = product_of(r, r);
    }
    return r;
}
