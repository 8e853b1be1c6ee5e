//! Wounds: bytes that are changed, cut out, repeated, or taken from another file.

/// Numbers that are the same every time.
pub struct Random(u64);

impl Random {
    /// Numbers by a name.
    pub fn new(name: &str) -> Random {
        Random(name.bytes().fold(7, |seed, byte| seed * 31 + u64::from(byte)))
    }

    /// A number below another.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// Numbers that readers stumble over.
const NUMBERS: [&str; 12] = [
    "0",
    "-1",
    "1e30",
    "-1e30",
    "1e999",
    "nan",
    "inf",
    "4294967296",
    "2147483647",
    "1e-30",
    "99999999999999999999",
    "3",
];

/// A sample with one to four wounds.
pub fn wounded(samples: &[Vec<u8>], is_text: bool, random: &mut Random) -> Vec<u8> {
    let mut bytes = samples[random.below(samples.len())].clone();
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            bytes.push(b'\n');
        }
        wound(&mut bytes, samples, is_text, random);
    }
    bytes
}

fn wound(bytes: &mut Vec<u8>, samples: &[Vec<u8>], is_text: bool, random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(8) {
        0 => bytes[at] = random.below(256) as u8,
        1 => bytes.truncate(at),
        2 => {
            let other = &samples[random.below(samples.len())];
            let (a, b) = (random.below(other.len()), random.below(other.len()));
            bytes.splice(at..at, other[a.min(b)..a.max(b)].iter().copied());
        }
        3 => {
            let end = (at + random.below(20)).min(bytes.len());
            bytes.drain(at..end);
        }
        4 => bytes.insert(at, b"0123456789[](){}\";,.-+*/#:"[random.below(26)]),
        5 if is_text => number(bytes, at, random),
        5 => {
            // A length or an offset that lies.
            let lie = [0, 1, 0xff, 0x7f, 0x80][random.below(5)];
            let end = (at + 1 + random.below(8)).min(bytes.len());
            bytes[at..end].fill(lie);
        }
        6 => bytes[at] ^= 1 << random.below(8),
        _ => {
            let end = (at + random.below(40)).min(bytes.len());
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
    }
}

/// Replace the next number of a text.
fn number(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let is_part = |b: &u8| b.is_ascii_digit() || b".-+e".contains(b);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else { return };
    let end = bytes[start..].iter().position(|b| !is_part(b)).map_or(bytes.len(), |k| start + k);
    bytes.splice(start..end, NUMBERS[random.below(NUMBERS.len())].bytes());
}
