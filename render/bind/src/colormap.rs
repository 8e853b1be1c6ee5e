//! Named colour maps: from a number in [0, 1] to a linear colour.

/// A colour map: colours at even steps of [0, 1], interpolated between.
#[derive(Clone, Copy, Debug)]
pub struct Map {
    /// Colours at even steps, as sRGB hexadecimal.
    stops: &'static [u32],
}

/// Maps by name.
const MAPS: &[(&str, &[u32])] = &[
    ("viridis", &[0x440154, 0x482878, 0x3e4a89, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725]),
    ("plasma", &[0x0d0887, 0x46039f, 0x7201a8, 0x9c179e, 0xbd3786, 0xd8576b, 0xed7953, 0xfb9f3a, 0xfdca26, 0xf0f921]),
    ("inferno", &[0x000004, 0x1b0c41, 0x4a0c6b, 0x781c6d, 0xa52c60, 0xcf4446, 0xed6925, 0xfb9b06, 0xf7d13d, 0xfcffa4]),
    (
        "turbo",
        &[
            0x30123b, 0x4145ab, 0x4675ed, 0x39a2fc, 0x1bcfd4, 0x24eca6, 0x61fc6c, 0xa4fc3b, 0xd1e834, 0xf3c63a,
            0xfe9b2d, 0xf36315, 0xd93806, 0xb11901, 0x7a0402,
        ],
    ),
    ("coolwarm", &[0x3b4cc0, 0x7b9ff9, 0xc0d4f5, 0xf2cbb7, 0xee8468, 0xb40426]),
    ("gray", &[0x000000, 0xffffff]),
    // Not a scale: the colours that crushed stone comes in, for telling stones apart.
    ("stone", &[0x8f7f6c, 0xb09a80, 0x7d7a76, 0xa48a6d, 0x948d84, 0xc2ad92, 0x86705c, 0xa39c92]),
];

/// The names of all maps.
pub fn names() -> Vec<&'static str> {
    MAPS.iter().map(|(n, _)| *n).collect()
}

/// The colour map of this name, if there is one.
pub fn named(name: &str) -> Option<Map> {
    MAPS.iter().find(|(n, _)| *n == name).map(|(_, stops)| Map { stops })
}

impl Map {
    /// The linear colour at `t`, which is clamped to [0, 1]; NaN gives magenta, which no map has.
    pub fn color(self, t: f64) -> [f32; 3] {
        if t.is_nan() {
            return [1.0, 0.0, 1.0];
        }
        let stops = self.stops;
        let x = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        let i = (x as usize).min(stops.len() - 2);
        let part = |hex: u32, c: usize| (hex >> (16 - 8 * c) & 255) as f64 / 255.0;
        let mixed = |c: usize| part(stops[i], c) + (part(stops[i + 1], c) - part(stops[i], c)) * (x - i as f64);
        [0, 1, 2].map(|c| linear(mixed(c)) as f32)
    }
}

/// An sRGB value as a linear one.
fn linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_strays() {
        let gray = named("gray").unwrap();
        assert_eq!(gray.color(0.0), [0.0; 3]);
        assert_eq!(gray.color(7.0), [1.0; 3]);
        assert!(named("none").is_none());
        assert!(named("viridis").unwrap().color(0.5)[1] > 0.2);
    }
}
