// Dice tiles of spheres' caps: their points on the raster, at each moment, and their micropolygons; a workgroup a tile. One that is beside the
// window or hidden behind what is there has no micropolygons: they are there, without points of a row.
// in    caps, spheres, rings, disk   as cap.wgsl has them
// in    matrices       [4 n_matrices]     columns of matrices to camera space
// in    block_depth    [n_blocks]         the key of the greatest depth in blocks of 4 by 4 pixels
// out   points         [n_points]         raster x and y, pixels, and depth
// out   micropolygons  [n_micropolygons]  first point, points of a row, what it is, its track
// inout least          [n_caps]           the least depth of each, as bits
// inout left_out       [2]                tiles that are hidden, micropolygons that are not there
// in    params         [18]               first pixel's column and row; width and height, pixels; 0 to 6: as raster.wgsl has them; first tile and
//                                         count of tiles; 1 if block_depth is to be looked at; then numbers: the least and the greatest depth,
//                                         raster point of the axis, pixels for a unit of x/z and y/z, reach of the lens and one over the
//                                         depth that is sharp, or 0
// Twin: cpu/raster.rs
#import cap

@group(0) @binding(4) var<storage, read> matrices: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> block_depth: array<u32>;
@group(0) @binding(6) var<storage, read_write> points: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> micropolygons: array<vec4<u32>>;
@group(0) @binding(8) var<storage, read_write> least: array<u32>;
@group(0) @binding(9) var<storage, read_write> left_out: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

const SIZE: u32 = 64u;
// As in cpu/raster.rs: of a sum of this size the last place is worth a step.
const SHIFT: f32 = 12288.0;

var<workgroup> low: array<atomic<i32>, 2>;
var<workgroup> high: array<atomic<i32>, 2>;
var<workgroup> nearest: atomic<u32>;
// A bit a point, of 144 at most: whether it is behind the near plane at some moment.
var<workgroup> behind: array<atomic<u32>, 8>;
var<workgroup> in_front: atomic<u32>;

fn nothing() -> u32 {
    return params[6];
}

fn number(k: u32) -> f32 {
    return bitcast<f32>(params[k]);
}

fn to_camera(matrix: u32, p: vec3<f32>) -> vec3<f32> {
    let x = rounded3(matrices[matrix].xyz * p.x);
    let y = rounded3(matrices[matrix + 1u].xyz * p.y);
    let z = rounded3(matrices[matrix + 2u].xyz * p.z);
    return rounded3(matrices[matrix + 3u].xyz + rounded3(z + rounded3(y + x)));
}

// The place on the raster, on steps of 1/1024 pixel.
fn project(p: vec3<f32>) -> vec2<f32> {
    let k = quotient(1.0, p.z);
    let x = number(12u) + rounded(rounded(p.x * k) * number(14u));
    let y = number(13u) - rounded(rounded(p.y * k) * number(15u));
    return vec2<f32>(rounded(rounded(x) + SHIFT) - SHIFT, rounded(rounded(y) + SHIFT) - SHIFT);
}

fn confusion(z: f32) -> f32 {
    return abs(number(16u) * (number(17u) - 1.0 / max(z, number(10u))));
}

fn project_points(cap: u32, thread: u32) {
    let first = caps[2u * cap].x;
    let sphere = sphere_of(cap);
    let moments = spheres[11u * sphere].zw;
    let size = size_of(cap);
    let n = size.x * size.y;
    for (var k = thread; k < n; k += SIZE) {
        let place = place_of(sphere, on_disk(cap, k));
        for (var moment = 0u; moment < moments.x; moment += 1u) {
            let p = to_camera(moments.y + 4u * moment, place);
            let at = first + moment * n + k;
            if !(p.z >= number(10u)) {
                points[at] = vec4<f32>(0.0, 0.0, bitcast<f32>(0xff800000u | nothing()), 0.0);
                atomicOr(&behind[k >> 5u], 1u << (k & 31u));
                continue;
            }
            let r = project(p);
            points[at] = vec4<f32>(r, p.z, 0.0);
            let spread = confusion(p.z);
            let begin = vec2<i32>(floor(clamp(r - spread, vec2<f32>(-1e6), vec2<f32>(1e6))));
            let end = vec2<i32>(ceil(clamp(r + spread, vec2<f32>(-1e6), vec2<f32>(1e6))));
            atomicMin(&low[0], begin.x);
            atomicMin(&low[1], begin.y);
            atomicMax(&high[0], end.x);
            atomicMax(&high[1], end.y);
            atomicMin(&nearest, bitcast<u32>(p.z));
        }
    }
}

