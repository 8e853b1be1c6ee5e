// Narrow phase, second pass: the contacts of the pairs that touch.
// in   position       [n_bodies]    steps of the scale
// in   sphere         [n_spheres]
// in   pairs          [n_pairs]
// in   touching       [n_contacts]  the pair of each contact
// out  contact        [n_contacts]
// in   count          [1]           n_contacts
// in   params         [2]           n_materials, and as bits: step of the scale (m)
// Twin: cpu/sphere_pairs.rs, Write
#import contact

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> touching: array<u32>;
@group(0) @binding(4) var<storage, read_write> contact: array<Contact>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let pair = pairs[touching[k]];
    let p = sphere[pair.x];
    let q = sphere[pair.y];
    let offset = subtract_fixed(position[q.body], position[p.body]);
    let found = normal_and_gap(offset, add64(vec2(p.radius, 0u), vec2(q.radius, 0u)));
    let step = bitcast<f32>(params[1]);
    let gap = found.w * step;
    let reach = vec2(f32(p.radius), f32(q.radius)) * step + 0.5 * gap;
    let is_swapped = p.body > q.body;
    contact[k].bodies = select(vec2(p.body, q.body), vec2(q.body, p.body), is_swapped);
    contact[k].shapes = vec2(p.shape, q.shape);
    contact[k].normal = select(found.xyz, -found.xyz, is_swapped);
    contact[k].gap = gap;
    contact[k].reach = select(reach, reach.yx, is_swapped);
    contact[k].law = p.material * params[0] + q.material;
    contact[k].pad = 0u;
}
