// Inverse inertia tensors of bodies in the world, from the columns `mass` and `orientation` of the kernel, and tangents.
#import turn

// xx, yy, zz; yz, xz, xy.
struct Tensor {
    diagonal: vec3<f32>,
    across: vec3<f32>,
}

fn tensor_of(body: u32) -> Tensor {
    let q = orientation[body];
    let moments = mass[body].yzw;
    let x = turned(q, vec3(1.0, 0.0, 0.0));
    let y = turned(q, vec3(0.0, 1.0, 0.0));
    let z = cross(x, y);
    return Tensor(
        x * x * moments.x + y * y * moments.y + z * z * moments.z,
        x.yxx * x.zzy * moments.x + y.yxx * y.zzy * moments.y + z.yxx * z.zzy * moments.z,
    );
}

fn times(t: Tensor, v: vec3<f32>) -> vec3<f32> {
    return t.diagonal * v + t.across.zzy * v.yxx + t.across.yxx * v.zzy;
}

// A bound of the largest eigenvalue: the largest sum of absolute values of a row.
fn largest_of(t: Tensor) -> f32 {
    let across = abs(t.across);
    let sums = abs(t.diagonal) + across.zzy + across.yxx;
    return max(max(sums.x, max(sums.y, sums.z)), 1e-37);
}

struct Tangents {
    u: vec3<f32>,
    w: vec3<f32>,
}

// Tangents of a unit normal.
fn tangents(n: vec3<f32>) -> Tangents {
    let side = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    return Tangents(vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), vec3(b, side + n.y * n.y * a, -n.y));
}
