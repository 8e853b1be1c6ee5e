// Broad phase: count, then write, every pair of spheres that may touch within their fat boxes, once, and every pair of a sphere and a fixture. A pair of
// one level is found from the bin that comes first, one of two levels from the smaller box. Fixtures are few: each sphere is tested
// against each.
// in    fat_aabb   [n_spheres]  m
// in    sphere     [n_spheres]
// in    activity   [n_bodies]
// in    bin_shape  [n_spheres]  sorted by bin
// in    bin_start  [n_bins]
// in    fixture    [n_fixtures] then the triangles of surfaces
// in    fixture_aabb [n_fixtures] m
// in    rules      [n_groups² + 2 n_exclusions]  whether groups pass; pairs of bodies without contacts, sorted
// in    state      [3]          mask of the levels that are used (2), n_spheres if pairs are to be found, else 0
// inout pair_start [n_spheres + 1]  pairs of each sphere out when counting; the first pair of each, and the end, in when writing
// out   pair       [n_pairs]    the lower sphere first, or a sphere and n_spheres plus a fixture; when writing
// out   room       [2]          number of pairs that room is needed for, and whether there is room, when writing
// out   n_pairs    [1]          number of pairs, 0 where there is no room for all; when writing
// in    grid       [3]          bits of a bin's coordinates
// in    node       [n_nodes]    boxes about the triangles of surfaces
// in    params     [4]          n_groups, n_exclusions, n_fixtures (but for triangles), and as bits 1 / unit of the scale (1/m)
// Twin: cpu/pair_write.rs
#import sphere
#import fixture
#import bins
#import node
#import surfaces
#import pair_pass

@group(0) @binding(0) var<storage, read> fat_aabb: array<Aabb>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> activity: array<u32>;
@group(0) @binding(3) var<storage, read> bin_shape: array<u32>;
@group(0) @binding(4) var<storage, read> bin_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(6) var<storage, read> fixture_aabb: array<Aabb>;
@group(0) @binding(7) var<storage, read> rules: array<u32>;
@group(0) @binding(8) var<storage, read> levels: array<u32>;
@group(0) @binding(9) var<storage, read> count: array<u32>;
@group(0) @binding(10) var<storage, read_write> pair_start: array<u32>;
@group(0) @binding(11) var<storage, read_write> pairs: array<vec2<u32>>;
@group(0) @binding(12) var<storage, read_write> room: array<u32>;
@group(0) @binding(13) var<storage, read_write> n_pairs: array<u32>;
@group(0) @binding(14) var<storage, read> grid: array<u32>;
@group(0) @binding(15) var<storage, read> node: array<Node>;
@group(0) @binding(16) var<storage, read> params: array<u32>;

