// The contact point of a sphere with a solid that has a closed form: the first of the two is the sphere.
// Twin: cpu/collide/round.rs
#import placed
#import kinds
#import outline

// The outward normal of a solid at the point nearest to a place in its frame, and the distance, negative inside.
fn surface_at(b: Placed, p: vec3<f32>) -> vec4<f32> {
    let half = b.half;
    if b.kind == BOX {
        let away = p - clamp(p, -half, half);
        let distance = length(away);
        if distance > 0.0 {
            return vec4(away / distance, distance);
        }
        // The centre is inside: out through the nearest face.
        let depth = half - abs(p);
        var axis = 0u;
        if depth.y < depth.x {
            axis = 1u;
        }
        if depth.z < depth[axis] {
            axis = 2u;
        }
        var outward = vec3(0.0);
        outward[axis] = select(1.0, -1.0, p[axis] < 0.0);
        return vec4(outward, -depth[axis]);
    }
    if b.kind == BALL || b.kind == SPHERE {
        let size = length(p);
        return vec4(select(vec3(0.0, 0.0, 1.0), p / size, size > 0.0), size - half.x);
    }
    let radial = length(p.xy);
    let around = select(vec2(1.0, 0.0), p.xy / radial, radial > 0.0);
    var nearest = vec3(0.0);
    if b.kind == CAPSULE {
        let from_core = vec2(radial, p.z - clamp(p.z, -half.z, half.z));
        let size = length(from_core);
        nearest = vec3(select(vec2(1.0, 0.0), from_core / size, size > 0.0), size - half.x);
    } else {
        nearest = outline(vec2(radial, p.z), vec2(half.x, half.z), b.kind == CONE);
    }
    return vec4(around * nearest.x, nearest.y, nearest.z);
}

// The contact of a sphere and a solid. Returns the count of points.
fn ball_points(a: Placed, b: Placed, reach: f32) -> u32 {
    let at = surface_at(b, (a.position - b.position) * b.frame);
    let gap = at.w - a.half.x;
    let normal = -(b.frame * at.xyz);
    found[0] = Point(normal, a.position + normal * a.half.x, a.position + normal * at.w, gap, 0u);
    return select(0u, 1u, gap <= reach);
}

// The points of a pair of a sphere and a solid, about an origin, with normals from the shape of the lower id. Returns their count.
fn points_of(pair: vec2<u32>, origin: Fixed, fine: f32, reach: f32) -> u32 {
    let kinds = kinds_of(pair);
    // The sphere first; of two, that of the lower shape.
    let is_swapped = side_of(pair.y).shape < side_of(pair.x).shape;
    let is_second = !is_ball(kinds.x) || (is_ball(kinds.y) && is_swapped);
    let sides = select(pair, pair.yx, is_second);
    let n = ball_points(placed(sides.x, origin, fine), placed(sides.y, origin, fine), reach);
    if is_second != is_swapped {
        return swap_shapes(n);
    }
    return n;
}
