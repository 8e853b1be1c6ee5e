// Solve the joints for what impulses have changed, by one workgroup: the multipliers λ with Bᵀ(Δv + M⁻¹Bλ) + Cλ = 0, and what these give
// the bodies. The kernel has `change_of`, Δv of a body, and `change_body`.
// in    joint_sizes  [5]          n_members, n_rows, n_phases, and the rows of the factor; rounds of a trial
// in    member       [n_members]  the bodies, and the sides of rows on them
// in    joint_side   [n_sides]    sorted by members
// in    joint_row    [n_rows]
// in    joint_phase  [n_phases + 1]  first row of each phase of a solve, and the end
// in    phase_row    [n_phase_rows]  row of b′ or, beyond those, of x; its terms: the first, and the end
// in    joint_term   [n_terms]    row and number
// in    joint_number [n_numbers]  of the factor
// inout joint_work   [2 n_factor] b′, x, where these do not fit the memory of the workgroup
// out   lambda       [n_rows]     N s, N m s; the second and third are those of the iterates x and y
// Twin: cpu/solve/joints.rs, cpu/solve/sparse/phases.rs

struct Member {
    body: u32,
    first: u32,
    end: u32,
    pad: u32,
}

// A row on one of its bodies: its Jacobian, and the velocities that a unit impulse along it gives.
struct JointSide {
    linear: vec3<f32>,
    row: u32,
    angular: vec3<f32>,
    body: u32,
    to_linear: vec3<f32>,
    pad: u32,
    to_angular: vec3<f32>,
    last: u32,
}

// The sides of a row on bodies that move, its place among the rows of the factor, and its compliance.
struct JointRow {
    sides: vec2<u32>,
    place: u32,
    softness: f32,
}

struct Twist {
    v: vec3<f32>,
    w: vec3<f32>,
}

@group(0) @binding(0) var<storage, read> joint_sizes: array<u32>;
@group(0) @binding(1) var<storage, read> member: array<Member>;
@group(0) @binding(2) var<storage, read> joint_side: array<JointSide>;
@group(0) @binding(3) var<storage, read> joint_row: array<JointRow>;
@group(0) @binding(4) var<storage, read> joint_phase: array<u32>;
@group(0) @binding(5) var<storage, read> phase_row: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> joint_term: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> joint_number: array<f32>;
@group(0) @binding(8) var<storage, read_write> joint_work: array<f32>;
@group(0) @binding(9) var<storage, read_write> lambda: array<vec4<f32>>;

const NO_SIDE: u32 = 0xffffffffu;

fn speed_of(side: u32) -> f32 {
    if side == NO_SIDE {
        return 0.0;
    }
    let own = joint_side[side];
    let change = change_of(own.body);
    return dot(own.linear, change.v) + dot(own.angular, change.w);
}

// b′ and x, where there are no more than this.
const FITS: u32 = 3584u;
var<workgroup> near_work: array<f32, 3584>;

fn does_fit() -> bool {
    return 2u * joint_sizes[3] <= FITS;
}

fn work_at(i: u32) -> f32 {
    if does_fit() {
        return near_work[i];
    }
    return joint_work[i];
}

fn put_work(i: u32, x: f32) {
    if does_fit() {
        near_work[i] = x;
    } else {
        joint_work[i] = x;
    }
}

// Wait until all have put theirs.
fn wait_for_work() {
    if does_fit() {
        workgroupBarrier();
    } else {
        storageBarrier();
    }
}

// What is left of the rows, as a right-hand side.
fn fill_rows(thread: u32) {
    for (var i = thread; i < joint_sizes[3]; i += 256u) {
        put_work(i, 0.0);
    }
    wait_for_work();
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        let row = joint_row[r];
        put_work(row.place, -(speed_of(row.sides.x) + speed_of(row.sides.y) + row.softness * lambda[r].x));
    }
    wait_for_work();
}

var<workgroup> row_sums: array<f32, 256>;

// A term of a row; none from the end of the row on.
fn term_of(t: u32, end: u32) -> f32 {
    let term = joint_term[min(t, end - 1u)];
    return select(0.0, work_at(term.x) * joint_number[term.y], t < end);
}

// Rows of a phase have few to hundreds of terms: where there are fewer rows than threads, several have a row to themselves, and sum its terms as
// a binary tree. A thread has four terms under way, so that it does not wait for each.
fn run_phases(thread: u32) {
    let n = joint_sizes[3];
    for (var p = 0u; p < joint_sizes[2]; p++) {
        let end = joint_phase[p + 1u];
        let fit = 256u / max(end - joint_phase[p], 1u);
        let lanes = clamp(1u << firstLeadingBit(max(fit, 1u)), 1u, 32u);
        let lane = thread % lanes;
        for (var first = joint_phase[p]; first < end; first += 256u / lanes) {
            let k = first + thread / lanes;
            var row = vec4(0u);
            var sum = 0.0;
            if k < end {
                row = phase_row[k];
                for (var t = row.y + lane; t < row.z; t += 4u * lanes) {
                    let first_two = term_of(t, row.z) + term_of(t + lanes, row.z);
                    sum += first_two + (term_of(t + 2u * lanes, row.z) + term_of(t + 3u * lanes, row.z));
                }
            }
            row_sums[thread] = sum;
            for (var step = 1u; step < lanes; step <<= 1u) {
                workgroupBarrier();
                if lane % (2u * step) == 0u {
                    row_sums[thread] += row_sums[thread + step];
                }
            }
            if k < end && lane == 0u {
                put_work(row.x, select(0.0, work_at(row.x), row.x < n) + row_sums[thread]);
            }
            wait_for_work();
        }
    }
}

// Solve; each round after the first takes away what rounding has left of the rows.
fn solve_joints(thread: u32, rounds: u32) {
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        lambda[r].x = 0.0;
    }
    solve_more(thread, rounds);
}

// Solve for what has changed since the multipliers that there are.
fn solve_more(thread: u32, rounds: u32) {
    for (var round = 0u; round < rounds; round++) {
        fill_rows(thread);
        run_phases(thread);
        for (var r = thread; r < joint_sizes[1]; r += 256u) {
            let more = work_at(joint_sizes[3] + joint_row[r].place);
            lambda[r].x += more;
            lambda[r].w = more;
        }
        storageBarrier();
        for (var m = thread; m < joint_sizes[0]; m += 256u) {
            var change = Twist(vec3(0.0), vec3(0.0));
            for (var s = member[m].first; s < member[m].end; s++) {
                let own = joint_side[s];
                change.v += own.to_linear * lambda[own.row].w;
                change.w += own.to_angular * lambda[own.row].w;
            }
            change_body(member[m].body, change);
        }
        storageBarrier();
    }
}
