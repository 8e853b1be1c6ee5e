// Functions of matrices, and components by index. A matrix has its sixteen numbers column after column, for column vectors.

fn sl_component3(v: vec3<f32>, i: f32) -> f32 {
    if i >= 0.0 && i < 3.0 {
        return v[u32(i)];
    }
    return 0.0;
}

fn sl_with_component3(v: vec3<f32>, i: f32, x: f32) -> vec3<f32> {
    var w = v;
    if i >= 0.0 && i < 3.0 {
        w[u32(i)] = x;
    }
    return w;
}

fn sl_component16(m: mat4x4<f32>, row: f32, column: f32) -> f32 {
    var own = m;
    if row >= 0.0 && row < 4.0 && column >= 0.0 && column < 4.0 {
        return own[u32(row)][u32(column)];
    }
    return 0.0;
}

fn sl_with_component16(m: mat4x4<f32>, row: f32, column: f32, x: f32) -> mat4x4<f32> {
    var own = m;
    if row >= 0.0 && row < 4.0 && column >= 0.0 && column < 4.0 {
        own[u32(row)][u32(column)] = x;
    }
    return own;
}

fn sl_diagonal(x: f32) -> mat4x4<f32> {
    return mat4x4<f32>(
        vec4<f32>(x, 0.0, 0.0, 0.0),
        vec4<f32>(0.0, x, 0.0, 0.0),
        vec4<f32>(0.0, 0.0, x, 0.0),
        vec4<f32>(0.0, 0.0, 0.0, x),
    );
}

fn sl_matrix_equal(a: mat4x4<f32>, b: mat4x4<f32>) -> f32 {
    return f32(all(a[0] == b[0]) && all(a[1] == b[1]) && all(a[2] == b[2]) && all(a[3] == b[3]));
}

// The inverse, by cofactors; zero of a matrix that has none.
fn sl_inverse(m: mat4x4<f32>) -> mat4x4<f32> {
    let a = m[0].xyz;
    let b = m[1].xyz;
    let c = m[2].xyz;
    let d = m[3].xyz;
    let w = vec4<f32>(m[0].w, m[1].w, m[2].w, m[3].w);
    var s = cross(a, b);
    var t = cross(c, d);
    var u = a * w.y - b * w.x;
    var v = c * w.w - d * w.z;
    let determinant = dot(s, v) + dot(t, u);
    if determinant == 0.0 {
        return mat4x4<f32>();
    }
    let k = 1.0 / determinant;
    s *= k;
    t *= k;
    u *= k;
    v *= k;
    let r0 = cross(b, v) + t * w.y;
    let r1 = cross(v, a) - t * w.x;
    let r2 = cross(d, u) + s * w.w;
    let r3 = cross(u, c) - s * w.z;
    return mat4x4<f32>(
        vec4<f32>(r0.x, r1.x, r2.x, r3.x),
        vec4<f32>(r0.y, r1.y, r2.y, r3.y),
        vec4<f32>(r0.z, r1.z, r2.z, r3.z),
        vec4<f32>(-dot(b, t), dot(a, t), -dot(d, s), dot(c, s)),
    );
}

fn sl_point(m: mat4x4<f32>, p: vec3<f32>) -> vec3<f32> {
    let q = m * vec4<f32>(p, 1.0);
    return q.xyz / q.w;
}

fn sl_vector(m: mat4x4<f32>, v: vec3<f32>) -> vec3<f32> {
    return (m * vec4<f32>(v, 0.0)).xyz;
}

fn sl_normal(m: mat4x4<f32>, n: vec3<f32>) -> vec3<f32> {
    return (transpose(sl_inverse(m)) * vec4<f32>(n, 0.0)).xyz;
}

fn sl_translate(m: mat4x4<f32>, v: vec3<f32>) -> mat4x4<f32> {
    return mat4x4<f32>(m[0], m[1], m[2], m * vec4<f32>(v, 1.0));
}

fn sl_scale(m: mat4x4<f32>, v: vec3<f32>) -> mat4x4<f32> {
    return mat4x4<f32>(m[0] * v.x, m[1] * v.y, m[2] * v.z, m[3]);
}

fn sl_rotate(m: mat4x4<f32>, angle: f32, about: vec3<f32>) -> mat4x4<f32> {
    let far = sqrt(dot(about, about));
    var a = vec3<f32>(0.0, 0.0, 1.0);
    if far > 0.0 {
        a = about / far;
    }
    let s = sl_sin(angle);
    let c = sl_cos(angle);
    let d = 1.0 - c;
    let xyz = a * s;
    let turn = mat4x4<f32>(
        vec4<f32>(a.x * a.x * d + c, a.x * a.y * d + xyz.z, a.x * a.z * d - xyz.y, 0.0),
        vec4<f32>(a.x * a.y * d - xyz.z, a.y * a.y * d + c, a.y * a.z * d + xyz.x, 0.0),
        vec4<f32>(a.x * a.z * d + xyz.y, a.y * a.z * d - xyz.x, a.z * a.z * d + c, 0.0),
        vec4<f32>(0.0, 0.0, 0.0, 1.0),
    );
    return m * turn;
}

// A matrix whose numbers are all the same.
fn sl_filled(x: f32) -> mat4x4<f32> {
    let column = vec4<f32>(x);
    return mat4x4<f32>(column, column, column, column);
}
