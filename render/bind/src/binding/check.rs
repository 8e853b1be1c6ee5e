//! Checks of what every kind of file says, with the keys of metadata files.

use super::resolved::{Data, ImageFormat, Output, Place};
use crate::formula::Formula;
use frame::Fault;
use frame::yaml::Document;

impl Output {
    /// Check resolution, samples, shading rate, shutter, bits, layers, levels and filter. An error is at the key of the first bad value.
    pub fn check(&self, doc: &Document) -> Result<(), Fault> {
        if self.resolution.iter().any(|n| !(1..=65_536).contains(n)) {
            return Err(doc.fault("output.resolution", "expected two numbers from 1 to 65536"));
        }
        if self.resolution[0] as u64 * self.resolution[1] as u64 > 1 << 28 {
            return Err(doc.fault("output.resolution", "expected at most 268 million pixels"));
        }
        if self.samples.iter().any(|n| !(1..=64).contains(n)) {
            return Err(doc.fault("output.samples", "expected two numbers from 1 to 64"));
        }
        if !(self.shading_rate > 0.0 && self.shading_rate.is_finite()) {
            return Err(doc.fault("output.shading_rate", "expected a number above 0"));
        }
        if !(self.shutter >= 0.0 && self.shutter.is_finite()) {
            return Err(doc.fault("output.shutter", "expected seconds, 0 or more"));
        }
        let bits = if self.format == ImageFormat::Exr { [16, 32] } else { [8, 16] };
        if let Some(given) = self.bits.filter(|given| !bits.contains(given)) {
            let [few, many] = bits;
            return Err(doc.fault("output.bits", format!("is {given}, expected {few} or {many}")));
        }
        if !self.channels.is_empty() && self.format != ImageFormat::Exr {
            return Err(doc.fault("output.channels", "needs `format: exr`: no other file has layers"));
        }
        if let Some([low, high]) = self.levels
            && !(low >= 0.01 && low < high && high <= 0.99)
        {
            return Err(doc.fault("output.levels", "expected two numbers from 0.01 to 0.99, the second larger"));
        }
        let filters = ["box", "triangle", "gaussian", "catmull-rom", "sinc", "mitchell"];
        let (name, width) = &self.filter;
        if !filters.contains(&name.as_str()) {
            return Err(doc.unknown("output.filter.name", "filter", name, &filters));
        }
        if !(1.0..=16.0).contains(width) {
            return Err(doc.fault("output.filter.width", "expected 1 to 16 pixels"));
        }
        Ok(())
    }
}

/// The delimiter of CSV cells as a byte. An error if it is not an ASCII character.
pub fn delimiter(doc: &Document, given: Option<char>) -> Result<Option<u8>, Fault> {
    let byte = |c: char| {
        u8::try_from(c)
            .ok()
            .filter(u8::is_ascii)
            .ok_or_else(|| doc.fault("data.delimiter", "expected one ASCII character"))
    };
    given.map(byte).transpose()
}

/// Check that a file has objects; `n` is their count.
pub fn some_objects(doc: &Document, n: usize) -> Result<(), Fault> {
    if n == 0 { Err(doc.fault("objects", "draws nothing: expected at least one object")) } else { Ok(()) }
}

impl Data {
    /// Compile derived columns, given by name and expression, and the condition on rows. An error is at the key of the first bad
    /// expression.
    pub fn compile(
        doc: &Document,
        place: Option<Place>,
        derive: &[(String, String)],
        select: Option<&str>,
    ) -> Result<Data, Fault> {
        let compile = |key: String, text: &str| Formula::compile(doc, key, text);
        let mut columns = Vec::new();
        for (k, (column, formula)) in derive.iter().enumerate() {
            columns.push((column.clone(), compile(format!("data.derive.{k}.formula"), formula)?));
        }
        let select = select.map(|text| compile("data.select".into(), text)).transpose()?;
        Ok(Data { place, derive: columns, select })
    }
}
