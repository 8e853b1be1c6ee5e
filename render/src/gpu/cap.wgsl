// The points of a tile of a sphere's cap, to the bit as the processor has them.
// in  caps     [2 n_caps]      of each: first raster point, first micropolygon, first point among those that are shaded, track; column and row of
//                              the first point from the middle, columns and rows of points, both of 16 bits, its sphere, what its micropolygons are
// in  spheres  [11 n_spheres]  of each: first of its rings, ring of the outline, moments, first row of the matrices; middle of the sphere, cosine of
//                              the outline's normals; direction to the eye, sine of these; two directions across, the first with 1 or −1 where normals
//                              point into the sphere; columns of the matrix to places, then of that to normals
// in  rings    [n_rings]       cosine and sine of the angle from the eye's direction
// in  disk     [32896]         cosine and sine of the points of an eighth of each ring of a disk
// Twin: gprim/sphere/tile.rs
#import exact

@group(0) @binding(0) var<storage, read> caps: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> spheres: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> rings: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> disk: array<vec2<f32>>;

fn rounded3(v: vec3<f32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(bitcast<vec3<u32>>(v) ^ vec3<u32>(nothing()));
}

// Columns and rows of a tile's points.
fn size_of(cap: u32) -> vec2<u32> {
    let size = caps[2u * cap + 1u].y;
    return vec2<u32>(size & 0xffffu, size >> 16u);
}

fn sphere_of(cap: u32) -> u32 {
    return caps[2u * cap + 1u].z;
}

fn numbers(sphere: u32, row: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(spheres[11u * sphere + row]);
}

// The sum of the columns of a matrix, which begin at a row, each times a number.
fn transformed(sphere: u32, row: u32, v: vec3<f32>) -> vec3<f32> {
    let x = rounded3(numbers(sphere, row).xyz * v.x);
    let y = rounded3(numbers(sphere, row + 1u).xyz * v.y);
    let z = rounded3(numbers(sphere, row + 2u).xyz * v.z);
    return rounded3(rounded3(x + y) + z);
}

// The direction of a point from the middle of a disk, and its ring.
struct OnDisk {
    direction: vec2<f32>,
    ring: u32,
}

fn on_disk(cap: u32, point: u32) -> OnDisk {
    let nu = size_of(cap).x;
    let first = bitcast<i32>(caps[2u * cap + 1u].x);
    let at = vec2<i32>((first << 16u) >> 16u, first >> 16u) + vec2<i32>(i32(point % nu), i32(point / nu));
    let far = max(abs(at.x), abs(at.y));
    let near = min(abs(at.x), abs(at.y));
    let own = disk[u32(far * (far + 1) / 2 + near)];
    let turned = select(own.yx, own, abs(at.x) >= abs(at.y));
    return OnDisk(select(turned, -turned, at < vec2<i32>()), u32(far));
}

// The lattice direction of a point of the disk at an angle from the eye's direction.
fn lattice_direction(sphere: u32, on: OnDisk, angle: vec2<f32>) -> vec3<f32> {
    let across = rounded3(numbers(sphere, 3u).xyz * on.direction.x);
    let up = rounded3(numbers(sphere, 4u).xyz * on.direction.y);
    let side = rounded3(across + up);
    return rounded3(rounded3(numbers(sphere, 2u).xyz * angle.x) + rounded3(side * angle.y));
}

fn angle_of(sphere: u32, on: OnDisk) -> vec2<f32> {
    return rings[spheres[11u * sphere].x + on.ring];
}

// The place of a point in the world.
fn place_of(sphere: u32, on: OnDisk) -> vec3<f32> {
    let direction = lattice_direction(sphere, on, angle_of(sphere, on));
    return rounded3(numbers(sphere, 1u).xyz + transformed(sphere, 5u, direction));
}

// The normal of a point.
fn normal_of(sphere: u32, on: OnDisk) -> vec3<f32> {
    var angle = angle_of(sphere, on);
    if on.ring >= spheres[11u * sphere].y {
        angle = vec2<f32>(numbers(sphere, 1u).w, numbers(sphere, 2u).w);
    }
    return transformed(sphere, 8u, lattice_direction(sphere, on, angle)) * numbers(sphere, 3u).w;
}
