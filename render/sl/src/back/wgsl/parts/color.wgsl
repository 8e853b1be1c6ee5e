// Colour spaces, through RGB with the primaries and white of Rec. 709.

fn sl_rows(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(a, v), dot(b, v), dot(c, v));
}

fn sl_rgb_to_xyz(c: vec3<f32>) -> vec3<f32> {
    let x = vec3<f32>(0.4124564, 0.3575761, 0.1804375);
    let y = vec3<f32>(0.2126729, 0.7151522, 0.072175);
    return sl_rows(x, y, vec3<f32>(0.0193339, 0.119192, 0.9503041), c);
}

fn sl_xyz_to_rgb(c: vec3<f32>) -> vec3<f32> {
    let r = vec3<f32>(3.2404542, -1.5371385, -0.4985314);
    let g = vec3<f32>(-0.969266, 1.8760108, 0.041556);
    return sl_rows(r, g, vec3<f32>(0.0556434, -0.2040259, 1.0572252), c);
}

fn sl_rgb_to_xyy(c: vec3<f32>) -> vec3<f32> {
    let xyz = sl_rgb_to_xyz(c);
    let sum = xyz.x + xyz.y + xyz.z;
    if sum == 0.0 {
        return vec3<f32>();
    }
    return vec3<f32>(xyz.x / sum, xyz.y / sum, xyz.y);
}

fn sl_xyy_to_rgb(c: vec3<f32>) -> vec3<f32> {
    if c.y == 0.0 {
        return vec3<f32>();
    }
    return sl_xyz_to_rgb(vec3<f32>(c.x * c.z / c.y, c.z, (1.0 - c.x - c.y) * c.z / c.y));
}

fn sl_rgb_to_yiq(c: vec3<f32>) -> vec3<f32> {
    let y = vec3<f32>(0.299, 0.587, 0.114);
    let i = vec3<f32>(0.595716, -0.274453, -0.321263);
    return sl_rows(y, i, vec3<f32>(0.211456, -0.522591, 0.311135), c);
}

fn sl_yiq_to_rgb(c: vec3<f32>) -> vec3<f32> {
    let r = vec3<f32>(1.0, 0.95629572, 0.62102442);
    let g = vec3<f32>(1.0, -0.2721221, -0.6473806);
    return sl_rows(r, g, vec3<f32>(1.0, -1.10698902, 1.704615), c);
}

// x without the whole turns of `turn`.
fn sl_within(x: f32, turn: f32) -> f32 {
    return x - turn * floor(x / turn);
}

// RGB of a hue (0 to 1) and a chroma, whose smallest component is 0.
fn sl_hue_to_rgb(turn: f32, chroma: f32) -> vec3<f32> {
    let h = sl_within(turn, 1.0) * 6.0;
    let x = chroma * (1.0 - abs(sl_within(h, 2.0) - 1.0));
    switch u32(h) {
        case 0u: { return vec3<f32>(chroma, x, 0.0); }
        case 1u: { return vec3<f32>(x, chroma, 0.0); }
        case 2u: { return vec3<f32>(0.0, chroma, x); }
        case 3u: { return vec3<f32>(0.0, x, chroma); }
        case 4u: { return vec3<f32>(x, 0.0, chroma); }
        default: { return vec3<f32>(chroma, 0.0, x); }
    }
}

fn sl_hsv_to_rgb(c: vec3<f32>) -> vec3<f32> {
    let chroma = c.z * c.y;
    return sl_hue_to_rgb(c.x, chroma) + vec3<f32>(c.z - chroma);
}

fn sl_hsl_to_rgb(c: vec3<f32>) -> vec3<f32> {
    let chroma = (1.0 - abs(2.0 * c.z - 1.0)) * c.y;
    return sl_hue_to_rgb(c.x, chroma) + vec3<f32>(c.z - 0.5 * chroma);
}

fn sl_hue_of(c: vec3<f32>, high: f32, chroma: f32) -> f32 {
    if chroma == 0.0 {
        return 0.0;
    }
    if high == c.x {
        return sl_within((c.y - c.z) / chroma, 6.0) / 6.0;
    }
    if high == c.y {
        return ((c.z - c.x) / chroma + 2.0) / 6.0;
    }
    return ((c.x - c.y) / chroma + 4.0) / 6.0;
}

fn sl_rgb_to_hsv(c: vec3<f32>) -> vec3<f32> {
    let high = max(max(c.x, c.y), c.z);
    let chroma = high - min(min(c.x, c.y), c.z);
    var s = 0.0;
    if high > 0.0 {
        s = chroma / high;
    }
    return vec3<f32>(sl_hue_of(c, high, chroma), s, high);
}

fn sl_rgb_to_hsl(c: vec3<f32>) -> vec3<f32> {
    let high = max(max(c.x, c.y), c.z);
    let low = min(min(c.x, c.y), c.z);
    let light = 0.5 * (high + low);
    let room = 1.0 - abs(2.0 * light - 1.0);
    var s = 0.0;
    if room > 0.0 {
        s = (high - low) / room;
    }
    return vec3<f32>(sl_hue_of(c, high, high - low), s, light);
}
