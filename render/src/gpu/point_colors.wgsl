// The colours and opacities that shaders have found, by points, and how many are no finite numbers, or no opacities; a workgroup a grid.
// in    shaded     [2 n_grids]  of a grid: its first bit in `wanted`, count of its points, the first of them among all, count of those that have
//                               results; where these begin, the source that they are of and as the highest bit whether opacities are as given and not
//                               told of, 1 if all points have results and 0 if those that are wanted do, 0
// in    wanted     [n_points / 32]  a bit a point
// in    results    [n_results]  what the kernel of the shader has written
// out   colors     [n_points]
// out   opacities  [n_points]   if they are wanted
// inout lost       [7]          of the surface's shader and of the atmosphere's: points with what is no finite number, and the first source of
//                               these; points of the first with what is no number; points with opacities below 0 or above 1, and the first
//                               source of these
// in    params     [6]          count of grids; numbers that stand before the colour and the opacity, all bits if there is none; 1 if
//                               opacities are wanted; index of the shader; 1 if opacities are not changed any more
// Twin: cpu/shade.rs
#import limited
#import wanted

@group(0) @binding(0) var<storage, read> shaded: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> wanted: array<u32>;
@group(0) @binding(2) var<storage, read> results: array<f32>;
@group(0) @binding(3) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> opacities: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> lost: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

const NONE: u32 = 0xffffffffu;
const SIZE: u32 = 64u;

// Where a point stands: among all, its first number among the results and how far apart they are, its source.
struct Place {
    point: u32,
    result: u32,
    n: u32,
    named: u32,
}

fn found(at: Place, offset: u32) -> vec3<f32> {
    let first = at.result + offset * at.n;
    return vec3<f32>(results[first], results[first + at.n], results[first + 2u * at.n]);
}

fn is_lost(v: vec3<f32>) -> bool {
    return any((bitcast<vec3<u32>>(v) & vec3<u32>(0x7f800000u)) == vec3<u32>(0x7f800000u));
}

fn is_no_number(v: vec3<f32>) -> bool {
    return any((bitcast<vec3<u32>>(v) & vec3<u32>(0x7fffffffu)) > vec3<u32>(0x7f800000u));
}

// Whether opacities lie beyond 0 and 1 by more than rounding.
fn is_beyond(v: vec3<f32>) -> bool {
    return any(v < vec3<f32>(-1e-3)) || any(v > vec3<f32>(1.001));
}

fn take(at: Place) {
    let source = at.named & 0x7fffffffu;
    var lost_here = false;
    var no_number = false;
    if params[1] != NONE {
        let color = found(at, params[1]);
        colors[at.point] = vec4<f32>(limited(color.x), limited(color.y), limited(color.z), 1.0);
        lost_here = is_lost(color);
        no_number = is_no_number(color);
    }
    if params[2] != NONE {
        let opacity = found(at, params[2]);
        if params[3] == 1u {
            opacities[at.point] = vec4<f32>(limited(opacity.x), limited(opacity.y), limited(opacity.z), 1.0);
        }
        lost_here = lost_here || is_lost(opacity);
        no_number = no_number || is_no_number(opacity);
        if params[5] == 1u && at.named == source && is_beyond(opacity) {
            atomicAdd(&lost[5], 1u);
            atomicMin(&lost[6], source);
        }
    }
    if lost_here {
        atomicAdd(&lost[2u * params[4]], 1u);
        atomicMin(&lost[2u * params[4] + 1u], source);
    }
    if no_number && params[4] == 0u {
        atomicAdd(&lost[4], 1u);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let grid = group.x + group.y * 65535u;
    if grid >= params[0] {
        return;
    }
    let own = shaded[2u * grid];
    let more = shaded[2u * grid + 1u];
    for (var k = thread; k < own.y; k += SIZE) {
        if is_wanted(own.x + k) {
            let at = select(wanted_before(own.x, own.x + k), k, more.z == 1u);
            take(Place(own.z + k, more.x + at, own.w, more.y));
        }
    }
}
