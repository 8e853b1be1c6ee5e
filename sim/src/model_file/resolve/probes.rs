//! Probes: the bodies, joints, springs and pairs of classes of `probes.csv`.

use super::*;

impl Builder<'_> {
    pub(super) fn probes(&self) -> Result<Probes, Fault> {
        let (file, model, doc) = (&self.file.probes, &self.model, self.doc);
        let bodies = match &file.bodies {
            None => self.probe_bodies.clone(),
            Some(patterns) => {
                let mut found = vec![];
                for (i, p) in patterns.iter().enumerate() {
                    let before = found.len();
                    found.extend(model.body_names.iter().filter(|(n, _)| matches(p, n)).map(|(_, b)| b));
                    if found.len() == before {
                        let known: Vec<&str> = model.body_names.iter().map(|(name, _)| name).collect();
                        return Err(doc.unknown(&format!("probes.bodies.{i}"), "body", p, &known));
                    }
                }
                found
            }
        };
        let (mut joints, mut springs) = (self.probe_joints.clone(), self.probe_springs.clone());
        if let Some(patterns) = &file.joints {
            (joints, springs) = (vec![], vec![]);
            for (i, p) in patterns.iter().enumerate() {
                let before = joints.len() + springs.len();
                joints.extend((0..model.joints.len()).filter(|j| matches(p, &model.joints[*j].name)).map(|j| j as u32));
                springs
                    .extend((0..model.springs.len()).filter(|j| matches(p, &model.springs[*j].name)).map(|j| j as u32));
                if joints.len() + springs.len() == before {
                    let known: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
                    return Err(doc.unknown(&format!("probes.joints.{i}"), "joint or spring", p, &known));
                }
            }
        }
        let mut contacts = vec![];
        let classes: HashMap<&str, u32> =
            model.class_names.iter().enumerate().map(|(i, name)| (name.as_str(), i as u32)).collect();
        for (i, c) in file.contacts.iter().enumerate() {
            let mut pair = [0; 2];
            for (slot, name) in pair.iter_mut().zip(&c.between) {
                *slot = *classes.get(name.as_str()).ok_or_else(|| {
                    let known: Vec<&str> = model.class_names.iter().map(String::as_str).collect();
                    doc.unknown(&format!("probes.contacts.{i}.between"), "class", name, &known)
                })?;
            }
            contacts.push((c.name.clone(), pair));
        }
        Ok(Probes {
            interval: file.interval.unwrap_or(model.step),
            bodies,
            joints,
            springs,
            contacts,
            energies: !file.no_energies,
            contact_tables: file.contact_tables,
        })
    }
}
