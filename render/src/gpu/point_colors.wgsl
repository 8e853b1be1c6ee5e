// The colours that shaders have found, by points.
// in   shaded   [n_shaded]   point; where its first number stands among the results, and how far apart they are; 0
// in   results  [n_results]  what the kernel of the shader has written
// out  colors   [n_points]
// in   params   [1]          count of shaded points

@group(0) @binding(0) var<storage, read> shaded: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> results: array<f32>;
@group(0) @binding(2) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k >= params[0] {
        return;
    }
    let s = shaded[k];
    colors[s.x] = vec4<f32>(results[s.y], results[s.y + s.z], results[s.y + 2u * s.z], 1.0);
}
