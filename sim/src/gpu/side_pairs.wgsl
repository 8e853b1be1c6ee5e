// The two sides of each pair with their bodies.
// in   pairs      [n_pairs]
// in   sphere     [n_spheres]
// in   fixture    [n_fixtures]
// in   mass       [n_bodies]     1/kg, and principal, 1/(kg m²)
// out  body       [2 n_pairs]    body of each side; that of a body held in place comes after all others
// out  side       [2 n_pairs]    twice the pair, and one more for B, which has the greater id
// in   count      [1]            twice n_pairs if the sides are due, else 0
#import side

@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> body: array<u32>;
@group(0) @binding(5) var<storage, read_write> side: array<u32>;
@group(0) @binding(6) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = row_of(group, thread);
    if i >= count[0] {
        return;
    }
    let pair = pairs[i / 2u];
    let bodies = vec2(side_of(pair.x).body, side_of(pair.y).body);
    let own = select(min(bodies.x, bodies.y), max(bodies.x, bodies.y), (i & 1u) == 1u);
    body[i] = select(arrayLength(&mass), own, mass[own].x > 0.0);
    side[i] = i;
}
