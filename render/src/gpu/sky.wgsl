// How open to the sky a place is, by cones about fixed directions.
// Spheres are two rows: primitive, index of its half axes, whether it is an ellipsoid, its colour in ten bits a channel; middle and radius. Facets are five: four corners,
// the first of them with 1 if it is of a closed surface, the second with its colour, the third with the whole that it is of, the fourth with how far that leaves it; the normal by its area, and its size, the square root of the area. Nodes of
// facets are three, in the order of a walk: middle and radius; sum of normals by area, and of areas; the next node that is not below, facet,
// 1 if it is a leaf, the mean colour.
// Twin: cpu/openness.rs

// As in cpu/openness/cones.rs, spheres.rs and facets.rs.
const CONES: u32 = 24u;
const COS: f32 = 0.875;
const SIN: f32 = 0.4841229;
const SOLID: f32 = 0.785398185;
const REACH: f32 = 5.0;
const FADES: f32 = 3.0;
const FAR: f32 = 2.5;
const IN_PLANE: f32 = 2e-6;
const PAST: f32 = 0.7;
const WIDE: f32 = 20.0;
const SLANT: f32 = 0.6;
const TOUCHED: f32 = 0.9999;
const TOUCHES: f32 = 0.8;
const HOLLOW_BESIDE: f32 = 8.0;
const HOLLOW_UNDER: vec2<f32> = vec2<f32>(1.5, 3.0);

// How much of each cone is open, or closed.
var<private> sky_open: array<f32, 24>;
var<private> sky_closed: array<f32, 24>;
// The way to the sun, or 0; how much of them facets close, by how squarely these face the sun; and of this what is far away.
var<private> sky_sun: vec3<f32>;
var<private> sky_bright: array<f32, 24>;
var<private> sky_far: array<f32, 24>;

// Colours of what closes them, by how much of what lights the place each closes, and the sum of that.
var<private> sky_tint: vec4<f32>;

fn add_tint(color: u32, weight: f32) {
    let c = vec3<f32>(vec3<u32>(color, color >> 10u, color >> 20u) & vec3<u32>(1023u)) * (1.0 / 1023.0);
    sky_tint += vec4<f32>(c, 1.0) * weight;
}

// The axes of the cones.
const AXES: array<vec3<f32>, 24> = array<vec3<f32>, 24>(
    vec3<f32>(0.28565228, 0.0, 0.958333313),
    vec3<f32>(-0.356977165, 0.327020347, 0.875),
    vec3<f32>(0.0534130335, -0.608613968, 0.791666687),
    vec3<f32>(0.429483652, 0.560185373, 0.708333313),
    vec3<f32>(-0.768691719, -0.135970742, 0.625),
    vec3<f32>(0.709255099, -0.451170057, 0.541666687),
    vec3<f32>(-0.230731204, 0.858308613, 0.458333343),
    vec3<f32>(-0.42727226, -0.822686732, 0.375),
    vec3<f32>(0.89847964, 0.328123331, 0.291666657),
    vec3<f32>(-0.904063463, 0.373184264, 0.208333328),
    vec3<f32>(0.420521647, -0.898630381, 0.125),
    vec3<f32>(0.299023956, 0.953335464, 0.0416666679),
    vec3<f32>(-0.864459813, -0.500972152, -0.0416666679),
    vec3<f32>(0.969015479, -0.21303533, -0.125),
    vec3<f32>(-0.562509894, 0.800112426, -0.208333328),
    vec3<f32>(-0.122923046, -0.948588669, -0.291666657),
    vec3<f32>(0.708848596, 0.597418368, -0.375),
    vec3<f32>(-0.88802141, 0.0367224738, -0.458333343),
    vec3<f32>(0.595837295, -0.592937708, -0.541666687),
    vec3<f32>(-0.0360581875, 0.779791534, -0.625),
    vec3<f32>(-0.452262551, -0.54196167, -0.708333313),
    vec3<f32>(0.605497062, 0.0814687759, -0.791666687),
    vec3<f32>(-0.397396326, 0.27649802, -0.875),
    vec3<f32>(0.0626953542, -0.278687119, -0.958333313),
);

fn smooth_step(x: f32) -> f32 {
    return x * x * (3.0 - 2.0 * x);
}

// A disc in the sky as cones see it: its direction, the cosine from which on it covers something, one over the width to where it covers its
// most, and that.
struct Cap {
    way: vec3<f32>,
    low: f32,
    scale: f32,
    most: f32,
}

