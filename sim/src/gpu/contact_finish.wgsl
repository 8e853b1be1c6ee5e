// The contacts of shapes of any kind, of the points of their pairs: bodies, shapes and law, and the arms. A kernel of its own, so that the
// narrow phases keep nothing of it in registers.
// in    position    [n_bodies]    fine units
// in    sphere      [n_spheres]
// in    solid       [n_spheres]
// in    fixture     [n_fixtures]
// in    activity    [n_bodies]
// inout contact     [n_contacts]  the pair in place of the bodies in, with its normal from the first shape to the second
// inout arms        [n_contacts]  m: the points on both shapes about the centre of mass of the pair's first body in
// in    n_contacts  [1]
// in    params      [2]           n_materials, and as bits: fine unit (m)
// Twin: cpu/contact_rows.rs, cpu/contact_write.rs
#import contact
#import side
#import kinds
#import triangle_id

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> solid: array<Solid>;
@group(0) @binding(3) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(4) var<storage, read> activity: array<u32>;
@group(0) @binding(5) var<storage, read_write> contact: array<Contact>;
@group(0) @binding(6) var<storage, read_write> arms: array<Arms>;
@group(0) @binding(7) var<storage, read> n_contacts: array<u32>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= n_contacts[0] {
        return;
    }
    let point = contact[k];
    let own = arms[k];
    let pair = point.bodies;
    let origin = position[sphere[pair.x].body];
    let n_materials = params[0];
    let fine = bitcast<f32>(params[1]);
    var first = side_of(pair.x);
    var second = side_of(pair.y);
    if second.shape < first.shape {
        first = second;
        second = side_of(pair.x);
    }
    let is_swapped = first.body > second.body;
    let bodies = select(vec2(first.body, second.body), vec2(second.body, first.body), is_swapped);
    let on_a = select(own.a, own.b, is_swapped);
    let on_b = select(own.b, own.a, is_swapped);
    // In the middle of the gap; on the body that moves where the other does not and they have not met yet.
    let moves = vec2(activity[bodies.x] == MOVING, activity[bodies.y] == MOVING);
    var middle = 0.5 * (on_a + on_b);
    if point.gap > 0.0 && moves.x != moves.y {
        middle = select(on_b, on_a, moves.x);
    }
    let normal = select(point.normal, -point.normal, is_swapped);
    let shapes = vec2(first.shape, second.shape);
    let law = first.material * n_materials + second.material;
    var feature = point.feature;
    if pair.y >= arrayLength(&sphere) {
        feature ^= feature_of_fixture(pair.y - arrayLength(&sphere));
    }
    contact[k] = Contact(bodies, shapes, normal, point.gap, vec2(0.0), law, feature);
    let arm_a = middle - real_fixed(fine_difference(position[bodies.x], origin)) * fine;
    let arm_b = middle - real_fixed(fine_difference(position[bodies.y], origin)) * fine;
    arms[k] = Arms(arm_a, select(0u, 1u, is_face(pair.x) || is_face(pair.y)), arm_b, 0u);
}

// Whether a side of a pair is a shape with faces that moves.
fn is_face(at: u32) -> bool {
    return at < arrayLength(&sphere) && !is_ball(kind_at(at)) && activity[side_of(at).body] == MOVING;
}
