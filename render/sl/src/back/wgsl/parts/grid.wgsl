// A grid that a workgroup shades together: values of neighbouring points, and masks. All calls stand in uniform control flow.

var<workgroup> work: Grid;
var<workgroup> neighbours: array<vec4<f32>, GROUP>;
var<workgroup> some: atomic<u32>;
var<workgroup> shared_number: u32;
var<private> lane: u32;

// A number that all points have, known to be the same for all. Who reads what is shared so waits for all others to have read it.
fn sl_uniform(x: u32) -> u32 {
    if lane == 0u {
        shared_number = x;
    }
    return workgroupUniformLoad(&shared_number);
}

// Whether any point is active.
fn sl_any(on: bool) -> bool {
    if lane == 0u {
        atomicStore(&some, 0u);
    }
    workgroupBarrier();
    if on {
        atomicStore(&some, 1u);
    }
    return workgroupUniformLoad(&some) != 0u;
}

fn sl_difference(here: u32, count: u32, stride: u32) -> vec4<f32> {
    let low = max(here, 1u) - 1u;
    let high = min(here + 1u, count - 1u);
    if high <= low {
        return vec4<f32>();
    }
    let first = point - here * stride;
    return (neighbours[first + high * stride] - neighbours[first + low * stride]) / f32(high - low);
}

// Differences of values to the next point of the row, and of the column; central where there are two neighbours.
struct Differences {
    row: vec4<f32>,
    column: vec4<f32>,
}

fn sl_differences(x: vec4<f32>) -> Differences {
    workgroupBarrier();
    neighbours[lane] = x;
    workgroupBarrier();
    let nu = max(work.nu, 1u);
    return Differences(sl_difference(point % nu, nu, 1u), sl_difference(point / nu, work.n / nu, nu));
}

// The value of the grid's first point.
fn sl_first3(v: vec3<f32>) -> vec3<f32> {
    workgroupBarrier();
    neighbours[lane] = vec4<f32>(v, 0.0);
    workgroupBarrier();
    return neighbours[0].xyz;
}

// Differences over what a point stands for.
fn sl_over(d: Differences) -> Differences {
    if work.footprints == 0u {
        return d;
    }
    let first = work.footprints - 1u + point;
    let uu = values[first];
    let uv = values[first + work.n];
    let vv = values[first + 2u * work.n];
    return Differences(d.row * uu + d.column * uv, d.row * uv + d.column * vv);
}

fn sl_own_width(x: f32) -> f32 {
    let d = sl_differences(vec4<f32>(x, 0.0, 0.0, 0.0));
    return max(abs(d.row.x), abs(d.column.x));
}

fn sl_width(x: f32) -> f32 {
    let d = sl_over(sl_differences(vec4<f32>(x, 0.0, 0.0, 0.0)));
    return max(abs(d.row.x), abs(d.column.x));
}

// A number that no compiler joins with the next operation: a row has fewer points than the bit stands for, which it does not know.
fn sl_rounded(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ (work.nu & 0x80000000u));
}

// a d - b c, each product rounded: 0 where they are the same, since what is left of a fused one is a slope where there is none.
fn sl_determinant(a: f32, b: f32, c: f32, d: f32) -> f32 {
    return sl_rounded(a * d) - sl_rounded(b * c);
}

// The derivatives along u and v of a value that changes by `x` to the next point of the row and of the column, where u and v change by those
// of `of_uv`.
fn sl_along(x: vec2<f32>, of_uv: Differences) -> vec2<f32> {
    let u = vec2<f32>(of_uv.row.x, of_uv.column.x);
    let v = vec2<f32>(of_uv.row.y, of_uv.column.y);
    let whole = sl_determinant(u.x, u.y, v.x, v.y);
    return vec2<f32>(
        sl_divide(sl_determinant(x.x, x.y, v.x, v.y), whole),
        sl_divide(sl_determinant(u.x, u.y, x.x, x.y), whole),
    );
}

fn sl_slopes(x: f32, u: f32, v: f32) -> vec2<f32> {
    let d = sl_differences(vec4<f32>(u, v, x, 0.0));
    return sl_along(vec2<f32>(d.row.z, d.column.z), d);
}

fn sl_du(x: f32, u: f32, v: f32) -> f32 {
    return sl_slopes(x, u, v).x;
}

fn sl_dv(x: f32, u: f32, v: f32) -> f32 {
    return sl_slopes(x, u, v).y;
}

// The same of a triple: those along u, and those along v.
fn sl_slopes3(x: vec3<f32>, u: f32, v: f32) -> array<vec3<f32>, 2> {
    let d = sl_differences(vec4<f32>(x, 0.0));
    let of_uv = sl_differences(vec4<f32>(u, v, 0.0, 0.0));
    let of_x = sl_along(vec2<f32>(d.row.x, d.column.x), of_uv);
    let of_y = sl_along(vec2<f32>(d.row.y, d.column.y), of_uv);
    let of_z = sl_along(vec2<f32>(d.row.z, d.column.z), of_uv);
    return array(vec3<f32>(of_x.x, of_y.x, of_z.x), vec3<f32>(of_x.y, of_y.y, of_z.y));
}

fn sl_du3(x: vec3<f32>, u: f32, v: f32) -> vec3<f32> {
    return sl_slopes3(x, u, v)[0];
}

fn sl_dv3(x: vec3<f32>, u: f32, v: f32) -> vec3<f32> {
    return sl_slopes3(x, u, v)[1];
}

// The cross product of the ways to the next point of the row and of the column.
fn sl_spanned(p: vec3<f32>) -> vec3<f32> {
    let d = sl_differences(vec4<f32>(p, 0.0));
    return cross(d.row.xyz, d.column.xyz);
}

fn sl_area(p: vec3<f32>) -> f32 {
    let m = sl_spanned(p);
    return sqrt(dot(m, m));
}

fn sl_calculatenormal(p: vec3<f32>) -> vec3<f32> {
    return sl_spanned(p) * work.orientation;
}

@compute @workgroup_size(GROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = group.x + group.y * n_groups.x;
    if at >= arrayLength(&groups) {
        return;
    }
    lane = local;
    if local == 0u {
        work = sl_grid(groups[at].x);
    }
    workgroupBarrier();
    point = min(local, max(work.n, 1u) - 1u);
    shader_0(work.slots, local < work.n);
}
