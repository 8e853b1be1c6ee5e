// The memory of the workgroups of 128 that sweep tiles.

const THREADS: u32 = 128u;
// The place of a body that is held.
const NOWHERE: u32 = 0xffffu;

// Velocities of the tile's bodies with their reciprocal masses, and angular velocities; of spheres with reciprocal moments of inertia.
var<workgroup> linear: array<vec4<f32>, 480>;
var<workgroup> angular: array<vec4<f32>, 480>;

var<workgroup> sums: array<f32, 128>;

// The sum of a term over the threads of the workgroup, in thread 0. All threads call it.
fn tile_total(thread: u32, term: f32) -> f32 {
    sums[thread] = term;
    for (var step = 1u; step < THREADS; step <<= 1u) {
        workgroupBarrier();
        if thread % (2u * step) == 0u {
            sums[thread] += sums[thread + step];
        }
    }
    return sums[thread];
}
