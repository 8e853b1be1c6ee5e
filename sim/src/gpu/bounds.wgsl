// Margin of each sphere; whether one has left its fat box, so that the pairs are found again, and for how many steps like this one all will
// be in theirs.
// in    position  [n_bodies]   fine units
// in    velocity  [n_bodies]   m/s
// in    activity  [n_bodies]
// in    sphere    [n_spheres]
// in    fat_aabb  [n_spheres]  m
// out   margin    [n_spheres]  m, distance within which contacts are generated: δ + |v| h
// inout left      [1]          not zero if a tight box has left its fat one
// inout lasts     [1]          as bits: the least number of steps so far
// in    orientation, spin [n_bodies]  rad/s, in the bodies' frames
// in    solid     [n_spheres]  where shapes are of any kind
// in    params    [4]          n_spheres, and as bits: δ (m), h (s), unit of the scale (m)
// Twin: cpu/bounds.rs
#import shape_box

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> activity: array<u32>;
@group(0) @binding(3) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(4) var<storage, read> fat_aabb: array<Aabb>;
@group(0) @binding(5) var<storage, read_write> margin: array<f32>;
@group(0) @binding(6) var<storage, read_write> left: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> lasts: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> solid: array<Solid>;
@group(0) @binding(11) var<storage, read> params: array<u32>;

// The most steps that are told apart.
const MOST_STEPS: f32 = 1e6;

var<workgroup> least: atomic<u32>;

// The number of steps for which a sphere will be in its fat box; less than none if it has left it.
fn steps_of(s: u32) -> f32 {
    let body = sphere[s].body;
    let step = bitcast<f32>(params[2]);
    let turning = surface_speed(s);
    let own = bitcast<f32>(params[1]) + (length(velocity[body].xyz) + turning) * step;
    margin[s] = own;
    if activity[body] == INACTIVE {
        return MOST_STEPS;
    }
    let tight = shape_box(s, own, bitcast<f32>(params[3]));
    let fat = fat_aabb[s];
    let is_inside = all(fat.low.xyz <= tight.low.xyz) && all(tight.high.xyz <= fat.high.xyz);
    if !is_inside {
        return -1.0;
    }
    let room = min(tight.low.xyz - fat.low.xyz, fat.high.xyz - tight.high.xyz);
    let way = (abs(velocity[body].xyz) + turning) * step;
    let steps = select(room / way, vec3(MOST_STEPS), room >= way * MOST_STEPS);
    return min(steps.x, min(steps.y, steps.z));
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let s = row_of(group, thread);
    if thread == 0u {
        atomicStore(&least, bitcast<u32>(MOST_STEPS));
    }
    workgroupBarrier();
    if s < params[0] {
        let steps = steps_of(s);
        if steps < 0.0 {
            atomicOr(&left[0], 1u);
        }
        // Positive numbers are in the order of their bits.
        atomicMin(&least, bitcast<u32>(max(steps, 0.0)));
    }
    workgroupBarrier();
    if thread == 0u && bitcast<f32>(atomicLoad(&least)) < MOST_STEPS {
        atomicMin(&lasts[0], atomicLoad(&least));
    }
}
