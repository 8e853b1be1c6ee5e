// Integrate the poses of the bodies with their new velocities, unless the step is undone.
// in    mass         [n_bodies]    1/kg, and principal, 1/(kg m²); zero for a body that does not move
// in    motion       [n_bodies]    m/s, rad/s: velocities at the step's end, world
// in    displaced    [2 n_bodies]  m/s: recovery of overlaps over h; J s: what keeps the angular momentum; a third, rad/s, where arms
//                                  are of any direction
// in    share        [1]           share of it that is made
// in    room         [2]           whether there was room for all pairs, second
// inout position     [n_bodies]    fine units
// inout orientation  [n_bodies]
// out   velocity     [n_bodies]    m/s, world
// out   spin         [n_bodies]    rad/s, in the bodies' frames
// in    activity     [n_bodies]
// in    params       [2]           as bits: h (s), 1 / fine unit (1/m)
// Twin: cpu/integrate.rs
#import sphere
#import solve_row
#import turn
#import displaced
#import spun

@group(0) @binding(0) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read> displaced: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> share: array<f32>;
@group(0) @binding(4) var<storage, read> room: array<u32>;
@group(0) @binding(5) var<storage, read_write> position: array<Fixed>;
@group(0) @binding(6) var<storage, read_write> orientation: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> velocity: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> spin: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> activity: array<u32>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    // An inactive body begins with the velocity that it has.
    if b >= arrayLength(&motion) || room[1] == 0u || activity[b] == INACTIVE {
        return;
    }
    if mass[b].x == 0.0 {
        velocity[b] = vec4(0.0);
        spin[b] = vec4(0.0);
        return;
    }
    let h = bitcast<f32>(params[0]);
    let units = bitcast<f32>(params[1]);
    let v = motion[b].v;
    var w = motion[b].w;
    var now = move_fixed(position[b], v * h * units);
    let part = share[0] * h;
    if part > 0.0 {
        now = move_fixed(now, displaced[DISPLACED * b].xyz * part * units);
        w -= turned_by(b, motion[b], displaced[DISPLACED * b + 1u].xyz * (0.5 * part));
    }
    position[b] = now;
    velocity[b] = vec4(v, 0.0);
    let after = spun(b, w, h, part);
    orientation[b] = after.orientation;
    spin[b] = vec4(after.spin, 0.0);
}
