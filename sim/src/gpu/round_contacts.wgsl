// Narrow phase of the pairs of spheres among shapes of any kind: count, then write, their contact points. Pairs that are not round have
// none yet after the first pass.
// in    position     [n_bodies]    fine units
// in    orientation  [n_bodies]
// in    sphere       [n_spheres]
// in    solid        [n_spheres]
// in    fixture      [n_fixtures]
// in    margin       [n_spheres]   m
// in    pairs        [n_pairs]
// inout place        [n_pairs + 1] number of points of each pair out when counting; contacts of the pairs before it in when writing
// out   contact      [n_contacts]  when writing: see put_contact.wgsl
// out   arms         [n_contacts]  m, when writing
// in    n_contacts   [1]           0 where there is no room for all
// in    count        [1]           n_pairs
// in    params       [2]           as bits: margin of the fixtures (m), unit of the scale (m)
// Twin: cpu/contact_write.rs, cpu/collide/round.rs
#import touch
#import placed
#import put_contact
#import kinds
#import pair_pass

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(3) var<storage, read> solid: array<Solid>;
@group(0) @binding(4) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(5) var<storage, read> margin: array<f32>;
@group(0) @binding(6) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> place: array<u32>;
@group(0) @binding(8) var<storage, read_write> contact: array<Contact>;
@group(0) @binding(9) var<storage, read_write> arms: array<Arms>;
@group(0) @binding(10) var<storage, read> n_contacts: array<u32>;
@group(0) @binding(11) var<storage, read> count: array<u32>;
@group(0) @binding(12) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let pair = pairs[k];
    let first = place[k];
    if !is_round(pair) {
        if !WRITES {
            place[k] = 0u;
        }
        return;
    }
    if WRITES && (place[k + 1u] == first || place[k + 1u] > n_contacts[0]) {
        return;
    }
    let at = touch(pair);
    let gap = at.w * bitcast<f32>(params[1]);
    if !WRITES {
        var other = bitcast<f32>(params[0]);
        if pair.y < arrayLength(&sphere) {
            other = margin[pair.y];
        }
        place[k] = select(0u, 1u, is_met(pair, at.w, (margin[pair.x] + other) / bitcast<f32>(params[1])));
        return;
    }
    let radius = solid[pair.x].half.x;
    found[0] = Point(at.xyz, at.xyz * radius, at.xyz * (radius + gap), gap, 0u);
    if side_of(pair.y).shape < side_of(pair.x).shape {
        swap_shapes(1u);
    }
    put_contact(first, pair, found[0]);
}
