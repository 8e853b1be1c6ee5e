//! Splines of numbers and triples (RISpec 15.1): the value runs from the second knot to the last but one.

/// The basis matrix of a name, rows by falling powers, and the knots from one segment to the next.
pub(crate) fn basis(name: &str) -> ([[f32; 4]; 4], usize) {
    let scale = |m: [[f32; 4]; 4], s: f32| m.map(|r| r.map(|x| x * s));
    match name {
        "bezier" => ([[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]], 3),
        "bspline" | "b-spline" => (
            scale(
                [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 0.0, 3.0, 0.0], [1.0, 4.0, 1.0, 0.0]],
                1.0 / 6.0,
            ),
            1,
        ),
        "hermite" => ([[2.0, 1.0, -2.0, 1.0], [-3.0, -2.0, 3.0, -1.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]], 2),
        "linear" => ([[0.0; 4], [0.0; 4], [0.0, -1.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0]], 1),
        _ => (
            scale([[-1.0, 3.0, -3.0, 1.0], [2.0, -5.0, 4.0, -1.0], [-1.0, 0.0, 1.0, 0.0], [0.0, 2.0, 0.0, 0.0]], 0.5),
            1,
        ),
    }
}

/// The spline's value; with `solve` before a basis of single numbers, the parameter at which the spline has the value x.
pub fn value(name: &str, x: f32, knots: &[[f32; 16]], width: usize) -> [f32; 16] {
    if let Some(name) = name.strip_prefix("solve") {
        let (mut lo, mut hi) = (0.0f32, 1.0f32);
        let rises = value(name, 1.0, knots, 1)[0] >= value(name, 0.0, knots, 1)[0];
        for _ in 0..32 {
            let middle = 0.5 * (lo + hi);
            let below = value(name, middle, knots, 1)[0] < x;
            if below == rises { lo = middle } else { hi = middle }
        }
        let mut out = [0.0; 16];
        out[0] = 0.5 * (lo + hi);
        return out;
    }
    let (m, step) = basis(name);
    // Too few knots make no segment: the first is the value everywhere.
    let Some(room) = knots.len().checked_sub(4) else { return knots[0] };
    let segments = room / step + 1;
    let t = x.clamp(0.0, 1.0) * segments as f32;
    let segment = (t as usize).min(segments - 1);
    let t = t - segment as f32;
    let k = &knots[segment * step..segment * step + 4];
    let mut out = [0.0; 16];
    for (c, out) in out.iter_mut().enumerate().take(width) {
        let power = m.map(|row| (0..4).map(|i| row[i] * k[i][c]).sum::<f32>());
        *out = ((power[0] * t + power[1]) * t + power[2]) * t + power[3];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worked_by_hand() {
        let knots = [0.0, 1.0, 4.0, 9.0, 16.0].map(|x| {
            let mut v = [0.0; 16];
            v[0] = x;
            v
        });
        // Catmull–Rom goes through its knots, and through a parabola's points between them.
        for (x, y) in [(0.0, 1.0), (0.5, 4.0), (1.0, 9.0), (0.25, 2.25)] {
            assert!((value("catmull-rom", x, &knots, 1)[0] - y).abs() < 1e-6, "{x}");
        }
        assert!((value("linear", 0.75, &knots, 1)[0] - 6.5).abs() < 1e-6);
        assert!((value("bspline", 0.0, &knots, 1)[0] - (0.0 + 4.0 + 4.0) / 6.0).abs() < 1e-6);
        assert!((value("bezier", 0.5, &knots[..4], 1)[0] - (0.0 + 3.0 + 12.0 + 9.0) / 8.0).abs() < 1e-6);
        assert!((value("solvecatmull-rom", 2.25, &knots, 1)[0] - 0.25).abs() < 1e-5);
    }
}
