//! Axes: ticks at round numbers, as many as fit, and their labels.

/// Ticks of an axis and how they are written.
#[derive(Debug)]
pub struct Ticks {
    /// Values of the ticks, in order.
    pub values: Vec<f64>,
    /// Their labels: values over 10^`exponent`.
    pub labels: Vec<String>,
    /// The power of ten that is taken out of the labels, a multiple of 3.
    pub exponent: i32,
}

/// Round steps between ticks: these times a power of ten, and decimals that each needs.
const ROUND: [(f64, i32); 4] = [(1.0, 0), (2.0, 0), (2.5, 1), (5.0, 0)];

/// The ticks from `lo` to `hi`, as many as `fits` allows: it gets the labels and the distance between two ticks as a fraction of the
/// axis.
pub fn ticks([lo, hi]: [f64; 2], fits: impl Fn(&[String], f64) -> bool) -> Ticks {
    let greatest = lo.abs().max(hi.abs());
    let exponent = match greatest {
        1e-2..1e5 => 0,
        _ => (greatest.log10() / 3.0).floor() as i32 * 3,
    };
    let least_power = ((hi - lo).log10().floor() as i32) - 2;
    let mut last = Ticks { values: vec![], labels: vec![], exponent };
    for power in least_power..least_power + 4 {
        for (round, decimals) in ROUND {
            let step = round * 10f64.powi(power);
            let decimals = (decimals - (power - exponent)).max(0) as usize;
            let (first, end) = ((lo / step - 1e-9).ceil() as i64, (hi / step + 1e-9).floor() as i64);
            if end - first > 200 {
                continue;
            }
            let values: Vec<f64> = (first..=end).map(|i| i as f64 * step).collect();
            let labels: Vec<String> = values.iter().map(|v| label(*v, exponent, decimals)).collect();
            let is_fit = fits(&labels, step / (hi - lo));
            if is_fit || last.values.is_empty() || labels.len() >= 2 {
                last = Ticks { values, labels, exponent };
            }
            if is_fit {
                return last;
            }
        }
    }
    last
}

fn label(value: f64, exponent: i32, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value / 10f64.powi(exponent));
    let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c));
    let digits = text.trim_start_matches('-');
    if text.starts_with('-') && !is_zero { format!("−{digits}") } else { digits.to_string() }
}

/// A value as text of a few digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.abs().to_string();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let decimals = if size >= 1000.0 {
        0
    } else if size >= 10.0 {
        1
    } else {
        3
    };
    label(value, 0, decimals)
}

/// The name of an axis: what it shows, and in brackets the power of ten and the unit.
pub fn name(quantity: &str, unit: &str, exponent: i32) -> String {
    let unit = match (exponent, unit) {
        (0, "") => "-".to_string(),
        (0, unit) => unit.to_string(),
        (e, unit) => format!("1e{} {unit}", e.to_string().replace('-', "−")).trim_end().to_string(),
    };
    format!("{quantity} [{unit}]").trim_start().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_most(n: usize) -> impl Fn(&[String], f64) -> bool {
        move |labels, _| labels.len() <= n
    }

    #[test]
    fn ticks_are_round_numbers() {
        let labels = |range, n| ticks(range, at_most(n)).labels.join(" ");
        assert_eq!(labels([0.0, 1.0], 6), "0.0 0.2 0.4 0.6 0.8 1.0");
        assert_eq!(labels([0.0, 1.0], 5), "0.00 0.25 0.50 0.75 1.00");
        assert_eq!(labels([-3.0, 7.5], 5), "−2 0 2 4 6");
        assert_eq!(labels([-0.06, 0.06], 4), "−0.05 0.00 0.05");
        assert_eq!(labels([1000.0, 1000.004], 3), "1000.000 1000.002 1000.004");
        assert_eq!(labels([0.0, 12_000.0], 4), "0 5000 10000");
    }

    #[test]
    fn large_and_small_values_have_a_common_power_of_ten() {
        let small = ticks([0.0, 4e-7], at_most(5));
        assert_eq!((small.labels.join(" "), small.exponent), ("0 100 200 300 400".into(), -9));
        let large = ticks([-2e6, 3e6], at_most(6));
        assert_eq!((large.labels.join(" "), large.exponent), ("−2 −1 0 1 2 3".into(), 6));
        assert_eq!(name("fx", "N", -9), "fx [1e−9 N]");
        assert_eq!((name("", "m/s", 0), name("contacts", "", 0)), ("[m/s]".into(), "contacts [-]".into()));
    }

    #[test]
    fn values_are_short() {
        assert_eq!([0.0, -12.34, 5678.9, 1.5e-5, -2e9].map(short).join(" "), "0 −12.3 5679 1.50e−5 −2.00e9");
    }
}
