// What displays take of points besides colours.
// in   rows     [n_rows]     first number among the outputs; first among the results, how far apart they are there, and their count
// in   results  [n_results]  what the kernel of the shader has written, or what the host knows
// out  outputs  [n × points]
// in   params   [1]          count of rows
#import limited

@group(0) @binding(0) var<storage, read> rows: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> results: array<f32>;
@group(0) @binding(2) var<storage, read_write> outputs: array<f32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k >= params[0] {
        return;
    }
    let row = rows[k];
    for (var c = 0u; c < row.w; c += 1u) {
        outputs[row.x + c] = limited(results[row.y + c * row.z]);
    }
}
