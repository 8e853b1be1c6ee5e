//! The ranges of colours that the metadata leaves open: one for all frames of the data, so that the images of an animation agree.

use crate::job::ImageJob;
use crate::ledger::Ledger;
use crate::levels;
use crate::progress::Progress;
use crate::report::Outcome;
use bind::binding::{Arrow, Camera, Color, Shape};
use bind::data::Source;
use bind::{Binding, Moment, emit};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// What has been found so far, in the ledger's folder.
#[derive(Default, Serialize, Deserialize)]
struct Found {
    /// Hash of the objects and of how the data is read.
    of: String,
    /// Of each frame, what its table was, and the ranges of each object's values, then those of the lengths of its arrows.
    frames: BTreeMap<u64, (String, Vec<Option<[f64; 2]>>)>,
    /// Where what the camera follows is in each frame.
    #[serde(default)]
    followed: BTreeMap<u64, [f64; 3]>,
}

impl Found {
    /// The range of an object's values in all frames; after those of all objects, of the lengths of its arrows.
    fn range(&self, object: usize) -> Option<[f64; 2]> {
        let ranges = self.frames.values().filter_map(|(_, ranges)| *ranges.get(object)?);
        ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}

/// Settle the ranges that are open, and the levels of the film, of a job and of its passes.
pub fn settle(job: &mut ImageJob) -> Outcome {
    let kept = Ledger::of(&job.folder).folder().join("ranges.json");
    of_data(&mut job.binding, &job.source, Some(&kept))?;
    levels::settle(&mut job.binding, &job.source, &job.files);
    for pass in &mut job.passes {
        // Both eyes see one film.
        if pass.binding.scene == job.binding.scene {
            pass.binding.output.levels = pass.binding.output.levels.or(job.binding.output.levels);
        }
        settle(pass)?;
    }
    Ok(())
}

/// Settle the ranges that a binding leaves open, of all frames of its data; what has been found is kept in a file.
pub fn of_data(binding: &mut Binding, source: &Source, kept: Option<&Path>) -> Outcome {
    if !binding.is_open() {
        return Ok(());
    }
    let (found, before) = match binding.depends_on_values() {
        true => scan(binding, source, kept)?,
        false => Default::default(),
    };
    settle_camera(binding, source, &found);
    let n = binding.objects.len();
    for i in 0..n {
        let Some([_, longest]) = found.range(n + i) else { continue };
        if longest == 0.0 || !matches!(binding.objects[i].shape, Shape::Arrow(Arrow { scale: None, .. })) {
            continue;
        }
        let by_longest = significant(emit::arrow_scale(binding, i, longest)?);
        let object = &mut binding.objects[i];
        if let Shape::Arrow(Arrow { scale, .. }) = &mut object.shape {
            *scale = Some(by_longest);
        }
        let name = &object.name;
        eprintln!(
            "note: the longest arrow of `{name}` is {}, drawn {} m long: `scale: {by_longest}`",
            significant(longest),
            significant(by_longest * longest)
        );
    }
    for (i, object) in binding.objects.iter_mut().enumerate() {
        if let Color::By { range: range @ None, .. } = &mut object.color {
            *range = found.range(i);
            if let Some([a, b]) = before.range(i).filter(|was| before.of == found.of && Some(*was) != *range) {
                let [a, b] = short([a, b]);
                eprintln!("note: the colours of `{}` went from {a} to {b}: all its images are stale", object.name);
            }
            if let Some([lo, hi]) = range {
                let frames = if source.missing().is_empty() {
                    "of all frames"
                } else {
                    "of the frames so far: these images are drafts, and are drawn again once others change it"
                };
                let [lo, hi] = short([*lo, *hi]);
                eprintln!("note: the colours of `{}` go from {lo} to {hi}, the range {frames}", object.name);
            }
        }
    }
    Ok(())
}

/// A number of three significant digits.
fn significant(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// The ends of a range with three digits of its width, which tell them apart however large they are.
fn short([lo, hi]: [f64; 2]) -> [f64; 2] {
    let digits = 2.0 - (hi - lo).abs().log10().floor();
    if !(-300.0..=300.0).contains(&digits) {
        return [lo, hi].map(significant);
    }
    // Through text, so that 0.1 is printed as it is.
    let round = |x: f64| match digits > 0.0 {
        true => format!("{x:.0$}", digits as usize).parse().unwrap_or(x),
        false => (x * 10f64.powf(digits)).round() / 10f64.powf(digits),
    };
    [lo, hi].map(round).map(|x| if x == 0.0 { 0.0 } else { x })
}

/// Settle the way of the camera, over the frames of the data and those that it will have.
fn settle_camera(binding: &mut Binding, source: &Source, found: &Found) {
    let numbers = source.expected();
    if let (Some(Camera::Placed(camera)), Some(first), Some(last)) =
        (&mut binding.camera, numbers.first(), numbers.last())
    {
        camera.settle([*first, *last], &found.followed);
    }
}

/// The ranges of all frames of the data, and what was kept of them. Frames that were looked at before, and are as they were, are not read again; those that cannot
/// be read have none.
fn scan(binding: &Binding, source: &Source, kept: Option<&Path>) -> Outcome<(Found, Found)> {
    let read = |bytes: Vec<u8>| serde_json::from_slice::<Found>(&bytes).ok();
    let before = kept.and_then(|path| read(std::fs::read(path).ok()?)).unwrap_or_default();
    let follow = match &binding.camera {
        Some(Camera::Placed(camera)) => camera.follow.as_ref().map(|follow| &follow.expr),
        _ => None,
    };
    let text = format!("{:?}{:?}{:?}{follow:?}", binding.objects, source.derive, source.select);
    let of = blake3::hash(text.as_bytes()).to_hex().to_string();
    let is_known = before.of == of;
    let mut found = Found { of, frames: BTreeMap::new(), followed: BTreeMap::new() };
    let numbers = source.numbers();
    let mut progress = None;
    for (done, number) in numbers.iter().enumerate() {
        let stamp = source.stamp(*number);
        if let Some(known) = before.frames.get(number).filter(|known| is_known && known.0 == stamp) {
            found.frames.insert(*number, known.clone());
            found.followed.extend(before.followed.get(number).map(|place| (*number, *place)));
            continue;
        }
        let progress =
            progress.get_or_insert_with(|| Progress::start("looking for ranges", numbers.len() as u64, "frames"));
        let ranges = source.read(*number).and_then(|table| {
            found.followed.extend(emit::followed(binding, &table).map(|place| (*number, place)));
            let moment = Moment::still(binding, source, &table)?;
            Ok([emit::color_ranges(binding, &moment), emit::arrow_ranges(binding, &moment)].concat())
        });
        found.frames.insert(*number, (stamp, ranges.unwrap_or_default()));
        progress.at(done as u64 + 1);
    }
    if let Some(progress) = progress {
        progress.finish();
        let bytes = serde_json::to_vec(&found).unwrap_or_default();
        kept.map(|path| frame::atomic::write(path, &bytes)).transpose()?;
    }
    Ok((found, before))
}

#[cfg(test)]
mod tests {
    use super::{short, significant};

    #[test]
    fn notes_have_three_digits() {
        assert_eq!([0.123456789, 98765.4, 0.0, -2.0].map(significant), [0.123, 98800.0, 0.0, -2.0]);
        assert_eq!(significant(1e-9).to_string(), "0.000000001");
    }

    #[test]
    fn ranges_have_three_digits_of_their_width() {
        let text = |lo, hi| short([lo, hi]).map(|x| x.to_string()).join(" ");
        assert_eq!(text(0.0000193, 4.081361293), "0 4.08");
        assert_eq!(text(-0.0001, 0.02605000138282776), "-0.0001 0.0261");
        assert_eq!(text(1000.12345678, 1000.4567891), "1000.123 1000.457");
        assert_eq!(text(12345.678, 9876543.21), "10000 9880000");
        assert_eq!(text(0.123456, 0.123456), "0.123 0.123");
        assert_eq!(text(0.5, f64::INFINITY), "0.5 inf");
    }
}
