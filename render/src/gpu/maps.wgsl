// Lookups in maps: in textures by a filter as wide as the ellipse that the change to the next points spans, and in shadow maps.
// The fourth row of the scene says where the rows of maps begin, their count, and where the linear light of bytes that are encoded for screens
// does, four a row. The row of a map has 0 if it cannot be read, 1 of an image, 2 of six faces; where the rows of its textures stand, four a row,
// and the tangent of half the angle of a face. A texture is a row of its width and height, the count of its levels, and what lies beyond its
// edges, along s 1 clamped and 2 periodic, along t 4 times that, with 16 for bytes that are linear and 32 for bytes that are encoded, and 256 times the
// count of channels of its file; then a row for each level, with its width and height, and the row of its texels, four of bytes to a row or one of floats.
// Twin: texture.rs

// The most places along the longer axis of a filter.
const MAX_TAPS: f32 = 16.0;

fn linear_light(byte: u32) -> f32 {
    return world_row(world[3].z + byte / 4u)[byte % 4u];
}

fn texel_at(first: u32, index: u32, kind: u32) -> vec4<f32> {
    if (kind & 48u) == 0u {
        return world_row(first + index);
    }
    let word = world[first + index / 4u][index % 4u];
    let bytes = vec4<u32>(word & 255u, (word >> 8u) & 255u, (word >> 16u) & 255u, word >> 24u);
    if (kind & 16u) != 0u {
        return vec4<f32>(bytes) / 255.0;
    }
    return vec4<f32>(linear_light(bytes.x), linear_light(bytes.y), linear_light(bytes.z), f32(bytes.w) / 255.0);
}

// Where a texel lies beyond an edge; -1 if nothing is there.
fn wrapped(k: f32, n: u32, wrap: u32) -> i32 {
    let last = f32(n) - 1.0;
    if wrap == 2u {
        let turned = k - floor(k / f32(n)) * f32(n);
        return i32(clamp(turned, 0.0, last));
    }
    // Half a texel beyond the edge still belongs to it.
    if wrap == 1u || (k >= -1.0 && k <= f32(n)) {
        return i32(clamp(k, 0.0, last));
    }
    return -1;
}

fn texel(level: vec4<u32>, kind: u32, i: i32, j: i32) -> vec4<f32> {
    if i < 0 || j < 0 {
        return vec4<f32>();
    }
    return texel_at(level.z, u32(j) * level.x + u32(i), kind);
}

fn bilinear(at: u32, kind: u32, index: u32, place: vec2<f32>) -> vec4<f32> {
    let level = world[at + 1u + index];
    let x = place * vec2<f32>(level.xy) - 0.5;
    if !all(abs(x) < vec2<f32>(1e30)) {
        return vec4<f32>();
    }
    let low = floor(x);
    let i0 = wrapped(low.x, level.x, kind & 3u);
    let i1 = wrapped(low.x + 1.0, level.x, kind & 3u);
    let j0 = wrapped(low.y, level.y, (kind >> 2u) & 3u);
    let j1 = wrapped(low.y + 1.0, level.y, (kind >> 2u) & 3u);
    let part = x - low;
    let above = mix(texel(level, kind, i0, j0), texel(level, kind, i1, j0), part.x);
    let below = mix(texel(level, kind, i0, j1), texel(level, kind, i1, j1), part.x);
    return mix(above, below, part.y);
}

// An ellipse: the direction of its longer axis, and the lengths of both.
fn ellipse(a: vec2<f32>, b: vec2<f32>) -> vec4<f32> {
    let xx = a.x * a.x + b.x * b.x;
    let yy = a.y * a.y + b.y * b.y;
    let xy = a.x * a.y + b.x * b.y;
    let half = 0.5 * (xx - yy);
    let off = sqrt(half * half + xy * xy);
    let long = sqrt(0.5 * (xx + yy) + off);
    var short = 0.0;
    if long > 0.0 {
        short = abs(a.x * b.y - a.y * b.x) / long;
    }
    var axis = vec2<f32>(1.0, 0.0);
    if off > 0.0 {
        let angle = 0.5 * sl_atan2(xy, half);
        axis = vec2<f32>(sl_cos(angle), sl_sin(angle));
    }
    return vec4<f32>(axis, long, short);
}