fn cap_of(way: vec3<f32>, sin2: f32, factor: f32) -> Cap {
    let sine = sqrt(sin2);
    let cosine = sqrt(1.0 - sin2);
    let low = cosine * COS - sine * SIN;
    let full = cosine * COS + sine * SIN;
    return Cap(way, low, 1.0 / max(full - low, 1e-6), (1.0 - cosine) / (1.0 - cosine * COS) * factor);
}

fn cap_covers(cap: Cap, k: u32) -> f32 {
    return cap.most * smooth_step(clamp((dot(cap.way, AXES[k]) - cap.low) * cap.scale, 0.0, 1.0));
}

// The radius squared of the disc that has the area of an ellipsoid's silhouette.
fn silhouette2(at: u32, way: vec3<f32>) -> f32 {
    let a = world_row(at).xyz;
    let b = world_row(at + 1u).xyz;
    let c = world_row(at + 2u).xyz;
    let s = vec3<f32>(dot(cross(a, b), way), dot(cross(b, c), way), dot(cross(c, a), way));
    return sqrt(dot(s, s));
}

fn close_sphere(place: vec3<f32>, normal: vec3<f32>, at: u32, own: u32) {
    let head = world[at];
    let ball = world_row(at + 1u);
    let to = ball.xyz - place;
    let r = ball.w;
    let d2 = dot(to, to);
    if head.x == own || d2 >= REACH * REACH * r * r || dot(to, normal) <= -TOUCHED * r {
        return;
    }
    let d = sqrt(d2);
    let way = to / max(d, 1e-30);
    var r2 = r * r;
    if head.z != 0u {
        r2 = silhouette2(world[1].z + 3u * head.y, way);
    }
    let fade = 1.0 - smooth_step(clamp((d / r - FADES) / (REACH - FADES), 0.0, 1.0));
    let sin2 = min(r2 / max(d2, 1e-30), 1.0);
    add_tint(head.w, fade * sin2 * max(dot(way, normal), 0.0));
    let cap = cap_of(way, sin2, fade);
    for (var k = 0u; k < CONES; k += 1u) {
        sky_open[k] *= 1.0 - cap_covers(cap, k);
    }
}

fn close_spheres(place: vec3<f32>, normal: vec3<f32>) {
    let own = own_primitive();
    let n_nodes = world[1].w;
    var k = 0u;
    while k < n_nodes {
        let low = world[world[1].x + 2u * k];
        let high = world[world[1].x + 2u * k + 1u];
        if any(place < bitcast<vec3<f32>>(low.xyz)) || any(place > bitcast<vec3<f32>>(high.xyz)) {
            k = low.w;
            continue;
        }
        k += 1u;
        let last = (high.w >> 3u) + (high.w & 7u);
        for (var i = high.w >> 3u; i < last; i += 1u) {
            close_sphere(place, normal, world[1].y + 2u * i, own);
        }
    }
}

// What facets close from afar. Of what encloses something, a quarter of its area is seen in the mean (Cauchy).
fn close_node(to: vec3<f32>, d2: f32, normal: vec3<f32>, ball: vec4<f32>, sum: vec4<f32>, color: u32) {
    let way = to / sqrt(d2);
    let even = sqrt(dot(sum.xyz, sum.xyz));
    let seen = abs(dot(sum.xyz, way)) + 0.25 * max(sum.w - even, 0.0);
    let solid = min(seen / d2, 3.14159274 * ball.w * ball.w / d2);
    if solid <= 0.002 {
        return;
    }
    let fade = smooth_step(min((solid - 0.002) / (0.006 - 0.002), 1.0));
    let sin2 = min(solid / 3.14159274, 1.0);
    add_tint(color, fade * sin2 * max(dot(way, normal), 0.0));
    let cap = cap_of(way, sin2, fade);
    let bright = select(sky_phase(dot(way, sky_sun)), 0.0, all(sky_sun == vec3<f32>()));
    for (var k = 0u; k < CONES; k += 1u) {
        let cover = cap_covers(cap, k);
        sky_closed[k] += cover;
        sky_bright[k] += cover * bright;
    }
}