// Whether shapes of two bodies and groups may collide: not of one body, not both held, not of bodies or groups that are excluded.
fn may_collide(a: u32, b: u32, groups: vec2<u32>) -> bool {
    if a == b || (activity[a] != MOVING && activity[b] != MOVING) || rules[groups.x * params[0] + groups.y] != 0u {
        return false;
    }
    let pair = vec2(min(a, b), max(a, b));
    var first = 0u;
    var end = params[1];
    for (var i = 0u; i < 32u && first < end; i++) {
        let middle = (first + end) / 2u;
        let at = params[0] * params[0] + 2u * middle;
        let found = vec2(rules[at], rules[at + 1u]);
        if all(found == pair) {
            return false;
        }
        if found.x < pair.x || (found.x == pair.x && found.y < pair.y) {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    return true;
}

// Whether two spheres, wherever they are in their fat boxes, do not touch: boxes overlap at corners and edges where spheres do not. Their centres
// are in the boxes less their radii; a greater margin of a contact leaves the centres less room than it adds to its reach.
fn are_apart(s: u32, t: u32, own: Aabb, other: Aabb, unit: f32) -> bool {
    let reach = (f32(sphere[s].radius) + f32(sphere[t].radius)) * unit;
    let between = max(other.low.xyz - own.high.xyz, own.low.xyz - other.high.xyz);
    let centres = max(between + reach, vec3(0.0));
    return sphere[s].radius > 0u && sphere[t].radius > 0u && dot(centres, centres) > 1.00001 * reach * reach;
}

// Whether a box may come near a fixture.
fn is_near(own: Aabb, f: u32) -> bool {
    if fixture[f].kind != PLANE {
        return overlap(own, fixture_aabb[f]);
    }
    let up = real_axis(fixture[f].z_axis);
    let corner = select(own.high.xyz, own.low.xyz, up > vec3(0.0));
    // The box of a plane is about its position, grown by the envelope.
    let at = 0.5 * (fixture_aabb[f].low.xyz + fixture_aabb[f].high.xyz);
    let envelope = fixture_aabb[f].high.x - at.x;
    let rounding = 2e-6 * (length(corner) + length(at));
    return dot(corner - at, up) <= envelope + rounding;
}

fn write_pair(place: u32, pair: vec2<u32>) {
    if WRITES && place < arrayLength(&pairs) {
        pairs[place] = pair;
    }
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = row_of(group, thread);
    let n = count[0];
    if i >= n {
        return;
    }
    let s = bin_shape[i];
    let own = fat_aabb[s];
    let scale = bitcast<f32>(params[3]);
    let bits = vec3(grid[0], grid[1], grid[2]);
    let edge = (own.high - own.low).xyz * scale;
    let own_level = level_of(max(edge.x, max(edge.y, edge.z)));
    var to = pair_start[i];
    var found = 0u;
    let is_here = own.low.x <= own.high.x;
    for (var level = own_level; is_here && level < 64u; level++) {
        if ((levels[level / 32u] >> (level % 32u)) & 1u) == 0u {
            continue;
        }
        let base = bin_of(own.low.xyz * scale, level);
        // Of its own level, the bins from its own one on.
        for (var k = select(0u, 13u, level == own_level); k < 27u; k++) {
            let near = base + vec4(i32(k % 3u) - 1, i32(k / 3u % 3u) - 1, i32(k / 9u) - 1, 0);
            let row = bin_start[index_of(near, bits)];
            let is_own = level == own_level && k == 13u;
            for (var j = select(row.x, i + 1u, is_own); j < row.y; j++) {
                let t = bin_shape[j];
                let other = fat_aabb[t];
                if !overlap(own, other) || are_apart(s, t, own, other, 1.0 / scale) {
                    continue;
                }
                let width = (other.high - other.low).xyz * scale;
                let other_level = level_of(max(width.x, max(width.y, width.z)));
                if other_level != level || any(bin_of(other.low.xyz * scale, level) != near)
                    || !may_collide(sphere[s].body, sphere[t].body, vec2(sphere[s].group, sphere[t].group)) {
                    continue;
                }
                write_pair(to + found, vec2(min(s, t), max(s, t)));
                found++;
            }
        }
    }
    for (var f = 0u; is_here && f < params[2]; f++) {
        if is_near(own, f) && activity[fixture[f].body] != INACTIVE
            && may_collide(sphere[s].body, fixture[f].body, vec2(sphere[s].group, fixture[f].group)) {
            if fixture[f].kind == SURFACE {
                found += surface_pairs(own, s, f, to + found, 1.0 / scale);
                continue;
            }
            write_pair(to + found, vec2(s, n + f));
            found++;
        }
    }
    if WRITES {
        if i == 0u {
            let has_room = pair_start[n] <= arrayLength(&pairs);
            room[0] = pair_start[n];
            room[1] = select(0u, 1u, has_room);
            n_pairs[0] = select(0u, pair_start[n], has_room);
        }
    } else {
        pair_start[i] = found;
        if i == 0u {
            pair_start[n] = 0u;
        }
    }
}
