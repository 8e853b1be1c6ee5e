//! Frame lists: `3`, `0-99`, `0-99x5` (every fifth), `120x5` (every fifth from 120 on), joined by commas.

use std::collections::HashSet;
use std::str::FromStr;

/// A parsed frame list (by [`str::parse`], which reports a malformed list); [`FrameList::select`] applies it to the frames that
/// exist.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameList {
    text: String,
    ranges: Vec<Range>,
}

/// A range of frames: every `step`-th from `first` to `last`, or to the last frame of the data.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Range {
    text: String,
    first: u64,
    last: Option<u64>,
    step: u64,
}

impl FromStr for FrameList {
    type Err = String;

    fn from_str(text: &str) -> Result<FrameList, String> {
        let ranges = text.split(',').map(range).collect::<Result<_, String>>()?;
        Ok(FrameList { text: text.into(), ranges })
    }
}

fn range(text: &str) -> Result<Range, String> {
    let text = text.trim();
    let frame = |s: &str| {
        s.trim()
            .parse::<u64>()
            .map_err(|_| format!("`{text}` is not a list of frames: expected 3, 0-99, 0-99x5 or 120x5"))
    };
    let (bounds, step) = match text.split_once('x') {
        Some((bounds, step)) => (bounds, Some(frame(step)?)),
        None => (text, None),
    };
    if step == Some(0) {
        return Err(format!("`{text}` has a step of 0"));
    }
    let (first, last) = match bounds.split_once('-') {
        Some((first, last)) => (frame(first)?, Some(frame(last)?)),
        None if step.is_some() => (frame(bounds)?, None),
        None => (frame(bounds)?, Some(frame(bounds)?)),
    };
    if last.is_some_and(|last| last < first) {
        let given = last.unwrap_or_default();
        return Err(format!(
            "`{text}` has its ends swapped: {first} comes before {given}, expected the smaller frame first"
        ));
    }
    Ok(Range { text: text.into(), first, last, step: step.unwrap_or(1) })
}

impl FrameList {
    /// The frames of the list that are among `existing` (ascending), in the list's order and once each. An error if a frame that is
    /// listed singly is missing, or if no listed frame exists.
    pub fn select(&self, existing: &[u64]) -> Result<Vec<u64>, String> {
        let mut out: Vec<u64> = Vec::new();
        for Range { text, first, last, step } in &self.ranges {
            // Only frames that exist are visited, so that a range of astronomic length costs nothing, and of these only the range's: a list
            // may name every frame of a film.
            let within = &existing[existing.partition_point(|f| f < first)..];
            let within = &within[..last.map_or(within.len(), |last| within.partition_point(|f| *f <= last))];
            if *last == Some(*first) && within.is_empty() {
                return Err(format!("`{text}`: there is no frame {first}; the data has {}", describe(existing)));
            }
            out.extend(within.iter().copied().filter(|f| (f - first).is_multiple_of(*step)));
        }
        if out.is_empty() {
            return Err(format!("`{}` selects no frame that exists; the data has {}", self.text, describe(existing)));
        }
        let mut seen = HashSet::new();
        out.retain(|f| seen.insert(*f));
        Ok(out)
    }
}

/// A short description of these frames (ascending) for messages, such as `20 frames from 0 to 19`.
pub fn describe(frames: &[u64]) -> String {
    match (frames.first(), frames.last()) {
        (Some(a), Some(b)) if a == b => format!("frame {a}"),
        (Some(a), Some(b)) => format!("{} frames from {a} to {b}", frames.len()),
        _ => "no frames".into(),
    }
}

/// Words as a list: `a`, `a and b`, `a, b and c`.
pub fn words(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Missing frames of a gap that are told.
const MOST: u64 = 1000;

/// The frames (ascending) that are missing between others, if these are mostly one step apart: the step, and the missing ones.
pub fn gaps(frames: &[u64]) -> Option<(u64, Vec<u64>)> {
    let steps: Vec<u64> = frames.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = steps.iter().copied().min().filter(|step| *step > 0)?;
    let is_regular = 2 * steps.iter().filter(|s| **s == step).count() >= steps.len();
    let between =
        |pair: &[u64]| (1..((pair[1] - pair[0]) / step).min(MOST)).map(|k| pair[0] + k * step).collect::<Vec<_>>();
    let missing: Vec<u64> =
        frames.windows(2).flat_map(between).filter(|frame| frames.binary_search(frame).is_err()).collect();
    (is_regular && steps.len() > 1 && !missing.is_empty()).then_some((step, missing))
}

/// The frames that are missing between others, as a sentence; none if none are.
pub fn describe_gaps(frames: &[u64]) -> Option<String> {
    /// Frames that are named.
    const NAMED: usize = 8;
    let (step, missing) = gaps(frames)?;
    let names: Vec<String> = missing.iter().take(NAMED).map(u64::to_string).collect();
    let are = match missing.len() {
        1 => format!("frame {} is", names[0]),
        n => {
            let most = if n >= MOST as usize - 1 { "more than " } else { "" };
            format!("{most}{n} frames ({}{}) are", names.join(", "), if n > NAMED { ", …" } else { "" })
        }
    };
    Some(format!("{are} missing between the others, which are {step} apart"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_in_regular_frames_are_found() {
        assert_eq!(gaps(&[0, 1, 2, 5, 6]), Some((1, vec![3, 4])));
        assert_eq!(gaps(&[4000, 8000, 16000]), Some((4000, vec![12000])));
        assert_eq!((gaps(&[0, 1, 2]), gaps(&[7]), gaps(&[0, 5]), gaps(&[])), (None, None, None, None));
        assert_eq!(gaps(&[0, 1, 10, 100, 1000]), None);
    }

    #[test]
    fn lists_select_existing_frames_in_their_order() {
        let all: Vec<u64> = (0..20).collect();
        let select = |list: &str| list.parse::<FrameList>().and_then(|l| l.select(&all));
        assert_eq!(select("2,4,10-12").unwrap(), [2, 4, 10, 11, 12]);
        assert_eq!(select("0-9x4").unwrap(), [0, 4, 8]);
        assert_eq!(select("12x5,3").unwrap(), [12, 17, 3]);
        assert_eq!(select("0-99999999999").unwrap().len(), 20);
        for bad in ["", "a", "5-2", "9-2x3", "3x0", "1-x"] {
            assert!(bad.parse::<FrameList>().is_err(), "{bad}");
        }
        for absent in ["30", "25-30", "30x2"] {
            assert!(select(absent).is_err(), "{absent}");
        }
        assert_eq!(select("19,18x1,0").unwrap(), [19, 18, 0]);
        assert_eq!("2-9x3".parse::<FrameList>().unwrap().select(&[0, 2, 3, 7, 8, 11]).unwrap(), [2, 8]);
    }
}
