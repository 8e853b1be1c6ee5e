// Shapes of any kind where they are, in single precision about the centre of mass of one of a pair's bodies, from the columns `position`,
// `orientation`, `sphere`, `solid` and `fixture` of the kernel. Fixtures are numbered behind the moving shapes.
#import sphere
#import solid
#import turn
#import side
#import point

// A shape: kind, half lengths, m, position of its centre, m, the axes of its frame, and the first row of a hull.
struct Placed {
    kind: u32,
    half: vec3<f32>,
    position: vec3<f32>,
    frame: mat3x3<f32>,
    part: u32,
}

const MAX_POINTS: u32 = 8u;

// The points of the pair.
var<private> found: array<Point, 8>;

fn frame_of(q: vec4<f32>) -> mat3x3<f32> {
    return mat3x3(turned(q, vec3(1.0, 0.0, 0.0)), turned(q, vec3(0.0, 1.0, 0.0)), turned(q, vec3(0.0, 0.0, 1.0)));
}

// A shape about an origin; `fine` is the fine unit, m.
fn placed(at: u32, origin: Fixed, fine: f32) -> Placed {
    let n = arrayLength(&sphere);
    if at >= n {
        let f = at - n;
        let x = real_axis(fixture[f].x_axis);
        let y = real_axis(fixture[f].y_axis);
        let z = real_axis(fixture[f].z_axis);
        let offset = real_fixed(fine_difference(fixture[f].position, origin)) * fine;
        return Placed(fixture[f].kind, real_fixed(fixture[f].half) * fine, offset, mat3x3(x, y, z), fixture[f].part);
    }
    let own = solid[at];
    let body = sphere[at].body;
    let offset = real_fixed(fine_difference(position[body], origin)) * fine;
    let q = orientation[body];
    return Placed(own.kind, own.half, offset + turned(q, own.offset), frame_of(product_of(q, own.turn)), own.part);
}

// A shape in the frame of another, and that in its own: a pair is collided in the frame of one, whose axes then take no registers.
fn seen_from(shape: Placed, a: Placed) -> Placed {
    let position = (shape.position - a.position) * a.frame;
    return Placed(shape.kind, shape.half, position, transpose(a.frame) * shape.frame, shape.part);
}

fn at_home(a: Placed) -> Placed {
    let axes = mat3x3(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    return Placed(a.kind, a.half, vec3(0.0), axes, a.part);
}

// The first points of a pair, which are in the frame of a shape, in the world.
fn leave_home(a: Placed, n: u32) {
    for (var k = 0u; k < n; k++) {
        let p = found[k];
        let on_first = a.position + a.frame * p.on_first;
        let on_second = a.position + a.frame * p.on_second;
        found[k] = Point(a.frame * p.normal, on_first, on_second, p.gap, p.feature);
    }
}

// Swap the two shapes of the first points. Returns their count.
fn swap_shapes(n: u32) -> u32 {
    for (var k = 0u; k < n; k++) {
        let p = found[k];
        found[k] = Point(-p.normal, p.on_second, p.on_first, p.gap, p.feature);
    }
    return n;
}
