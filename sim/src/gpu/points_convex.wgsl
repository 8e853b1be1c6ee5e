// The contact points of convex shapes of any kinds.
// Twin: cpu/collide/manifold.rs
#import nearest
#import ordered

// Of sides that clip, more than rounding: corners of faces that lie on each other keep their features from step to step.
const BEYOND: f32 = 2e-6;
// Whether all shapes are boxes, whose faces have been tried.
const ALL_BOXES: bool = false;

fn solid_points(a: Placed, b: Placed, reach: f32) -> u32 {
    return nearest_points(a, b, reach);
}

// The axis along which cores that touch or nearly do are farthest apart or overlap least: the best of that between the centres, those of
// both frames and their cross products, the parts of the first across the third axes, about which shapes may be round, and the normals of
// hulls.
fn first_axis(a: Placed, b: Placed, away: vec3<f32>) -> vec4<f32> {
    var best = vec4(0.0, 0.0, 1.0, -3e38);
    for (var i = 0u; i < 18u; i++) {
        var axis = away;
        if i < 9u {
            axis = cross(a.frame[i / 3u], b.frame[i % 3u]);
        } else if i < 12u {
            axis = a.frame[i - 9u];
        } else if i < 15u {
            axis = b.frame[i - 12u];
        } else if i == 15u {
            axis -= a.frame[2] * dot(away, a.frame[2]);
        } else if i == 16u {
            axis -= b.frame[2] * dot(away, b.frame[2]);
        }
        let size = length(axis);
        if size > 1e-3 * select(1.0, length(away), i >= 15u) {
            try_axis(a, b, select(axis, -axis, dot(axis, away) < 0.0) / size, 0.0, &best);
        }
    }
    hull_axes(a, b, &best);
    return best;
}

// The same of the normals of hulls, along which one shape is beyond a face of the other.
fn hull_axes(a: Placed, b: Placed, best: ptr<function, vec4<f32>>) {
    var n_first = 0u;
    if a.kind == HULL {
        n_first = hull_size(a).y;
    }
    var n = n_first;
    if b.kind == HULL {
        n += hull_size(b).y;
    }
    for (var k = 0u; k < n; k++) {
        var axis = vec3(0.0);
        if k < n_first {
            axis = a.frame * hull_normal(a, k);
        } else {
            axis = -(b.frame * hull_normal(b, k - n_first));
        }
        try_axis(a, b, axis, 0.0, best);
    }
}