// The mean about a place over the ellipse, wider by a blur, all as parts of the image.
fn filtered(at: u32, place: vec2<f32>, row: vec2<f32>, column: vec2<f32>, blur: vec2<f32>) -> vec4<f32> {
    let head = world[at];
    let size = vec2<f32>(head.xy);
    var a = row * size;
    var b = column * size;
    let even = max(min(blur.x, blur.y), 0.0);
    let rest = 2.0 * size * (blur - even);
    if any(rest != vec2<f32>()) {
        // A blur along one axis alone: so much wider is the ellipse along it.
        let grown = max(sqrt(a * a + b * b) + rest, vec2<f32>());
        a = vec2<f32>(grown.x, 0.0);
        b = vec2<f32>(0.0, grown.y);
    }
    let e = ellipse(a, b);
    let most = max(size.x, size.y);
    let grown = e.zw + 2.0 * even * sqrt(size.x * size.y);
    // A map may be met many times along the ellipse.
    let long = clamp(grown.x, 1.0, max(MAX_TAPS * most, 1.0));
    let short = clamp(grown.y, 1.0, max(most, 1.0));
    let ratio = min(long / short, MAX_TAPS);
    let taps = ceil(ratio);
    let level = clamp(log2(long / ratio), 0.0, f32(head.z - 1u));
    let lower = u32(level);
    let upper = min(lower + 1u, head.z - 1u);
    let t = level - f32(lower);
    var sum = vec4<f32>();
    for (var k = 0.0; k < taps; k += 1.0) {
        let along = long * ((k + 0.5) / taps - 0.5);
        let here = place + e.xy * along / size;
        var found = bilinear(at, head.w, lower, here);
        if t > 0.0 && upper > lower {
            found = mix(found, bilinear(at, head.w, upper, here), t);
        }
        sum += found / taps;
    }
    return sum;
}

// Where a direction meets the image of a face of a cube.
fn on_face(face: u32, d: vec3<f32>, tangent: f32) -> vec2<f32> {
    var v = vec3<f32>(-d.x, d.y, -d.z);
    switch face {
        case 0u: { v = vec3<f32>(-d.z, d.y, d.x); }
        case 1u: { v = vec3<f32>(d.z, d.y, -d.x); }
        case 2u: { v = vec3<f32>(d.x, -d.z, d.y); }
        case 3u: { v = vec3<f32>(d.x, d.z, -d.y); }
        case 4u: { v = d; }
        default: {}
    }
    let scale = 0.5 / (max(abs(v.z), 1e-20) * tangent);
    return vec2<f32>(0.5 + v.x * scale, 0.5 - v.y * scale);
}

fn face_of(d: vec3<f32>) -> u32 {
    let size = abs(d);
    var axis = 0u;
    if size.y > size.x {
        axis = 1u;
    }
    if size.z > size[axis] {
        axis = 2u;
    }
    return 2u * axis + select(0u, 1u, d[axis] < 0.0);
}

// Where a direction is in a map of longitude and latitude: z is up.
fn on_sphere(d: vec3<f32>) -> vec2<f32> {
    let s = sl_atan2(d.y, d.x) / 6.28318531;
    let cosine = clamp(d.z / max(sqrt(dot(d, d)), 1e-20), -1.0, 1.0);
    return vec2<f32>(s - floor(s), sl_acos(cosine) / 3.14159274);
}

// A difference of longitudes is less than half a turn.
fn turned(d: vec2<f32>) -> vec2<f32> {
    let x = d.x + 0.5;
    return vec2<f32>(x - floor(x) - 0.5, d.y);
}

fn texture_map(map: u32, q: Lookup) -> vec4<f32> {
    let head = world[world[3].x + map];
    if map >= world[3].y || head.x == 0u {
        return vec4<f32>();
    }
    var face = 0u;
    var place = q.at.xy;
    var row = q.row.xy;
    var column = q.column.xy;
    if head.x == 2u {
        face = face_of(q.at);
        let tangent = bitcast<f32>(head.z);
        place = on_face(face, q.at, tangent);
        row = on_face(face, q.at + q.row, tangent) - place;
        column = on_face(face, q.at + q.column, tangent) - place;
    } else if q.how == 1u {
        place = on_sphere(q.at);
        row = turned(on_sphere(q.at + q.row) - place);
        column = turned(on_sphere(q.at + q.column) - place);
    }
    let at = world[head.y + face / 4u][face % 4u];
    let value = filtered(at, place, row * q.width, column * q.width, q.blur);
    var found = vec4<f32>(q.fill);
    if q.channel == 0u {
        return value;
    }
    let channels = min(world[at].w >> 8u, 4u);
    let own = select(value, vec4<f32>(value.x, value.w, 0.0, 0.0), channels == 2u);
    for (var k = 0u; k + q.channel < channels; k += 1u) {
        found[k] = own[k + q.channel];
    }
    return found;
}

fn scene_map(map: u32, q: Lookup) -> vec4<f32> {
    if q.how == 2u {
        return shadow_map(q);
    }
    return texture_map(map, q);
}
