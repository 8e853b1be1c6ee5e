//! The base of a model: bodies, joints and springs of another run, at its last checkpoint.

use super::*;

impl Builder<'_> {
    /// Add the bodies of another run at its last checkpoint, with the joints and springs between them, their exclusions and groups that
    /// pass through each other, and the materials. Loads are not carried over.
    pub(super) fn base(&mut self, base: &BaseFile) -> Result<(), Fault> {
        let doc = self.doc;
        let fail = |key: &str, message: String| doc.fault(&format!("base.{key}"), message);
        let named = |fault: Fault| doc.fault_of_named("base.run", fault);
        let (file, other): (ModelFile, Resolved) =
            crate::model_file::read(&base.run.join("model.yaml")).map_err(named)?;
        let latest = checkpoint::latest(&base.run).map_err(named)?;
        let Some(path) = latest else {
            return Err(fail("run", format!("{} has no checkpoint", base.run.display())));
        };
        let (mut state, _) = checkpoint::read(&path).map_err(named)?;
        let other_model = other.model;
        if state.position.len() != other_model.n_bodies() {
            return Err(fail("run", "its checkpoint and its model differ in the number of bodies".into()));
        }
        state.wake(&other_model);
        sleep::rouse_all(&mut state);
        for (name, material) in file.materials {
            self.materials.entry(name).or_insert(material);
        }
        self.model.material_names = self.materials.keys().cloned().collect();
        let is_included = |b: usize| {
            let class = &other_model.class_names[other_model.class[b] as usize];
            !state.is_inactive(b) && base.classes.as_ref().is_none_or(|c| c.contains(class))
        };
        if let Some(classes) = &base.classes {
            let known: Vec<&str> = other_model.class_names.iter().map(String::as_str).collect();
            if let Some(name) = classes.iter().find(|c| !known.contains(&c.as_str())) {
                return Err(doc.unknown("base.classes", "class", name, &known));
            }
        }
        let mut id = vec![u32::MAX; other_model.n_bodies()];
        for b in (0..other_model.n_bodies()).filter(|b| is_included(*b)) {
            id[b] = self.model.n_bodies() as u32;
            let class = self.class(&other_model.class_names[other_model.class[b] as usize]);
            let model = &mut self.model;
            // Bodies that are still held in place are fixed.
            model.inv_mass.push(if state.moves(b) { other_model.inv_mass[b] } else { 0.0 });
            model.inv_inertia.push(if state.moves(b) { other_model.inv_inertia[b] } else { DVec3::ZERO });
            model.class.push(class);
            model.body_frame.push(other_model.body_frame[b]);
            self.state.position.push(state.position[b]);
            self.state.orientation.push(state.orientation[b]);
            let at_rest = base.at_rest;
            self.state.velocity.push(if at_rest { DVec3::ZERO } else { state.velocity[b] });
            self.state.angular_velocity.push(if at_rest { DVec3::ZERO } else { state.angular_velocity[b] });
        }
        for (name, b) in other_model.body_names.iter().filter(|(_, b)| id[*b as usize] != u32::MAX) {
            self.model.body_names.insert(name.into(), id[b as usize]);
        }
        let mut shape_id = vec![u32::MAX; other_model.n_shapes()];
        for s in (0..other_model.n_shapes()).filter(|s| id[other_model.shape_body[*s] as usize] != u32::MAX) {
            shape_id[s] = self.model.n_shapes() as u32;
            let (kind, part) = (other_model.shape_kind[s], other_model.shape_part[s] as usize);
            let material = &other_model.material_names[other_model.shape_material[s] as usize];
            let group =
                self.group(Some(&other_model.group_names[other_model.shape_group[s] as usize]).map(|s| s.as_str()));
            let shape = Shape {
                hull: (kind == ShapeKind::Hull).then(|| Arc::new(other_model.hulls[part].clone())),
                surface: matches!(kind, ShapeKind::Mesh | ShapeKind::HeightField)
                    .then(|| other_model.surfaces[part].clone()),
                ..Shape::simple(kind, other_model.shape_size[s])
            };
            let (material, density) = self.material("base", &material.clone())?;
            let new = NewShape { shape, pose: other_model.shape_pose[s], material, density, group };
            self.add_shape(id[other_model.shape_body[s] as usize], other_model.shape_pose[s], new);
        }
        let step = self.model.step / other_model.step;
        self.impulses(&state.contacts, [&id, &shape_id], step);
        let included = |bodies: [u32; 2]| {
            let pair = bodies.map(|b| id[b as usize]);
            (!pair.contains(&u32::MAX)).then_some(pair)
        };
        // The times of what has begun or will begin are those of the new run; what has ended is gone.
        let times = |from: f64, until: f64| ((from - state.time).max(0.0), until - state.time);
        for j in other_model.joints.iter().filter(|j| state.time < j.until) {
            if let Some(bodies) = included(j.bodies) {
                let (from, until) = times(j.from, j.until);
                self.model.joints.push(Joint { bodies, from, until, ..j.clone() });
            }
        }
        for s in other_model.springs.iter().filter(|s| state.time < s.until) {
            if let Some(bodies) = included(s.bodies) {
                let (from, until) = times(s.from, s.until);
                self.model.springs.push(Spring { bodies, from, until, ..s.clone() });
            }
        }
        let n = other_model.group_names.len();
        for (k, _) in other_model.groups_pass.iter().enumerate().filter(|(_, pass)| **pass) {
            let names = [&other_model.group_names[k / n], &other_model.group_names[k % n]];
            let pair = [self.group(Some(names[0])), self.group(Some(names[1]))];
            self.groups_pass.push(pair);
        }
        Ok(())
    }

    /// Carry over the contacts of the base's last step between bodies and shapes with the ids in `id` (`u32::MAX` for none), so that the
    /// first step starts from their impulses; `step` is the step size over that of the base.
    fn impulses(&mut self, from: &Contacts, [body, shape]: [&[u32]; 2], step: f64) {
        let of = |id: &[u32], pair: [u32; 2]| pair.map(|old| id[old as usize]);
        for i in 0..from.len() {
            let [s, t, feature] = from.key[i];
            let (bodies, [s, t]) = (of(body, from.bodies[i]), of(shape, [s, t]));
            if !bodies.contains(&u32::MAX) {
                let law = self.model.law(s as usize, t as usize);
                self.state.contacts.carry(from, i, bodies, [s, t, feature], law, step);
            }
        }
    }
}
