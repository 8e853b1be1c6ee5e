// Undo a step that was begun for the other method: nothing is solved, and the bodies stay where they are, as where there is no room.
// inout verdict  [2]  whether Gauss–Seidel takes over; whether the step is undone
// inout scalars  [1]
// out   work     [n]  workgroups of the method's iterations
// inout room     [3]  whether the step is made, second
// in    params   [2]  whether the step was begun for Gauss–Seidel; n
#import scalars

@group(0) @binding(0) var<storage, read_write> verdict: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> room: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    if verdict[0].x == params[0] || room[1] == 0u {
        return;
    }
    verdict[0].y = 1u;
    scalars[0].goes_on = 0u;
    for (var k = 0u; k < params[1]; k++) {
        work[k] = vec4(0u, 0u, 1u, 0u);
    }
    room[1] = 0u;
}
