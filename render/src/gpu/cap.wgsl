// The points of a tile of a sphere's cap, to the bit as the processor has them.
// in  caps   [13 n_caps]  of each: first raster point, first micropolygon, columns and rows of points; column and row of the first point from
//                         the middle, first of its rings, ring of the outline; what its micropolygons are, its track, moments, first row of
//                         the matrices; middle of the sphere, cosine of the outline's normals; direction to the eye, sine of these; two
//                         directions across, the first with 1 or −1 where normals point into the sphere, the second with the first point among
//                         those that are shaded; columns of the matrix to places, then of that to normals
// in  rings  [n_rings]    cosine and sine of the angle from the eye's direction
// in  disk   [32896]      cosine and sine of the points of an eighth of each ring of a disk
// Twin: gprim/sphere/tile.rs
#import exact

@group(0) @binding(0) var<storage, read> caps: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> rings: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read> disk: array<vec2<f32>>;

fn rounded3(v: vec3<f32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(bitcast<vec3<u32>>(v) ^ vec3<u32>(nothing()));
}

fn numbers(cap: u32, row: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(caps[13u * cap + row]);
}

// The sum of the columns of a matrix, which begin at a row, each times a number.
fn transformed(cap: u32, row: u32, v: vec3<f32>) -> vec3<f32> {
    let x = rounded3(numbers(cap, row).xyz * v.x);
    let y = rounded3(numbers(cap, row + 1u).xyz * v.y);
    let z = rounded3(numbers(cap, row + 2u).xyz * v.z);
    return rounded3(rounded3(x + y) + z);
}

// The direction of a point from the middle of a disk, and its ring.
struct OnDisk {
    direction: vec2<f32>,
    ring: u32,
}

fn on_disk(cap: u32, point: u32) -> OnDisk {
    let nu = caps[13u * cap].z;
    let at = bitcast<vec2<i32>>(caps[13u * cap + 1u].xy) + vec2<i32>(i32(point % nu), i32(point / nu));
    let far = max(abs(at.x), abs(at.y));
    let near = min(abs(at.x), abs(at.y));
    let own = disk[u32(far * (far + 1) / 2 + near)];
    let turned = select(own.yx, own, abs(at.x) >= abs(at.y));
    return OnDisk(select(turned, -turned, at < vec2<i32>()), u32(far));
}

// The lattice direction of a point of the disk at an angle from the eye's direction.
fn lattice_direction(cap: u32, on: OnDisk, angle: vec2<f32>) -> vec3<f32> {
    let across = rounded3(numbers(cap, 5u).xyz * on.direction.x);
    let up = rounded3(numbers(cap, 6u).xyz * on.direction.y);
    let side = rounded3(across + up);
    return rounded3(rounded3(numbers(cap, 4u).xyz * angle.x) + rounded3(side * angle.y));
}

fn angle_of(cap: u32, on: OnDisk) -> vec2<f32> {
    return rings[caps[13u * cap + 1u].z + on.ring];
}

// The place of a point in the world.
fn place_of(cap: u32, on: OnDisk) -> vec3<f32> {
    let direction = lattice_direction(cap, on, angle_of(cap, on));
    return rounded3(numbers(cap, 3u).xyz + transformed(cap, 7u, direction));
}

// The normal of a point.
fn normal_of(cap: u32, on: OnDisk) -> vec3<f32> {
    var angle = angle_of(cap, on);
    if on.ring >= caps[13u * cap + 1u].w {
        angle = vec2<f32>(numbers(cap, 3u).w, numbers(cap, 4u).w);
    }
    return transformed(cap, 10u, lattice_direction(cap, on, angle)) * numbers(cap, 5u).w;
}
