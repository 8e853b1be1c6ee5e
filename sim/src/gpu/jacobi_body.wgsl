// Projected Jacobi, second half of an iteration: the velocities of the bodies with the impulses γ, v_free + M⁻¹ D γ; and by the first workgroup, which
// has no bodies, whether another iteration follows, and its ω, which is halved where steps grow unless it is given.
// in    spin        [n_contacts]    what γ turns the bodies by, as in `spin.wgsl`
// in    gamma       [n_contacts]    N s, world
// in    free        [n_bodies]      m/s, rad/s
// in    side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
// in    side_start  [n_bodies]      first side of each body, and the end
// out   motion      [n_bodies]      m/s, rad/s
// in    mass        [n_bodies]      1/kg, and principal, 1/(kg m²)
// in    orientation [n_bodies]      at the step's start
// in    roll        [n_contacts]    N m s, world: rolling and spinning impulses on B
// in    parts       [n_groups]      residual terms of the last γ squared, m²/s²; |γ⁺ − γ|²/η and |γ|²/η, J; what of the terms is rounding, m²/s²
// inout scalars     [1]
// inout work        [5]             workgroups of an iteration over contacts and over bodies
// in    count       [1]             n_contacts
// in    params      [2]             as bits: tolerance (m/s); whether ω is given
// Twin: cpu/solve/jacobi.rs, cpu/solve/bodies.rs
#import sphere
#import body_spin
#import body_response
#import scalars
#import parts_total

@group(0) @binding(0) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> free: array<Body>;
@group(0) @binding(3) var<storage, read> side: array<u32>;
@group(0) @binding(4) var<storage, read> side_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(6) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> roll: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> parts: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(11) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(12) var<storage, read> count: array<u32>;
@group(0) @binding(13) var<storage, read> params: array<u32>;

// Growth of a step's square, and its share of the impulses' squares, that are more than rounding.
const GROWS: f32 = 1.000001;
const KNOWN: f32 = 1e-10;

fn decide(thread: u32) {
    let is_active = scalars[0].goes_on == 1u;
    let n_parts = select(0u, groups_of(count[0]), is_active);
    let sums = parts_total(thread, n_parts);
    if thread != 0u {
        return;
    }
    // The bodies' part of an iteration follows the one in which the solve ends.
    if !is_active {
        work[1] = vec4(0u, 0u, 1u, 0u);
        return;
    }
    var s = scalars[0];
    s.trials++;
    if params[1] == 0u {
        if sums.y > GROWS * s.last_step2 && sums.y > KNOWN * sums.z {
            s.omega *= 0.5;
        }
        s.last_step2 = sums.y;
    }
    let tolerance = bitcast<f32>(params[0]);
    let n = f32(blocks_of(count[0]));
    let has_converged = tolerance > 0.0 && sqrt(sums.x) / n <= max(tolerance, sqrt(sums.w) / n);
    if has_converged || s.trials >= s.limit {
        s.goes_on = 0u;
        work[0] = vec4(0u, 0u, 1u, 0u);
    }
    scalars[0] = s;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    if group.x == 0u && group.y == 0u {
        decide(thread);
        return;
    }
    let body = row_of(group, thread) - 256u;
    if body < arrayLength(&free) {
        motion[body] = body_row(response_of(body));
    }
}
