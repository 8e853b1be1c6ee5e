//! What an image is drawn from: the table of its frame, and what objects need besides: contacts, and the frames before, for trails.

use crate::binding::{Binding, Reach, Shape, Trail};
use crate::data::{Source, Store};
use frame::csv::Layout;
use frame::{Fault, Frame, table};
use std::sync::Arc;

/// A frame, and what is drawn with it.
pub struct Moment<'a> {
    /// The table of the frame.
    pub frame: &'a Frame,
    /// The contacts of the frame, if an object is of them and they have been read.
    pub contacts: Option<Frame>,
    /// The frames before that trails go back to, the earliest first.
    pub before: Vec<Arc<Frame>>,
}

impl<'a> Moment<'a> {
    /// A frame alone: contacts and trails are not drawn.
    pub fn alone(frame: &'a Frame) -> Moment<'a> {
        Moment { frame, contacts: None, before: vec![] }
    }

    /// A frame with all that the objects of a binding need. An error if contacts are wanted that the data does not have, or trails of a
    /// time of data without times.
    pub fn of(binding: &Binding, source: &Source, frame: &'a Frame) -> Result<Moment<'a>, Fault> {
        let mut moment = Moment::still(binding, source, frame)?;
        for (i, object) in binding.objects.iter().enumerate() {
            if let Shape::Trail(Trail { reach, .. }) = &object.shape {
                let key = format!("objects.{i}.geometry.trail.length");
                moment.go_back(*reach, source, |message| binding.doc.fault(&key, message))?;
            }
        }
        moment.before.reverse();
        // The next image's trails go back to the same tables, this frame's among them.
        let has_trails = binding.objects.iter().any(|object| matches!(object.shape, Shape::Trail(_)));
        let earliest = numbers_back(source, frame.number, moment.before.len());
        source.keep(if has_trails { earliest..frame.number + 1 } else { 0..0 });
        Ok(moment)
    }

    /// A frame with its contacts, if an object is of them, and without the frames before.
    pub fn still(binding: &Binding, source: &Source, frame: &'a Frame) -> Result<Moment<'a>, Fault> {
        let mut moment = Moment::alone(frame);
        if let Some(i) = binding.objects.iter().position(|object| object.of_contacts) {
            let read = |message: &str| binding.doc.fault(&format!("objects.{i}.rows"), message);
            let Store::Run(run) = &source.store else {
                return Err(read("the data is no run of scree: it has no contact tables"));
            };
            let path = run.folder.join(format!("contacts/{:06}.csv", frame.number));
            if !path.is_file() {
                return Err(read("the run has no contact tables: its model needs `probes: {contact_tables: true}`"));
            }
            let layout = Layout::default();
            let found = table::find(&path)?.into_values().next().map(|stored| stored.read(frame.number, &layout));
            moment.contacts = found.transpose()?;
        }
        Ok(moment)
    }

    /// Add earlier frames, the latest first, until there are those of a trail. It ends at a frame that cannot be read.
    fn go_back(&mut self, reach: Reach, source: &Source, fault: impl Fn(&str) -> Fault) -> Result<(), Fault> {
        let numbers = source.numbers();
        let earlier = numbers.iter().rev().filter(|number| **number < self.frame.number);
        for (k, number) in earlier.enumerate() {
            let last = self.before.get(k.wrapping_sub(1)).map_or(self.frame, |table| &**table);
            let is_whole = match reach {
                Reach::Frames(n) => k as u64 >= n,
                Reach::Time(seconds) => last.time <= self.frame.time - seconds,
            };
            if is_whole {
                break;
            }
            if k == self.before.len() {
                let Ok(table) = source.shared(*number) else { break };
                self.before.push(table);
            }
            if matches!(reach, Reach::Time(_)) && self.before[k].time >= self.frame.time {
                return Err(fault("the frames have no times that ascend: give the trail a number of `frames`"));
            }
        }
        Ok(())
    }
}

/// The number of the frame so many before another.
fn numbers_back(source: &Source, number: u64, count: usize) -> u64 {
    let numbers = source.numbers();
    let at = numbers.partition_point(|n| *n < number);
    numbers.get(at.saturating_sub(count)).copied().unwrap_or(number)
}
