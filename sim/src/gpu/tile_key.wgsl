// The tile of each pair. Space is cut into cubes in several ways; a pair belongs to the first in which both of its bodies are in one cube.
// Four ways are shifted by a quarter of a cube along all axes at once, one from the next: an axis can part a pair that is no longer than a
// quarter in one of them alone, so that the three axes leave it one. Where pairs are longer, there are eight ways, which combine cuts along each
// axis that are half a cube from each other. A body that is held in place fits every tile.
// in   pairs     [n_pairs]
// in   sphere    [n_spheres]
// in   fixture   [n_fixtures]
// in   activity  [n_bodies]
// in   home      [n_bodies]   the first sphere of a body
// in   fat_aabb  [n_spheres]  m
// in   grid      [3]          bits of a bin's coordinates
// out  key       [n_pairs]    round and cube; that of pairs in no tile comes after all others
// out  id        [n_pairs]    the pair
// in   count     [1]          n_pairs if they are to be put into tiles, else 0
// in   params    [4]          bits of the index of a cube; as bits its edge (m); bits of the number of least bins along it; number of ways
// Twin: cpu/pair_write.rs
#import side

@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> activity: array<u32>;
@group(0) @binding(4) var<storage, read> home: array<u32>;
@group(0) @binding(5) var<storage, read> fat_aabb: array<Aabb>;
@group(0) @binding(6) var<storage, read> grid: array<u32>;
@group(0) @binding(7) var<storage, read_write> key: array<u32>;
@group(0) @binding(8) var<storage, read_write> id: array<u32>;
@group(0) @binding(9) var<storage, read> count: array<u32>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

// Where a body is, in cubes.
fn place_of(body: u32) -> vec3<f32> {
    let own = fat_aabb[home[body]];
    return (own.low.xyz + own.high.xyz) * (0.5 / bitcast<f32>(params[1]));
}

// Rounds by the way to cut each axis: first none is shifted, then all, then some.
fn round_of(shifted: vec3<bool>) -> u32 {
    let code = dot(vec3<u32>(shifted), vec3(1u, 2u, 4u));
    return select(select(code + 1u, 1u, code == 7u), 0u, code == 0u);
}

// The key of the cube of a place. The indices of cubes repeat, as those of bins do, and what falls together is one tile.
fn key_of(round: u32, place: vec3<f32>) -> u32 {
    let bits = vec3(grid[0], grid[1], grid[2]) - params[2];
    let at = vec3<u32>(vec3<i32>(floor(place))) & ((vec3(1u) << bits) - 1u);
    return (round << params[0]) | at.x | (at.y | at.z << bits.y) << bits.x;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    id[k] = k;
    var a = side_of(pairs[k].x).body;
    var b = side_of(pairs[k].y).body;
    if activity[a] != MOVING {
        a = b;
    }
    if activity[b] != MOVING {
        b = a;
    }
    let p = place_of(a);
    let q = place_of(b);
    if params[3] == 4u {
        for (var way = 0u; way < 4u; way++) {
            let shift = 0.25 * f32(way);
            if all(floor(p + shift) == floor(q + shift)) {
                key[k] = key_of(way, p + shift);
                return;
            }
        }
        key[k] = 8u << params[0];
        return;
    }
    let plain = floor(p) == floor(q);
    let shifted = floor(p + 0.5) == floor(q + 0.5);
    if !all(plain | shifted) {
        key[k] = 8u << params[0];
        return;
    }
    let way = select(select(!plain, vec3(true), all(shifted)), vec3(false), all(plain));
    key[k] = key_of(round_of(way), p + select(vec3(0.0), vec3(0.5), way));
}
