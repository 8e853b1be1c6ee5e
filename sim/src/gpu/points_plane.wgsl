// The contact points of a solid with a plane: its corners, or the deepest points of its round parts. The second of the two is the plane.
// Twin: cpu/collide/surface.rs
#import placed
#import hulls

// Number of corners of the polygon in place of the flat end of a cylinder or a cone.
const RIM: u32 = 8u;
// Sine of the tilt up to which an end stands on its corners alone: which point of its rim is the deepest is then round-off.
const FLAT: f32 = 1e-4;

var<private> n_taken: u32;

// Take a point at a height over the plane if it is within reach; of more than there is room for, the lowest.
fn take(p: vec3<f32>, gap: f32, up: vec3<f32>, reach: f32, id: u32) {
    if gap > reach {
        return;
    }
    var slot = n_taken;
    if slot == MAX_POINTS {
        slot = 0u;
        for (var k = 1u; k < MAX_POINTS; k++) {
            if found[k].gap > found[slot].gap {
                slot = k;
            }
        }
        if gap >= found[slot].gap {
            return;
        }
    } else {
        n_taken += 1u;
    }
    found[slot] = Point(-up, p, p - up * gap, gap, id);
}

// The points of a solid whose centre is at `height` over a plane of normal `up`. Returns their count.
fn plane_points(a: Placed, up: vec3<f32>, height: f32, reach: f32) -> u32 {
    n_taken = 0u;
    let down = -up * a.frame;
    switch a.kind {
        case BOX: {
            for (var c = 0u; c < 8u; c++) {
                let sign = vec3<f32>(vec3(c & 1u, (c >> 1u) & 1u, (c >> 2u) & 1u)) * 2.0 - 1.0;
                take_local(a, a.half * sign, up, height, reach, c);
            }
        }
        case CYLINDER, CONE: { turned_points(a, down, up, height, reach); }
        case CAPSULE: {
            take_local(a, vec3(0.0, 0.0, a.half.z) + down * a.half.x, up, height, reach, 0u);
            take_local(a, vec3(0.0, 0.0, -a.half.z) + down * a.half.x, up, height, reach, 1u);
        }
        case HULL: { hull_points(a, up, height, reach); }
        case ELLIPSOID: {
            let scaled = a.half * down;
            take_local(a, a.half * scaled / length(scaled), up, height, reach, 0u);
        }
        default: { take_local(a, down * a.half.x, up, height, reach, 0u); }
    }
    return n_taken;
}

fn take_local(a: Placed, local: vec3<f32>, up: vec3<f32>, height: f32, reach: f32, id: u32) {
    let from_centre = a.frame * local;
    take(a.position + from_centre, height + dot(from_centre, up), up, reach, id);
}

// The vertices of a hull, or where there are more than a manifold has points, as many all around: the first, and then always the one that is
// farthest from those before it; instead of the last the deepest, where that is deeper than all of them.
fn hull_points(a: Placed, up: vec3<f32>, height: f32, reach: f32) {
    // What the deepest vertex is deeper by, over the distance of the first two.
    let deeper = 1e-5;
    let n = hull_size(a).x;
    let down = up * a.frame;
    var near = 0u;
    var first = n;
    var deepest = 0u;
    var depth = 1e30;
    for (var k = 0u; k < n; k++) {
        let gap = height + dot(hull_vertex(a, k), down);
        if gap <= reach {
            near += 1u;
            first = min(first, k);
        }
        if gap < depth {
            depth = gap;
            deepest = k;
        }
    }
    if near <= MAX_POINTS {
        for (var k = 0u; k < n; k++) {
            take_local(a, hull_vertex(a, k), up, height, reach, k);
        }
        return;
    }
    var chosen = array<u32, MAX_POINTS>();
    chosen[0] = first;
    var least = height + dot(hull_vertex(a, first), down);
    var across = 0.0;
    for (var m = 1u; m < MAX_POINTS; m++) {
        var most = 0.0;
        var at = first;
        for (var k = first; k < n; k++) {
            let p = hull_vertex(a, k);
            if height + dot(p, down) > reach {
                continue;
            }
            var away = 1e30;
            for (var c = 0u; c < m; c++) {
                let d = p - hull_vertex(a, chosen[c]);
                away = min(away, dot(d, d));
            }
            if away > most {
                most = away;
                at = k;
            }
        }
        chosen[m] = at;
        across = max(across, most);
        least = min(least, height + dot(hull_vertex(a, at), down));
    }
    if depth < least - deeper * sqrt(across) {
        chosen[MAX_POINTS - 1u] = deepest;
    }
    for (var m = 0u; m < MAX_POINTS; m++) {
        take_local(a, hull_vertex(a, chosen[m]), up, height, reach, chosen[m]);
    }
}

// The deepest point of each rim, the tip of a cone, and the corners of the end on which the shape may stand.
fn turned_points(a: Placed, down: vec3<f32>, up: vec3<f32>, height: f32, reach: f32) {
    let is_cone = a.kind == CONE;
    let size = length(down.xy);
    let is_tilted = size > FLAT;
    let lowest = select(vec2(0.0), down.xy * (a.half.x / size), is_tilted);
    if is_tilted {
        if !is_cone {
            take_local(a, vec3(lowest, a.half.z), up, height, reach, 60u);
        }
        take_local(a, vec3(lowest, -a.half.z), up, height, reach, select(61u, 60u, is_cone));
    }
    if is_cone {
        take_local(a, vec3(0.0, 0.0, a.half.z), up, height, reach, 62u);
    }
    let stands = select(abs(down.z) > 0.7, down.z < -0.7, is_cone);
    if !stands {
        return;
    }
    let z = select(a.half.z, -a.half.z, down.z < 0.0);
    let side = select(0u, RIM, down.z < 0.0 && !is_cone);
    for (var k = 0u; k < RIM; k++) {
        let angle = f32(k) * (6.2831853 / f32(RIM));
        let corner = a.half.x * vec2(cos(angle), sin(angle));
        if !is_tilted || length(corner - lowest) > 0.2 * a.half.x {
            take_local(a, vec3(corner, z), up, height, reach, side + k + 1u);
        }
    }
}

// The points of a pair of a solid and a plane, about an origin, with normals from the shape of the lower id. Returns their count.
fn points_of(pair: vec2<u32>, origin: Fixed, fine: f32, reach: f32) -> u32 {
    let f = pair.y - arrayLength(&sphere);
    let a = placed(pair.x, origin, fine);
    let up = real_axis(fixture[f].z_axis);
    // A whole number before it is rounded, as far as the centre of mass.
    let height = real64(along(fine_difference(origin, fixture[f].position), fixture[f].z_axis)) * fine;
    let n = plane_points(a, up, height + dot(a.position, up), reach);
    if fixture[f].shape < sphere[pair.x].shape {
        return swap_shapes(n);
    }
    return n;
}
