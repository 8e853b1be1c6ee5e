//! Keyframes of a camera: between them every number goes smoothly, without running over the values of its keys.

use crate::binding::Key;

/// Where a camera is and how wide it sees: eye, point that it looks at, angle of view.
pub type View = [f32; 7];

/// The view in a frame: before the first key and after the last it stands still, and at a cut it jumps.
pub fn view(keys: &[Key], frame: f64) -> Option<View> {
    // The shot that the frame is in: the keys from one cut up to the next.
    let begins = |i: &usize| *i == 0 || keys[*i].cut;
    let first = (0..keys.len()).rev().filter(begins).find(|i| *i == 0 || keys[*i].frame <= frame)?;
    let end = (first + 1..keys.len()).find(|i| keys[*i].cut).unwrap_or(keys.len());
    let shot = &keys[first..end];
    let frames: Vec<f64> = shot.iter().map(|key| key.frame).collect();
    let mut view = shot[0].view();
    for (c, x) in view.iter_mut().enumerate() {
        let values: Vec<f64> = shot.iter().map(|key| key.view()[c] as f64).collect();
        *x = smooth(&frames, &values, frame) as f32;
    }
    Some(view)
}

/// The value at `t` of the smooth curve through points: a cubic in each interval, whose slopes are zero at both ends and where the values
/// turn, and else a weighted harmonic mean of those beside it, so that it rises and falls only as the points do (Fritsch and Butland 1984).
fn smooth(times: &[f64], values: &[f64], t: f64) -> f64 {
    let last = times.len() - 1;
    let t = t.clamp(times[0], times[last]);
    let k = times[1..].partition_point(|x| *x <= t).min(last.saturating_sub(1));
    if last == 0 {
        return values[0];
    }
    let rise = |i: usize| (values[i + 1] - values[i]) / (times[i + 1] - times[i]);
    let slope = |i: usize| {
        if i == 0 || i == last || rise(i - 1) * rise(i) <= 0.0 {
            return 0.0;
        }
        let (before, after) = (times[i] - times[i - 1], times[i + 1] - times[i]);
        let weights = [2.0 * after + before, after + 2.0 * before];
        (weights[0] + weights[1]) / (weights[0] / rise(i - 1) + weights[1] / rise(i))
    };
    let (h, x) = (times[k + 1] - times[k], (t - times[k]) / (times[k + 1] - times[k]));
    let (x2, x3) = (x * x, x * x * x);
    let [a, b] = [values[k], values[k + 1]];
    a + (b - a) * (3.0 * x2 - 2.0 * x3) + h * (slope(k) * (x3 - 2.0 * x2 + x) + slope(k + 1) * (x3 - x2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(frame: f64, x: f32, cut: bool) -> Key {
        Key { frame, eye: [x, 0.0, 0.0], look_at: [0.0; 3], fov: 30.0 + x, cut }
    }

    #[test]
    fn curves_go_through_their_keys_smoothly_and_never_over_them() {
        let (times, values) = ([0.0, 10.0, 12.0, 30.0, 50.0], [1.0, 5.0, 6.0, 6.0, 2.0]);
        let at = |t: f64| smooth(&times, &values, t);
        for (t, v) in times.iter().zip(values) {
            assert!((at(*t) - v).abs() < 1e-12, "at {t}");
        }
        let path: Vec<f64> = (0..=5000).map(|i| at(i as f64 / 100.0)).collect();
        for (i, pair) in path.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            let expected = if i < 1200 {
                1.0
            } else if i < 3000 {
                0.0
            } else {
                -1.0
            };
            assert!(
                step * expected >= -1e-12 && (expected != 0.0 || step.abs() < 1e-12),
                "at {}: {step}",
                i as f64 / 100.0
            );
        }
        // No speed jumps, and none at the ends.
        let speeds: Vec<f64> = path.windows(2).map(|p| 100.0 * (p[1] - p[0])).collect();
        assert!(speeds.windows(2).all(|v| (v[1] - v[0]).abs() < 0.02) && speeds[0].abs() < 0.01);
        assert_eq!([at(-3.0), at(70.0), smooth(&[4.0], &[7.0], 9.0)], [1.0, 2.0, 7.0]);
    }

    #[test]
    fn a_cut_jumps_and_shots_keep_apart() {
        let keys = [key(0.0, 0.0, false), key(10.0, 4.0, false), key(20.0, 100.0, true), key(30.0, 90.0, false)];
        let at = |frame: f64| view(&keys, frame).unwrap();
        assert_eq!([at(0.0)[0], at(5.0)[0], at(10.0)[0], at(19.9)[0]], [0.0, 2.0, 4.0, 4.0]);
        assert_eq!([at(20.0)[0], at(25.0)[0], at(99.0)[0], at(-1.0)[0]], [100.0, 95.0, 90.0, 0.0]);
        assert_eq!((at(5.0)[6], view(&[], 1.0)), (32.0, None));
    }
}
