//! Colour spaces (RISpec 15.3): numbers of one as numbers of another, through RGB with the primaries and white of Rec. 709.

/// The names of the spaces.
pub const SPACES: [&str; 8] = ["rgb", "RGB", "hsv", "hsl", "xyz", "XYZ", "xyY", "YIQ"];

/// RGB to CIE XYZ (IEC 61966-2-1), rows.
const TO_XYZ: [[f32; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.019_333_9, 0.119_192, 0.950_304_1],
];
/// Its inverse.
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];
/// RGB to YIQ of the NTSC standard, rows.
const TO_YIQ: [[f32; 3]; 3] =
    [[0.299, 0.587, 0.114], [0.595_716, -0.274_453, -0.321_263], [0.211_456, -0.522_591, 0.311_135]];

/// A colour of space `from` in space `to`; unknown spaces count as RGB.
pub fn convert(from: &str, to: &str, c: [f32; 3]) -> [f32; 3] {
    if from == to { c } else { from_rgb(to, to_rgb(from, c)) }
}

fn times(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|r| m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2])
}

fn to_rgb(space: &str, c: [f32; 3]) -> [f32; 3] {
    match space {
        "hsv" => {
            let chroma = c[2] * c[1];
            hue(c[0], chroma).map(|x| x + c[2] - chroma)
        }
        "hsl" => {
            let chroma = (1.0 - (2.0 * c[2] - 1.0).abs()) * c[1];
            hue(c[0], chroma).map(|x| x + c[2] - 0.5 * chroma)
        }
        "xyz" | "XYZ" => times(&FROM_XYZ, c),
        "xyY" if c[1] == 0.0 => [0.0; 3],
        "xyY" => times(&FROM_XYZ, [c[0] * c[2] / c[1], c[2], (1.0 - c[0] - c[1]) * c[2] / c[1]]),
        "YIQ" => {
            let m = glam::Mat3::from_cols_array_2d(&TO_YIQ).transpose().inverse();
            (m * glam::Vec3::from(c)).into()
        }
        _ => c,
    }
}

fn from_rgb(space: &str, c: [f32; 3]) -> [f32; 3] {
    let (max, min) = (c[0].max(c[1]).max(c[2]), c[0].min(c[1]).min(c[2]));
    let chroma = max - min;
    let hue = if chroma == 0.0 {
        0.0
    } else if max == c[0] {
        ((c[1] - c[2]) / chroma).rem_euclid(6.0) / 6.0
    } else if max == c[1] {
        ((c[2] - c[0]) / chroma + 2.0) / 6.0
    } else {
        ((c[0] - c[1]) / chroma + 4.0) / 6.0
    };
    let xyz = times(&TO_XYZ, c);
    match space {
        "hsv" => [hue, if max > 0.0 { chroma / max } else { 0.0 }, max],
        "hsl" => {
            let light = 0.5 * (max + min);
            let room = 1.0 - (2.0 * light - 1.0).abs();
            [hue, if room > 0.0 { chroma / room } else { 0.0 }, light]
        }
        "xyz" | "XYZ" => xyz,
        "xyY" => match xyz.iter().sum::<f32>() {
            0.0 => [0.0; 3],
            sum => [xyz[0] / sum, xyz[1] / sum, xyz[1]],
        },
        "YIQ" => times(&TO_YIQ, c),
        _ => c,
    }
}

/// RGB of a hue (0 to 1) and a chroma, whose smallest component is 0.
fn hue(h: f32, chroma: f32) -> [f32; 3] {
    let h = h.rem_euclid(1.0) * 6.0;
    let x = chroma * (1.0 - (h % 2.0 - 1.0).abs());
    match h as u32 {
        0 => [chroma, x, 0.0],
        1 => [x, chroma, 0.0],
        2 => [0.0, chroma, x],
        3 => [0.0, x, chroma],
        4 => [x, 0.0, chroma],
        _ => [chroma, 0.0, x],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < 2e-5)
    }

    #[test]
    fn known_values() {
        assert!(near(convert("hsv", "rgb", [1.0 / 3.0, 1.0, 1.0]), [0.0, 1.0, 0.0]));
        assert!(near(convert("hsl", "rgb", [2.0 / 3.0, 1.0, 0.5]), [0.0, 0.0, 1.0]));
        assert!(near(convert("rgb", "hsv", [0.5, 0.25, 0.25]), [0.0, 0.5, 0.5]));
        assert!(near(convert("rgb", "YIQ", [1.0, 1.0, 1.0]), [1.0, 0.0, 0.0]));
        // The white of Rec. 709 is D65.
        assert!(near(convert("rgb", "xyY", [1.0; 3]), [0.312_73, 0.329_02, 1.0]));
    }

    #[test]
    fn there_and_back() {
        for space in SPACES {
            for c in [[0.2, 0.5, 0.8], [0.9, 0.1, 0.3], [0.4, 0.4, 0.1]] {
                assert!(near(convert(space, "rgb", convert("rgb", space, c)), c), "{space} {c:?}");
            }
        }
    }
}
