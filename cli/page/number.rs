//! Numbers as a page writes them: four digits that count, thin spaces between thousands, powers of ten where there would be many zeros.

/// A number with four digits.
pub fn short(x: f64) -> String {
    with_digits(x, 4)
}

/// A number with its unit; a pure number has none.
pub fn quantity(x: f64, unit: &str) -> String {
    format!("{} {unit}", short(x)).trim_end().to_string()
}

/// A count.
pub fn count(n: u64) -> String {
    grouped(&n.to_string())
}

/// A count with what is counted: `1 frame`, `3 frames`.
pub fn counted(n: u64, what: &str) -> String {
    format!("{} {what}{}", count(n), if n == 1 { "" } else { "s" })
}

/// A time, s, with minutes and hours where it is long.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match seconds {
        s if !(s >= 100.0) => quantity(seconds, "s"),
        s if s < 3600.0 => format!("{} s ({} min {} s)", count(whole), whole / 60, whole % 60),
        _ => format!("{} s ({} h {} min)", count(whole), whole / 3600, whole % 3600 / 60),
    }
}

/// A size of a file.
pub fn size(bytes: u64) -> String {
    const UNITS: [&str; 4] = ["KiB", "MiB", "GiB", "TiB"];
    if bytes < 1024 {
        return format!("{bytes} B");
    }
    let mut value = bytes as f64 / 1024.0;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    format!("{} {}", with_digits(value, 3), UNITS[unit])
}

/// A number with some digits that count.
fn with_digits(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return "–".into();
    }
    if x == 0.0 {
        return "0".into();
    }
    let text = format!("{:.*e}", digits - 1, x);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let plain = match exponent {
        -3..6 => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            // Rounded to the digits first: 99999.6 has no more of them than 100000.
            let rounded: f64 = text.parse().unwrap_or(x);
            grouped(&without_zeros(&format!("{rounded:.decimals$}")))
        }
        _ => format!("{} × 10{}", without_zeros(mantissa), raised(exponent)),
    };
    plain.replace('-', "−")
}

/// A number without the zeros at the end of its decimals.
fn without_zeros(text: &str) -> String {
    if !text.contains('.') {
        return text.into();
    }
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// The digits before the point in groups of three, where there are more than four.
fn grouped(text: &str) -> String {
    let (sign, rest) = text.strip_prefix('-').map_or(("", text), |rest| ("-", rest));
    let (whole, decimals) = rest.split_at(rest.find('.').unwrap_or(rest.len()));
    if whole.len() < 5 {
        return text.into();
    }
    let mut out = sign.to_string();
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out + decimals
}

/// A whole number as an exponent.
fn raised(n: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    n.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (-0.25, "−0.25"),
            (3.21654, "3.217"),
            (0.001234567, "0.001235"),
            (0.000123456, "1.235 × 10⁻⁴"),
            (12345.6, "12\u{202f}350"),
            (123456.0, "123\u{202f}500"),
            (-1.5e9, "−1.5 × 10⁹"),
            (999999.0, "1 × 10⁶"),
            (f64::NAN, "–"),
        ];
        for (x, expected) in cases {
            assert_eq!(short(x), expected, "{x}");
        }
        assert_eq!([0.5, 204.4, 7300.0].map(duration), ["0.5 s", "204 s (3 min 24 s)", "7300 s (2 h 1 min)"]);
        assert_eq!([12, 2048, 3 << 20].map(size), ["12 B", "2 KiB", "3 MiB"]);
        assert_eq!(count(1234567), "1\u{202f}234\u{202f}567");
        assert_eq!(quantity(2.0, ""), "2");
    }
}
