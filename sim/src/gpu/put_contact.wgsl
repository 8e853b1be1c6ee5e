// Write a contact of shapes of any kind to the columns `contact` and `arms` of the kernel.
// Twin: cpu/contact_rows.rs, cpu/contact_write.rs
#import contact
#import placed
#import kinds
#import triangle_id

// The contact at a point of a pair, whose normal is from the shape of the lower id; points are about an origin.
fn put_contact(at: u32, pair: vec2<u32>, point: Point, origin: Fixed, fine: f32, n_materials: u32) {
    var first = side_of(pair.x);
    var second = side_of(pair.y);
    if second.shape < first.shape {
        first = second;
        second = side_of(pair.x);
    }
    let is_swapped = first.body > second.body;
    let bodies = select(vec2(first.body, second.body), vec2(second.body, first.body), is_swapped);
    let on_a = select(point.on_first, point.on_second, is_swapped);
    let on_b = select(point.on_second, point.on_first, is_swapped);
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
    contact[at] = Contact(bodies, shapes, normal, point.gap, vec2(0.0), law, feature);
    let arm_a = middle - real_fixed(fine_difference(position[bodies.x], origin)) * fine;
    let arm_b = middle - real_fixed(fine_difference(position[bodies.y], origin)) * fine;
    arms[at] = Arms(arm_a, select(0u, 1u, is_face(pair.x) || is_face(pair.y)), arm_b, 0u);
}

// Whether a side of a pair is a shape with faces that moves.
fn is_face(at: u32) -> bool {
    return at < arrayLength(&sphere) && !is_ball(kind_at(at)) && activity[side_of(at).body] == MOVING;
}