fn key_of(z: f32) -> u32 {
    let bits = bitcast<u32>(z);
    return bits ^ select(0x80000000u, 0xffffffffu, (bits & 0x80000000u) != 0u);
}

// Look at some of the blocks of the window that the tile is over: whether it may be visible there.
fn look(thread: u32) {
    let z = bitcast<f32>(atomicLoad(&nearest));
    if !(z <= number(11u)) {
        return;
    }
    // A pixel of room for what the edges of triangles are taken wider.
    let corner = vec2<i32>(bitcast<i32>(params[0]), bitcast<i32>(params[1]));
    let begin = vec2<i32>(atomicLoad(&low[0]), atomicLoad(&low[1])) - 1 - corner;
    let end = vec2<i32>(atomicLoad(&high[0]), atomicLoad(&high[1])) + 1 - corner;
    let size = vec2<i32>(i32(params[2]), i32(params[3]));
    if any(end < vec2<i32>()) || any(begin >= size) {
        return;
    }
    if params[9] == 0u {
        atomicStore(&in_front, 1u);
        return;
    }
    let first = vec2<u32>(max(begin, vec2<i32>())) / 4u;
    let last = vec2<u32>(min(end, size - 1)) / 4u;
    let columns = (params[2] + 3u) / 4u;
    let across = last.x - first.x + 1u;
    let n = across * (last.y - first.y + 1u);
    let key = key_of(z);
    for (var k = thread; k < n; k += SIZE) {
        if block_depth[(first.y + k / across) * columns + first.x + k % across] >= key {
            atomicStore(&in_front, 1u);
            return;
        }
    }
}

fn is_behind(k: u32) -> bool {
    return (atomicLoad(&behind[k >> 5u]) >> (k & 31u) & 1u) == 1u;
}

fn write_micropolygons(cap: u32, thread: u32) {
    let head = caps[2u * cap];
    let flags = caps[2u * cap + 1u].w;
    let size = size_of(cap);
    let across = size.x - 1u;
    let n = across * (size.y - 1u);
    let is_hidden = atomicLoad(&in_front) == 0u;
    for (var k = thread; k < n; k += SIZE) {
        let corner = k / across * size.x + k % across;
        let is_cut = is_behind(corner) || is_behind(corner + 1u) || is_behind(corner + size.x)
            || is_behind(corner + size.x + 1u);
        let nu = select(size.x, 0u, is_hidden || is_cut);
        micropolygons[head.y + k] = vec4<u32>(head.z + corner, nu, flags, head.w);
        if nu == 0u && !is_hidden {
            atomicAdd(&left_out[1], 1u);
        }
    }
    if thread == 0u {
        least[cap] = atomicLoad(&nearest);
        if is_hidden {
            atomicAdd(&left_out[0], 1u);
            atomicAdd(&left_out[1], n);
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = group.x + group.y * 65535u;
    let is_there = k < params[8];
    let cap = params[7] + k;
    if thread == 0u {
        for (var c = 0u; c < 2u; c += 1u) {
            atomicStore(&low[c], 0x7fffffff);
            atomicStore(&high[c], -0x7fffffff);
        }
        atomicStore(&nearest, 0x7f800000u);
        atomicStore(&in_front, 0u);
    }
    if thread < 8u {
        atomicStore(&behind[thread], 0u);
    }
    workgroupBarrier();
    if is_there {
        project_points(cap, thread);
    }
    workgroupBarrier();
    if is_there {
        look(thread);
    }
    workgroupBarrier();
    if is_there {
        write_micropolygons(cap, thread);
    }
}
