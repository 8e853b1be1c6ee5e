//! Loads on bodies, and functions of time.

use super::*;
use frame::{Column, Field, csv};
use std::path::Path;

impl Builder<'_> {
    pub(super) fn load(&mut self, key: &str, file: &LoadFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        let body = self.find(&at("body"), &file.body)?;
        if !self.moves_ever(body) {
            return Err(doc.fault(&at("body"), format!("`{}` is held in place: a load has no effect on it", file.body)));
        }
        let (torque, v) = match (file.force, file.torque) {
            (Some(f), None) => (false, f),
            (None, Some(t)) => (true, t),
            _ => return Err(doc.fault(key, "needs exactly one of `force` and `torque`")),
        };
        let direction = direction(doc, &at(if torque { "torque" } else { "force" }), v)?;
        let point = match file.point {
            Some(_) if torque => return Err(doc.fault(&at("point"), "a torque has no point")),
            Some(p) => {
                finite(doc, &at("point"), &p)?;
                let frame = self.model.body_frame[body as usize];
                frame.position + frame.orientation * DVec3::from(p)
            }
            None => DVec3::ZERO,
        };
        let [from, until] = self.interval(key, file.from, file.until, begins)?;
        let value = self.function(&at("value"), &file.value)?;
        self.model.loads.push(Load {
            body,
            torque,
            direction,
            follows: file.frame == LoadFrame::Body,
            point,
            value,
            from,
            until,
        });
        Ok(())
    }

    pub(super) fn function(&self, key: &str, file: &FunctionFile) -> Result<Function, Fault> {
        let doc = self.doc;
        let check = |values: &[f64]| finite(doc, key, values);
        match file {
            FunctionFile::Constant(x) => {
                check(&[*x])?;
                Ok(Function::Constant(*x))
            }
            FunctionFile::Step { step } => {
                check(&[step.before, step.after, step.at])?;
                Ok(Function::Step { before: step.before, after: step.after, at: step.at })
            }
            FunctionFile::Ramp { ramp } => {
                check(&ramp.values)?;
                check(&ramp.times)?;
                if !(ramp.times[1] > ramp.times[0]) {
                    let message =
                        format!("run from {} to {}, expected the earlier time first", ramp.times[0], ramp.times[1]);
                    return Err(doc.fault(&format!("{key}.ramp.times"), message));
                }
                Ok(Function::Ramp { values: ramp.values, times: ramp.times })
            }
            FunctionFile::Sine { sine } => {
                check(&[sine.mean, sine.amplitude, sine.frequency, sine.phase])?;
                Ok(Function::Sine {
                    mean: sine.mean,
                    amplitude: sine.amplitude,
                    frequency: sine.frequency,
                    phase: sine.phase.to_radians(),
                })
            }
            FunctionFile::Table { table } => self.table(&format!("{key}.table"), table.clone()),
            FunctionFile::Csv { csv } => {
                let key = format!("{key}.csv");
                self.table(&key, self.points(&key, csv)?)
            }
        }
    }

    /// The points of a CSV file of two columns, time and value.
    fn points(&self, key: &str, path: &Path) -> Result<Vec<[f64; 2]>, Fault> {
        /// Units that are not converted; a file without units is taken to be in these.
        const SI: [&str; 12] = ["", "1", "N", "N m", "N*m", "N·m", "Nm", "m", "m/s", "rad", "rad/s", "1/s"];
        let doc = self.doc;
        let wrong = |why: String| doc.fault(key, format!("{}: {why}", path.display()));
        let table = csv::read(path, 0, &csv::Layout::default()).map_err(|fault| doc.fault_of_named(key, fault))?;
        let [(time, times), (value, values)] = &table.columns[..] else {
            return Err(wrong(format!("has {} columns, expected two, time and value", table.columns.len())));
        };
        let is_time = |name: &str| matches!(name.to_lowercase().as_str(), "t" | "time");
        if is_time(&value.name) && !is_time(&time.name) {
            return Err(wrong(format!(
                "the second column is `{}`, expected the time first, then the value",
                value.name
            )));
        }
        let unknown = |unit: &str, known: &[&str]| !known.contains(&unit.trim());
        if unknown(&time.unit, &["", "s", "sec"]) {
            return Err(wrong(format!("`{}` is in {}, expected s", time.name, time.unit)));
        }
        if unknown(&value.unit, &SI) {
            return Err(wrong(format!("`{}` is in {}, expected N, N m, m, m/s, rad or rad/s", value.name, value.unit)));
        }
        let number = |(field, column): (&Field, &Column), row: usize| match column.number(row) {
            Some(x) if x.is_finite() => Ok(x),
            _ => Err(wrong(format!("`{}` has no number in row {}", field.name, row + 1))),
        };
        (0..table.rows()).map(|row| Ok([number((time, times), row)?, number((value, values), row)?])).collect()
    }

    fn table(&self, key: &str, points: Vec<[f64; 2]>) -> Result<Function, Fault> {
        points.iter().try_for_each(|p| finite(self.doc, key, p))?;
        if points.is_empty() {
            return Err(self.doc.fault(key, "has no points: expected pairs of time and value"));
        }
        match points.windows(2).find(|p| !(p[1][0] > p[0][0])) {
            Some(p) => {
                Err(self.doc.fault(key, format!("has times that do not ascend: {} s follows {} s", p[1][0], p[0][0])))
            }
            None => Ok(Function::Table(points)),
        }
    }
}