// The solid angle of a triangle as seen from the origin (Van Oosterom and Strackee 1983).
fn solid_angle(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let l = vec3<f32>(sqrt(dot(a, a)), sqrt(dot(b, b)), sqrt(dot(c, c)));
    let volume = abs(dot(a, cross(b, c)));
    return 2.0 * sl_atan2(volume, l.x * l.y * l.z + dot(a, b) * l.z + dot(b, c) * l.x + dot(c, a) * l.y);
}

// How much a facet counts at a place on its own surface, which leaves it by `off`, at a height over its plane.
fn facet_counts(above: f32, off: f32) -> f32 {
    let under = (-above / off - HOLLOW_UNDER.x) / (HOLLOW_UNDER.y - HOLLOW_UNDER.x);
    return smooth_step(clamp(select(under, above / (HOLLOW_BESIDE * off), above > 0.0), 0.0, 1.0));
}

// What a facet closes near by: where a cone lies within the planes through the place and its edges.
fn close_facet(place: vec3<f32>, normal: vec3<f32>, at: u32, own: u32) {
    let sized = world_row(at + 4u);
    let area = sized.xyz;
    let size = sized.w;
    var q: array<vec3<f32>, 4>;
    var highest = -1e30;
    for (var k = 0u; k < 4u; k += 1u) {
        q[k] = world_row(at + k).xyz - place;
        highest = max(highest, dot(q[k], normal));
    }
    let in_plane = IN_PLANE * (size + sqrt(dot(place, place)) + sqrt(dot(q[0], q[0])) + sqrt(dot(q[2], q[2])));
    let height = dot(q[0], area) / (size * size);
    let closed = world[at].w != 0u;
    if highest <= in_plane || abs(height) < in_plane || (closed && height > 0.0) {
        return;
    }
    let side = select(1.0, -1.0, height < 0.0);
    let off = bitcast<f32>(world[at + 3u].w);
    var counts = 1.0;
    let facing = dot(area, normal);
    let above = select(-height, height, facing < 0.0);
    let is_touched = above < 0.0 && facing > TOUCHES * size * size;
    if off > 0.0 && (world[at + 2u].w == own || is_touched) {
        counts = facet_counts(above, off);
        if counts == 0.0 {
            return;
        }
    }
    var edges: array<vec3<f32>, 4>;
    for (var k = 0u; k < 4u; k += 1u) {
        let m = side * cross(q[k], q[(k + 1u) & 3u]);
        let far = dot(m, m);
        edges[k] = select(vec3<f32>(), m / sqrt(far), far > 0.0);
    }
    // A cone that is wider than the facet is not covered by it whole.
    let solid = solid_angle(q[0], q[1], q[2]) + solid_angle(q[0], q[2], q[3]);
    let most = counts * min(1.5 * solid / SOLID, 1.0);
    // Light comes along the way to its plane, or to its middle, whichever is more before the surface.
    let middle = 0.25 * (q[0] + q[1] + q[2] + q[3]);
    let plane = side * dot(area, normal) / (size * size);
    let toward = dot(middle, normal) / max(sqrt(dot(middle, middle)), 1e-30);
    add_tint(world[at + 1u].w, counts * solid / 3.14159274 * max(max(plane, toward), 0.1));
    // The side that is seen, if the sun shines on it.
    let across = -area * side / (size * size);
    let bright = max(dot(across, sky_sun), 0.0);
    let wide = bright * clamp(size / (WIDE * abs(height)) - 1.0, 0.0, 1.0);
    for (var k = 0u; k < CONES; k += 1u) {
        var cover = most;
        let axis = AXES[k];
        for (var e = 0u; e < 4u; e += 1u) {
            if any(edges[e] != vec3<f32>()) {
                cover *= smooth_step(clamp(0.5 + dot(edges[e], axis) * (0.5 / SIN), 0.0, 1.0));
            }
        }
        sky_closed[k] += cover;
        let sine = abs(dot(across, axis));
        sky_bright[k] += bright * cover;
        sky_far[k] += wide * cover * max(1.0 - sine * (1.0 / SLANT), 0.0);
    }
}

fn close_facets(place: vec3<f32>, normal: vec3<f32>) {
    let own = own_whole();
    let n_nodes = world[2].z;
    var k = 0u;
    while k < n_nodes {
        let at = world[2].x + 3u * k;
        let ball = world_row(at);
        let next = world[at + 2u];
        let to = ball.xyz - place;
        let d2 = dot(to, to);
        let is_far = d2 > FAR * FAR * ball.w * ball.w;
        if dot(to, normal) <= -ball.w {
            k = next.x;
        } else if is_far {
            close_node(to, d2, normal, ball, world_row(at + 1u), next.w);
            k = next.x;
        } else {
            k += 1u;
            if next.z != 0u {
                close_facet(place, normal, world[2].y + 5u * next.y, own);
            }
        }
    }
}

