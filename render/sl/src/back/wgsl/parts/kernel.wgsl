// What every kernel of shaders begins with: its buffers, the grid that a workgroup shades, and reads of inputs by slot.

// A workgroup's grid, and the first of the points that it shades.
@group(0) @binding(0) var<storage, read> groups: array<vec2<u32>>;
// Grids, three rows each: points, points of a row, orientation (the bits of 1 or -1), first slot; first light, lights, where the results
// begin, where the host's own numbers of the grid begin among the values; 1 more than where the footprints of its points begin there, 0
// for none.
@group(0) @binding(1) var<storage, read> grids: array<vec4<u32>>;
// Inputs: where the numbers begin; 0 none, 1 one value, 2 a value a point, as runs.
@group(0) @binding(2) var<storage, read> slots: array<vec2<u32>>;
// Lights: index of the shader, first slot, categories, 1 if ambient.
@group(0) @binding(3) var<storage, read> lights: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> values: array<f32>;
@group(0) @binding(5) var<storage, read_write> results: array<f32>;
// Of each shader: the place of a loop that did not end, and of an index outside its array; 0 if there is none, else 1 more.
@group(0) @binding(6) var<storage, read_write> status: array<atomic<u32>>;

struct Grid {
    n: u32,
    nu: u32,
    orientation: f32,
    slots: u32,
    first_light: u32,
    n_lights: u32,
    results: u32,
    own: u32,
    footprints: u32,
}

// What a light gives to a point.
struct Lit {
    on: bool,
    l: vec3<f32>,
    cl: vec3<f32>,
}

// A lookup in a map at a point: 0 texture, 1 environment, 2 shadow; the first of four channels; s and t, a direction or a position,
// and its change to the next point of the row and of the column; the factor on the filter's width; blur along s and t; the value of
// channels that the map does not have; samples and bias; whether a light looks it up that has a place, and the place.
struct Lookup {
    how: u32,
    channel: u32,
    at: vec3<f32>,
    row: vec3<f32>,
    column: vec3<f32>,
    width: f32,
    blur: vec2<f32>,
    fill: f32,
    samples: f32,
    bias: f32,
    has_light: bool,
    light: vec3<f32>,
}

var<private> point: u32;
var<private> turns_left: u32 = 60000u;

fn sl_grid(at: u32) -> Grid {
    let a = grids[3u * at];
    let b = grids[3u * at + 1u];
    return Grid(a.x, a.y, bitcast<f32>(a.z), a.w, b.x, b.y, b.z, b.w, grids[3u * at + 2u].x);
}

// The number of a value's component, of which `element` values of `width` numbers stand before.
fn sl_at(slot: u32, element: u32, width: u32, component: u32) -> f32 {
    let s = slots[slot];
    let k = element * width + component;
    switch s.y {
        case 1u: { return values[s.x + k]; }
        case 2u: { return values[s.x + k * work.n + point]; }
        default: { return 0.0; }
    }
}

fn sl_read1(slot: u32, element: u32) -> f32 {
    return sl_at(slot, element, 1u, 0u);
}

fn sl_read3(slot: u32, element: u32) -> vec3<f32> {
    return vec3<f32>(sl_at(slot, element, 3u, 0u), sl_at(slot, element, 3u, 1u), sl_at(slot, element, 3u, 2u));
}

fn sl_read16(slot: u32, element: u32) -> mat4x4<f32> {
    var m: mat4x4<f32>;
    for (var c = 0u; c < 4u; c += 1u) {
        let k = 4u * c;
        m[c] = vec4<f32>(
            sl_at(slot, element, 16u, k),
            sl_at(slot, element, 16u, k + 1u),
            sl_at(slot, element, 16u, k + 2u),
            sl_at(slot, element, 16u, k + 3u),
        );
    }
    return m;
}

fn sl_write(output: u32, value: f32) {
    results[work.results + output * work.n + point] = value;
}

fn sl_outside(shader: u32, place: u32) {
    atomicMax(&status[2u * shader + 1u], place + 1u);
}

// Take a turn of a loop from what is left of them; false if none is.
fn sl_turn_is_left(shader: u32, place: u32) -> bool {
    if turns_left == 0u {
        atomicMax(&status[2u * shader], place + 1u);
        return false;
    }
    turns_left -= 1u;
    return true;
}

// Whether a light from along `l` is in a light's cone and in the receiver's; cosines below -1 are of all directions.
fn sl_reaches(l: vec3<f32>, axis: vec3<f32>, cosine: f32, receiver: vec3<f32>, receiver_cosine: f32) -> bool {
    let far = sqrt(dot(l, l));
    let in_cone = cosine < -1.0 || dot(l, axis) >= cosine * far * sqrt(dot(axis, axis));
    return in_cone && (receiver_cosine < -1.0 || -dot(l, receiver) > receiver_cosine * far * sqrt(dot(receiver, receiver)));
}

// The cosine of a cone's half angle.
fn sl_cone(angle: f32) -> f32 {
    return select(-2.0, sl_cos(angle), angle < 3.14159274);
}

// The normal on the side that is seen.
fn sl_facing() -> vec3<f32> {
    let n = sl_read3(work.slots + GLOBAL_N, 0u);
    return select(n, -n, dot(n, sl_read3(work.slots + GLOBAL_I, 0u)) > 0.0);
}

// The normal that lights are told of: the grid's, or the axis of the cone that takes light.
fn sl_light_normal(axis: vec3<f32>) -> vec3<f32> {
    if slots[work.slots + GLOBAL_N].y == 0u {
        return axis;
    }
    return sl_read3(work.slots + GLOBAL_N, 0u);
}
