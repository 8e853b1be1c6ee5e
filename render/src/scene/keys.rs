//! Keys: values at rising times, straight in between, in a stream's time or in parts of the time that the shutter is open.

use glam::{Mat4, Vec3};

/// What may lie between two values.
pub trait Blend: Copy {
    /// A part `t` of the way to another value.
    fn blend(self, to: Self, t: f32) -> Self;
}

impl Blend for Mat4 {
    fn blend(self, to: Mat4, t: f32) -> Mat4 {
        self * (1.0 - t) + to * t
    }
}

impl Blend for [Vec3; 16] {
    fn blend(mut self, to: [Vec3; 16], t: f32) -> [Vec3; 16] {
        self.iter_mut().zip(to).for_each(|(a, b)| *a = a.lerp(b, t));
        self
    }
}

impl Blend for [f32; 3] {
    fn blend(self, to: [f32; 3], t: f32) -> [f32; 3] {
        Vec3::from(self).lerp(Vec3::from(to), t).to_array()
    }
}

/// The value at a time of keys, of which there is at least one; before the first and after the last it rests.
pub fn at<T: Blend>(keys: &[(f32, T)], time: f32) -> T {
    if time <= keys[0].0 { keys[0].1 } else { from(keys[0], &keys[1..], time) }
}

/// The last of some rising times that is not after another time, the first at least, and the part of the way to the next.
pub fn segment(times: &[f32], time: f32) -> (usize, f32) {
    let before = times.partition_point(|t| *t <= time).saturating_sub(1);
    let part = times.get(before + 1).map_or(0.0, |next| (time - times[before]) / (next - times[before]));
    (before, part.clamp(0.0, 1.0))
}

/// The value at a time from a first key on.
fn from<T: Blend>(first: (f32, T), keys: &[(f32, T)], time: f32) -> T {
    let next = keys.partition_point(|(t, _)| *t <= time);
    let (start, value) = next.checked_sub(1).map_or(first, |i| keys[i]);
    keys.get(next).map_or(value, |(end, to)| value.blend(*to, (time - start) / (end - start)))
}

/// Keys of a stream's time as the scene has them: the value as the shutter opens, and the keys after that up to when it closes.
pub fn in_shutter<T: Blend>(keys: &[(f32, T)], [open, close]: [f32; 2]) -> (T, Vec<(f32, T)>) {
    let first = at(keys, open);
    if !(close > open) {
        return (first, vec![]);
    }
    let inner = keys.iter().map(|(t, _)| *t).filter(|t| *t > open && *t < close);
    let later = inner.chain([close]).map(|t| ((t - open) / (close - open), at(keys, t))).collect();
    (first, later)
}

/// The value at a part of the time that the shutter is open, of a scene's keys.
pub fn later<T: Blend>(first: T, moves: &[(f32, T)], time: f32) -> T {
    from((0.0, first), moves, time)
}
