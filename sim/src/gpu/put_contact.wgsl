// Leave a point of a pair, in the columns `contact` and `arms` of the kernel, for contact_finish.wgsl: the pair in place of the bodies, the
// points on both shapes in place of the arms.
#import contact
#import point

fn put_contact(at: u32, pair: vec2<u32>, point: Point) {
    contact[at] = Contact(pair, vec2(0u), point.normal, point.gap, vec2(0.0), 0u, point.feature);
    arms[at] = Arms(point.on_first, 0u, point.on_second, 0u);
}
