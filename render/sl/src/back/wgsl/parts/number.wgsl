// Functions of numbers and triples as the grid machine computes them, where WGSL's own are undefined or too coarse.

fn sl_divide(a: f32, b: f32) -> f32 {
    if b == 0.0 {
        return 0.0;
    }
    return a / b;
}

fn sl_mod(a: f32, b: f32) -> f32 {
    if b == 0.0 {
        return 0.0;
    }
    return a - b * floor(a / b);
}

fn sl_round(x: f32) -> f32 {
    let t = trunc(x);
    return select(t, t + sign(x), abs(x - t) >= 0.5);
}

fn sl_sqrt(x: f32) -> f32 {
    return sqrt(max(x, 0.0));
}

fn sl_inverse_sqrt(x: f32) -> f32 {
    if x > 0.0 {
        return 1.0 / sqrt(x);
    }
    return 0.0;
}

fn sl_log(x: f32) -> f32 {
    return log(max(x, 1.17549435e-38));
}

fn sl_log_base(x: f32, base: f32) -> f32 {
    return sl_divide(sl_log(x), sl_log(base));
}

// x to the power of y; 0 where it is not a number, and the largest number where it is infinite.
fn sl_power(x: f32, y: f32) -> f32 {
    if y == 0.0 || x == 1.0 {
        return 1.0;
    }
    if x == 0.0 {
        return select(3.40282347e38, 0.0, y > 0.0);
    }
    if x > 0.0 {
        return pow(x, y);
    }
    if floor(y) != y {
        return 0.0;
    }
    let p = pow(-x, y);
    let half = 0.5 * y;
    return select(p, -p, floor(half) != half);
}

// A whole number, the nearest there is where x is too large.
fn sl_whole(x: f32) -> i32 {
    if x >= 2147483648.0 {
        return 2147483647;
    }
    if x <= -2147483648.0 {
        return -2147483647 - 1;
    }
    return i32(x);
}

fn sl_unsigned(x: f32) -> u32 {
    if x >= 4294967296.0 {
        return 4294967295u;
    }
    return u32(max(x, 0.0));
}

// The quadrant of an angle, and the angle from its middle: parts of pi/2 of 12 bits each, whose products are exact.
fn sl_quadrant(x: f32) -> vec2<f32> {
    let k = round(x * 0.636619772);
    let high = trunc(k / 4096.0) * 4096.0;
    let low = k - high;
    var r = x - high * 1.5703125;
    r -= low * 1.5703125;
    r -= high * 0.0004837512969970703125;
    r -= low * 0.0004837512969970703125;
    r -= high * 7.54953362047672271728515625e-8;
    r -= low * 7.54953362047672271728515625e-8;
    r -= k * 2.56334415e-12;
    return vec2<f32>(k - 4.0 * floor(0.25 * k), r);
}

// Sine and cosine of an angle of at most pi/4 (polynomials of Cephes).
fn sl_sin_small(x: f32) -> f32 {
    let z = x * x;
    return ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1) * z * x + x;
}

fn sl_cos_small(x: f32) -> f32 {
    let z = x * x;
    return ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2) * z * z - 0.5 * z + 1.0;
}

fn sl_sin_in(quadrant: f32, r: f32) -> f32 {
    let even = quadrant == 0.0 || quadrant == 2.0;
    let s = select(sl_cos_small(r), sl_sin_small(r), even);
    return select(s, -s, quadrant >= 2.0);
}

// Angles beyond these are left to the device.
const FAR_ANGLE: f32 = 1.2e7;

fn sl_sin(x: f32) -> f32 {
    if abs(x) > FAR_ANGLE {
        return sin(x);
    }
    let q = sl_quadrant(x);
    return sl_sin_in(q.x, q.y);
}

fn sl_cos(x: f32) -> f32 {
    if abs(x) > FAR_ANGLE {
        return cos(x);
    }
    let q = sl_quadrant(x);
    return sl_sin_in(select(q.x + 1.0, 0.0, q.x == 3.0), q.y);
}

fn sl_tan(x: f32) -> f32 {
    return sl_sin(x) / sl_cos(x);
}

fn sl_asin_small(x: f32) -> f32 {
    let z = x * x;
    let p = (((4.2163199048e-2 * z + 2.4181311049e-2) * z + 4.5470025998e-2) * z + 7.4953002686e-2) * z + 1.6666752422e-1;
    return p * z * x + x;
}

fn sl_asin(y: f32) -> f32 {
    let x = clamp(y, -1.0, 1.0);
    let a = abs(x);
    if a <= 0.5 {
        return sl_asin_small(x);
    }
    let s = 1.57079637 - 2.0 * sl_asin_small(sqrt(0.5 * (1.0 - a)));
    return select(s, -s, x < 0.0);
}

fn sl_acos(y: f32) -> f32 {
    let x = clamp(y, -1.0, 1.0);
    if x > 0.5 {
        return 2.0 * sl_asin_small(sqrt(0.5 * (1.0 - x)));
    }
    if x < -0.5 {
        return 3.14159274 - 2.0 * sl_asin_small(sqrt(0.5 * (1.0 + x)));
    }
    return 1.57079637 - sl_asin_small(x);
}

fn sl_atan(y: f32) -> f32 {
    var x = abs(y);
    var start = 0.0;
    if x > 2.41421356 {
        start = 1.57079637;
        x = -1.0 / x;
    } else if x > 0.414213562 {
        start = 0.785398163;
        x = (x - 1.0) / (x + 1.0);
    }
    let z = x * x;
    let p = ((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1;
    let a = start + p * z * x + x;
    return select(a, -a, y < 0.0);
}

// Whether the sign of a number is set, that of -0 too.
fn sl_is_negative(x: f32) -> bool {
    return (bitcast<u32>(x) >> 31u) == 1u;
}

fn sl_atan2(y: f32, x: f32) -> f32 {
    let negative = sl_is_negative(y);
    if y == 0.0 {
        let a = select(0.0, 3.14159274, sl_is_negative(x));
        return select(a, -a, negative);
    }
    if x == 0.0 {
        return select(1.57079637, -1.57079637, negative);
    }
    let a = sl_atan(y / x);
    if x > 0.0 {
        return a;
    }
    return select(a + 3.14159274, a - 3.14159274, negative);
}

fn sl_smoothstep(low: f32, high: f32, x: f32) -> f32 {
    if x < low || high <= low {
        return f32(x >= low);
    }
    let t = min((x - low) / (high - low), 1.0);
    return t * t * (3.0 - 2.0 * t);
}

fn sl_normalize(v: vec3<f32>) -> vec3<f32> {
    let l = sqrt(dot(v, v));
    if l > 0.0 {
        return v / l;
    }
    return vec3<f32>();
}

fn sl_refract(i: vec3<f32>, n: vec3<f32>, eta: f32) -> vec3<f32> {
    let d = dot(i, n);
    let k = 1.0 - eta * eta * (1.0 - d * d);
    if k < 0.0 {
        return vec3<f32>();
    }
    return eta * i - (eta * d + sqrt(k)) * n;
}

// Tells the turn of a loop, and that of those around it, apart from others.
fn sl_turn(outer: u32, turn: u32) -> u32 {
    let h = (outer ^ turn) * 0xc2b2ae35u;
    return ((h << 13u) | (h >> 19u)) + turn;
}

// A vector of length 1; one of no length as it is.
fn sl_unit(v: vec3<f32>) -> vec3<f32> {
    let l = sqrt(dot(v, v));
    if l > 0.0 {
        return v / l;
    }
    return v;
}