fn sky_free(cosine: f32) -> vec3<f32> {
    let above = clamp(0.5 + 0.5 * cosine, 0.0, 1.0);
    return vec3<f32>(above, 2.0 / 3.0 * sl_power(above, 1.651496), 1.0 - above);
}

// As phase in cpu/openness.rs.
fn sky_phase(cosine: f32) -> f32 {
    let half = 0.5 - 0.5 * cosine;
    return half * (0.1833 + 0.4833 * half);
}

// A quotient, or what there is where nothing counts.
fn sky_part(sum: f32, all: f32, free: f32) -> f32 {
    return select(free, free * sum / all, all > 0.0);
}

fn close_sky(place: vec3<f32>, normal: vec3<f32>, sun: vec3<f32>) {
    sky_sun = sun;
    for (var k = 0u; k < CONES; k += 1u) {
        sky_open[k] = 1.0;
        sky_closed[k] = 0.0;
        sky_bright[k] = 0.0;
        sky_far[k] = 0.0;
    }
    sky_tint = vec4<f32>();
    close_spheres(place, normal);
    close_facets(place, normal);
}

fn scene_openness(place: vec3<f32>, normal: vec3<f32>, up: vec3<f32>) -> vec3<f32> {
    close_sky(place, normal, vec3<f32>());
    var all = vec3<f32>();
    var sum = vec3<f32>();
    for (var k = 0u; k < CONES; k += 1u) {
        let axis = AXES[k];
        let height = dot(axis, up);
        let above = clamp(0.5 + height, 0.0, 1.0);
        let parts = vec3<f32>(above, above * max(height, 0.0), 1.0 - above) * max(dot(axis, normal), 0.0);
        let open = sky_open[k] * (1.0 - min(sky_closed[k], 1.0));
        all += parts;
        sum += parts * vec3<f32>(open, open, sky_open[k]);
    }
    let free = sky_free(dot(normal, up));
    return select(free, free * sum / all, all > vec3<f32>());
}

fn scene_surroundings(place: vec3<f32>, normal: vec3<f32>, up: vec3<f32>, sun: vec3<f32>) -> mat4x4<f32> {
    close_sky(place, normal, sun);
    var all = vec3<f32>();
    var sum = vec3<f32>();
    var facing_all = 0.0;
    var closed = 0.0;
    var near_lit = 0.0;
    var far_lit = 0.0;
    var sunny_all = 0.0;
    var sunny = 0.0;
    for (var k = 0u; k < CONES; k += 1u) {
        let axis = AXES[k];
        let height = dot(axis, up);
        let before = dot(axis, normal);
        let toward = dot(axis, sun);
        let above = clamp(0.5 + height, 0.0, 1.0);
        let facing = max(before, 0.0);
        let parts = vec3<f32>(above, above * max(height, 0.0), 1.0 - above) * facing;
        let open = sky_open[k] * (1.0 - min(sky_closed[k], 1.0));
        all += parts;
        sum += parts * open;
        let by_facets = facing * (sky_open[k] - open) / max(sky_closed[k], 1e-6);
        facing_all += facing;
        closed += facing * (1.0 - open);
        near_lit += facing * (1.0 - sky_open[k]) * sky_phase(toward) + by_facets * sky_bright[k];
        far_lit += by_facets * sky_far[k];
        let lobe = max(toward, 0.0) * max(toward, 0.0);
        sunny_all += lobe;
        sunny += lobe * open * (PAST + (1.0 - PAST) * clamp(0.5 + before, 0.0, 1.0));
    }
    let free = sky_free(dot(normal, up));
    let parts = select(free, free * sum / all, all > vec3<f32>());
    let lit = sky_part(far_lit + (near_lit - far_lit) * sky_part(sunny, sunny_all, 1.0), facing_all, 1.0);
    let color = select(vec3<f32>(), sky_tint.xyz / sky_tint.w, sky_tint.w > 0.0);
    return mat4x4<f32>(vec4<f32>(parts, sky_part(closed, facing_all, 1.0)), vec4<f32>(color, select(0.0, lit, sunny_all > 0.0)),
                       vec4<f32>(), vec4<f32>());
}
