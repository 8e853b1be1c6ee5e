//! Lists of frame numbers: `3`, `0-99`, `0-99x5` (every fifth), `120x5` (every fifth from 120 on), joined by commas.

/// The frames of a list, in its order and once each, of those that exist; `Err` is what is wrong with the list.
pub fn parse(list: &str, existing: &[u64]) -> Result<Vec<u64>, String> {
    let mut out: Vec<u64> = Vec::new();
    for part in list.split(',').map(str::trim) {
        let number = |s: &str| {
            s.trim()
                .parse::<u64>()
                .map_err(|_| format!("`{part}` is not a list of frames: expected 3, 0-99, 0-99x5 or 120x5"))
        };
        let (range, step) = match part.split_once('x') {
            Some((range, step)) => (range, Some(number(step)?)),
            None => (part, None),
        };
        if step == Some(0) {
            return Err(format!("`{part}` has a step of 0"));
        }
        let (first, last) = match range.split_once('-') {
            Some((a, b)) => (number(a)?, number(b)?),
            None if step.is_some() => (number(range)?, existing.last().copied().unwrap_or(0)),
            None => (number(range)?, number(range)?),
        };
        if last < first && step.is_none() {
            return Err(format!("`{part}` runs backwards"));
        }
        // Only what exists is gone through, so that a range of astronomic length costs nothing.
        let step = step.unwrap_or(1);
        if first == last && !existing.contains(&first) {
            return Err(format!("there is no frame {first}: the data has {}", describe(existing)));
        }
        out.extend(existing.iter().copied().filter(|f| *f >= first && *f <= last && (f - first) % step == 0));
    }
    if out.is_empty() {
        return Err(format!("`{list}` names no frame that exists: the data has {}", describe(existing)));
    }
    let mut seen = std::collections::HashSet::new();
    out.retain(|f| seen.insert(*f));
    Ok(out)
}

/// A short description of which frames there are.
pub fn describe(frames: &[u64]) -> String {
    match (frames.first(), frames.last()) {
        (Some(a), Some(b)) if a == b => format!("frame {a}"),
        (Some(a), Some(b)) => format!("{} frames from {a} to {b}", frames.len()),
        _ => "no frames".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists() {
        let all: Vec<u64> = (0..20).collect();
        assert_eq!(parse("2,4,10-12", &all).unwrap(), [2, 4, 10, 11, 12]);
        assert_eq!(parse("0-9x4", &all).unwrap(), [0, 4, 8]);
        assert_eq!(parse("12x5,3", &all).unwrap(), [12, 17, 3]);
        assert_eq!(parse("0-99999999999", &all).unwrap().len(), 20);
        for bad in ["", "a", "5-2", "30", "3x0", "1-x"] {
            assert!(parse(bad, &all).is_err(), "{bad}");
        }
    }
}
