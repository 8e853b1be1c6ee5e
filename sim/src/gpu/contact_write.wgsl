// Narrow phase, second pass: the contacts of the pairs that touch.
// in   position       [n_bodies]    fine units
// in   sphere         [n_spheres]
// in   fixture        [n_fixtures]
// in   pairs          [n_pairs]
// in   touching       [n_contacts]  the pair of each contact
// out  contact        [n_contacts]
// in   count          [1]           n_contacts
// in   params         [2]           n_materials, and as bits: unit of the scale (m)
// Twin: cpu/sphere_pairs.rs, Write
#import contact
#import touch

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> touching: array<u32>;
@group(0) @binding(5) var<storage, read_write> contact: array<Contact>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let pair = pairs[touching[k]];
    let sides = sides_of(pair);
    let found = touch(pair);
    let unit = bitcast<f32>(params[1]);
    let gap = found.w * unit;
    // Between spheres the point is in the middle of the gap; on a fixture that is not met yet, on the sphere.
    let is_held = pair.y >= arrayLength(&sphere);
    let away = select(0.5 * gap, 0.0, is_held && gap > 0.0);
    let reach = vec2<f32>(sides.radii) * unit + away;
    let is_swapped = sides.bodies.x > sides.bodies.y;
    contact[k].bodies = select(sides.bodies, sides.bodies.yx, is_swapped);
    contact[k].shapes = vec2(min(sides.shapes.x, sides.shapes.y), max(sides.shapes.x, sides.shapes.y));
    contact[k].normal = select(found.xyz, -found.xyz, is_swapped);
    contact[k].gap = gap;
    contact[k].reach = select(reach, reach.yx, is_swapped);
    let materials = select(sides.materials, sides.materials.yx, sides.shapes.x > sides.shapes.y);
    contact[k].law = materials.x * params[0] + materials.y;
    contact[k].feature = 0u;
    if is_held {
        contact[k].feature = feature_of_fixture(pair.y - arrayLength(&sphere));
    }
}
