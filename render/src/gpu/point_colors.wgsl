// The colours and opacities that shaders have found, by points, and how many are no finite numbers, or no opacities.
// in    shaded     [n_shaded]   point; where its first number stands among the results, and how far apart they are; the source that it is of, and
//                               as the highest bit whether its opacity is as given and not told of
// in    results    [n_results]  what the kernel of the shader has written
// out   colors     [n_points]
// out   opacities  [n_points]   if they are wanted
// inout lost       [7]          of the surface's shader and of the atmosphere's: points with what is no finite number, and the first source of
//                               these; points of the first with what is no number; points with opacities below 0 or above 1, and the first
//                               source of these
// in    params     [6]          count of shaded points; numbers that stand before the colour and the opacity, all bits if there is none; 1 if
//                               opacities are wanted; index of the shader; 1 if opacities are not changed any more
// Twin: cpu/shade.rs
#import limited

@group(0) @binding(0) var<storage, read> shaded: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> results: array<f32>;
@group(0) @binding(2) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> opacities: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> lost: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

const NONE: u32 = 0xffffffffu;

fn found(s: vec4<u32>, offset: u32) -> vec3<f32> {
    let first = s.y + offset * s.z;
    return vec3<f32>(results[first], results[first + s.z], results[first + 2u * s.z]);
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

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k >= params[0] {
        return;
    }
    let s = shaded[k];
    let source = s.w & 0x7fffffffu;
    var lost_here = false;
    var no_number = false;
    if params[1] != NONE {
        let color = found(s, params[1]);
        colors[s.x] = vec4<f32>(limited(color.x), limited(color.y), limited(color.z), 1.0);
        lost_here = is_lost(color);
        no_number = is_no_number(color);
    }
    if params[2] != NONE {
        let opacity = found(s, params[2]);
        if params[3] == 1u {
            opacities[s.x] = vec4<f32>(limited(opacity.x), limited(opacity.y), limited(opacity.z), 1.0);
        }
        lost_here = lost_here || is_lost(opacity);
        no_number = no_number || is_no_number(opacity);
        if params[5] == 1u && s.w == source && is_beyond(opacity) {
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
