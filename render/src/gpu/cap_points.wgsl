// What shaders are given of points of tiles of spheres' caps: places, normals and ways from the eye; a workgroup a tile.
// in    caps, spheres, rings, disk   as cap.wgsl has them
// in    least   [n_caps]   the least depth of each tile, as bits
// in    given   [2 n]      of each: tile, count of its points that are shaded, its first point, the first number of P among the values, which N,
//                          I and, if it is given, Ng follow; first of the host's own numbers, 1 if Ng is given, 0, 0
// in    wanted  [n_points / 32]  the points that are shaded, a bit each
// out   values  [n_values]
// in    params  [14]       0 to 6: as raster.wgsl has them; first and count of what is given; then numbers: where the eye is, pixels for a unit
//                          at a depth of 1, the least depth
// Twin: cpu/shade.rs
#import cap
#import wanted

@group(0) @binding(4) var<storage, read> least: array<u32>;
@group(0) @binding(5) var<storage, read> given: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> wanted: array<u32>;
@group(0) @binding(7) var<storage, read_write> values: array<f32>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

const SIZE: u32 = 64u;

fn nothing() -> u32 {
    return params[6];
}

fn number(k: u32) -> f32 {
    return bitcast<f32>(params[k]);
}

// Put a triple among the values, as three runs of n.
fn put(first: u32, n: u32, v: vec3<f32>) {
    values[first] = v.x;
    values[first + n] = v.y;
    values[first + 2u * n] = v.z;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = group.x + group.y * 65535u;
    if k >= params[8] {
        return;
    }
    let own = given[2u * k];
    let more = given[2u * k + 1u];
    let eye = vec3<f32>(number(9u), number(10u), number(11u));
    let sphere = sphere_of(own.x);
    let size = size_of(own.x);
    for (var point = thread; point < size.x * size.y; point += SIZE) {
        if !is_wanted(own.z + point) {
            continue;
        }
        let i = wanted_before(own.z, own.z + point);
        let on = on_disk(own.x, point);
        let place = place_of(sphere, on);
        let normal = normal_of(sphere, on);
        put(own.w + i, own.y, place);
        put(own.w + 3u * own.y + i, own.y, normal);
        put(own.w + 6u * own.y + i, own.y, place - eye);
        if more.y == 1u {
            put(own.w + 9u * own.y + i, own.y, normal);
        }
    }
    if thread == 0u {
        // A surface does not shadow itself: how near a ray's start nothing is met.
        let bias = quotient(2.0, quotient(number(12u), max(bitcast<f32>(least[own.x]), number(13u))));
        values[more.x + 2u] = bias;
        values[more.x + 3u] = bias;
    }
}
