// The box about all fat boxes.
// in    fat_aabb  [n_spheres]  m
// inout extent    [6]          minimum and maximum corner, as numbers in the order of the real ones
// in    count     [1]          n_spheres if pairs are to be found, else 0
#import sphere

@group(0) @binding(0) var<storage, read> fat_aabb: array<Aabb>;
@group(0) @binding(1) var<storage, read_write> extent: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

var<workgroup> low: array<atomic<u32>, 3>;
var<workgroup> high: array<atomic<u32>, 3>;

// A number in the order of the real ones.
fn ordered(x: f32) -> u32 {
    let word = bitcast<u32>(x);
    return select(word | 0x80000000u, ~word, word >= 0x80000000u);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    if thread < 3u {
        atomicStore(&low[thread], 0xffffffffu);
        atomicStore(&high[thread], 0u);
    }
    workgroupBarrier();
    let s = row_of(group, thread);
    if s < count[0] {
        let own = fat_aabb[s];
        if own.low.x <= own.high.x {
            for (var axis = 0u; axis < 3u; axis++) {
                atomicMin(&low[axis], ordered(own.low[axis]));
                atomicMax(&high[axis], ordered(own.high[axis]));
            }
        }
    }
    workgroupBarrier();
    if thread < 3u {
        atomicMin(&extent[thread], atomicLoad(&low[thread]));
        atomicMax(&extent[thread + 3u], atomicLoad(&high[thread]));
    }
}
