// What one shader has found, in the range of an image, becomes what the next is given, and what it was given itself as it is: runs of numbers from the
// results or the values of a kernel to the values of another.
// in   runs     [n_runs]     first number among the results, first among the values, their number, 1 if they stay as they are
// in   results  [n_results]
// out  values   [n_values]
// in   params   [1]          count of runs
#import limited

@group(0) @binding(0) var<storage, read> runs: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> results: array<f32>;
@group(0) @binding(2) var<storage, read_write> values: array<f32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = group.x + group.y * 65535u;
    if at >= params[0] {
        return;
    }
    let run = runs[at];
    for (var k = thread; k < run.z; k += 64u) {
        let own = results[run.x + k];
        values[run.y + k] = select(limited(own), own, run.w == 1u);
    }
}
