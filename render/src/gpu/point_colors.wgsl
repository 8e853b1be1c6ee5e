// The colours and opacities that shaders have found, by points, and how many are no finite numbers.
// in    shaded     [n_shaded]   point; where its first number stands among the results, and how far apart they are; the source that it is of
// in    results    [n_results]  what the kernel of the shader has written
// out   colors     [n_points]
// out   opacities  [n_points]   if they are wanted
// inout lost       [2 n]        of each shader: points with what is no finite number, and the first source of these
// in    params     [5]          count of shaded points; numbers that stand before the colour and the opacity, all bits if there is none; 1 if
//                               opacities are wanted; index of the shader

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

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k >= params[0] {
        return;
    }
    let s = shaded[k];
    var lost_here = false;
    if params[1] != NONE {
        let color = found(s, params[1]);
        colors[s.x] = vec4<f32>(color, 1.0);
        lost_here = is_lost(color);
    }
    if params[2] != NONE {
        let opacity = found(s, params[2]);
        if params[3] == 1u {
            opacities[s.x] = vec4<f32>(opacity, 1.0);
        }
        lost_here = lost_here || is_lost(opacity);
    }
    if lost_here {
        atomicAdd(&lost[2u * params[4]], 1u);
        atomicMin(&lost[2u * params[4] + 1u], s.w);
    }
}
