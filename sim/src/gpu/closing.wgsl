// Gauss–Seidel: the greatest speed at which a gap closes by more than its width, once the iterations of the settings are done.
// in    rows     [n_contacts]
// in    motion   [n_bodies]  m/s, rad/s
// inout fastest  [1]         as bits, m/s; zero in
// in    count    [1]         n_contacts
// Twin: cpu/solve/sweeps.rs
#import sphere
#import project

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> fastest: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let row = rows[k];
    let opening = dot(gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]), row.normal);
    let closing = bitcast<u32>(max(-opening, 0.0));
    if closing > atomicLoad(&fastest[0]) {
        atomicMax(&fastest[0], closing);
    }
}
