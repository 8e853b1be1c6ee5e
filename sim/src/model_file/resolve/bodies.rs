//! Bodies: their shapes, masses and frames, and the times at which they appear and begin to move.

use super::*;

impl Builder<'_> {
    pub(super) fn body(&mut self, key: &str, body: &BodyFile, begins: f64) -> Result<u32, Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        if body.name == "world" {
            return Err(doc.fault(&at("name"), "`world` is the name of the fixed world: choose another"));
        }
        if self.model.body_names.get(&body.name).is_some() {
            return Err(doc.fault(&at("name"), format!("there is a body `{}` already", body.name)));
        }
        for (name, values) in
            [("position", body.position), ("velocity", body.velocity), ("angular_velocity", body.angular_velocity)]
        {
            finite(doc, &at(name), &values)?;
        }
        if let Some(mass) = body.mass {
            positive(doc, &at("mass"), mass)?;
        }
        let place = Pose {
            position: body.position.into(),
            orientation: orientation(doc, key, &body.rotate, &body.orientation)?,
        };
        let group = self.group(body.group.as_deref());
        let mut shapes = vec![];
        let what = format!("body `{}`", body.name);
        let own = body.shape();
        let parts: Vec<(String, ShapeFile, Option<&String>, Pose)> = match &body.shapes {
            Some(_) if shape::count(&own) > 0 => {
                return Err(
                    doc.fault(&at("shapes"), format!("{what} has `shapes` and a shape of its own: expected one"))
                );
            }
            Some(parts) => parts
                .iter()
                .enumerate()
                .map(|(k, part)| {
                    let key = format!("{key}.shapes.{k}");
                    finite(doc, &format!("{key}.position"), &part.position)?;
                    let pose = Pose {
                        position: part.position.into(),
                        orientation: orientation(doc, &key, &part.rotate, &part.orientation)?,
                    };
                    Ok((key, part.shape(), part.material.as_ref(), pose))
                })
                .collect::<Result<_, Fault>>()?,
            None => vec![(key.to_string(), own, None, Pose::default())],
        };
        for (key, file, material, pose) in parts {
            let name = material
                .or(body.material.as_ref())
                .ok_or_else(|| doc.fault(&key, format!("{what} has no material: expected `material: NAME`")))?;
            let (material, density) = self.material(&format!("{key}.material"), name)?;
            let shape = shape::resolve(doc, &key, &what, &file, &mut self.made)?;
            shapes.push(NewShape { shape, pose, material, density, group });
        }
        let surface = shapes.iter().any(|s| s.shape.kind.is_surface());
        let fixed = body.fixed || surface;
        for (name, motion) in [("velocity", body.velocity), ("angular_velocity", body.angular_velocity)] {
            if fixed && motion != [0.0; 3] {
                return Err(doc.fault(&at(name), format!("{what} is held in place and cannot move")));
            }
        }
        if surface && body.mass.is_some() {
            return Err(doc.fault(&at("mass"), format!("{what} is a static surface: it has no mass")));
        }
        if shapes.is_empty() && !fixed && body.mass.is_none() {
            return Err(doc.fault(key, format!("{what} has no shapes: expected a `mass` and an `inertia`")));
        }
        if shapes.is_empty() && !fixed && body.inertia.is_none() {
            return Err(doc.fault(key, format!("{what} has no shapes: expected an `inertia`")));
        }
        let inertia = match &body.inertia {
            Some(values) => Some(self.inertia(&at("inertia"), values)?),
            None => None,
        };
        let appears = body.appears.unwrap_or(begins);
        let held_until = body.held_until.unwrap_or(0.0);
        for (part, value) in [("appears", appears), ("held_until", held_until)] {
            not_negative(doc, &at(part), value)?;
        }
        let moves = held_until.max(appears);
        let class = self.class(body.class.as_deref().unwrap_or(&body.name));
        let id = self
            .add(
                NewBody {
                    class,
                    place,
                    velocity: body.velocity.into(),
                    angular_velocity: body.angular_velocity.into(),
                    fixed,
                    mass: body.mass,
                    inertia,
                    center: body.center.map(DVec3::from),
                    appears,
                    moves,
                },
                shapes,
            )
            .map_err(|message| doc.fault(key, format!("{what} {message}")))?;
        self.model.body_names.insert(body.name.clone(), id);
        self.keys.bodies.insert(id, key.into());
        Ok(id)
    }

    /// An inertia tensor from three or six numbers, about the centre of mass along the body's axes, kg m².
    pub(super) fn inertia(&self, key: &str, values: &[f64]) -> Result<DMat3, Fault> {
        finite(self.doc, key, values)?;
        let (d, o) = match values {
            [x, y, z] => ([*x, *y, *z], [0.0; 3]),
            [x, y, z, xy, xz, yz] => ([*x, *y, *z], [*xy, *xz, *yz]),
            _ => return Err(self.doc.fault(key, format!("has {} numbers, expected 3 or 6", values.len()))),
        };
        let tensor =
            DMat3::from_cols(DVec3::new(d[0], o[0], o[1]), DVec3::new(o[0], d[1], o[2]), DVec3::new(o[1], o[2], d[2]));
        let (moments, _) = principal(tensor);
        if !(moments.min_element() > 0.0) {
            return Err(self.doc.fault(key, format!("has principal moments {moments}, expected numbers above 0")));
        }
        // Each is an integral over two of the squared coordinates, of which the others have one each.
        let greatest = moments.max_element();
        if greatest > (1.0 + 1e-6) * (moments.element_sum() - greatest) {
            let message =
                format!("has principal moments {moments}: no body has one that is more than the sum of the others");
            return Err(self.doc.fault(key, message));
        }
        Ok(tensor)
    }

    /// Add a body to the columns, with its frame at the centre of mass along the principal axes. Returns its id, or the message of a fault.
    pub(super) fn add(&mut self, body: NewBody, shapes: Vec<NewShape>) -> Result<u32, String> {
        let (mut volume_mass, mut first) = (0.0, DVec3::ZERO);
        let solids: Vec<_> = shapes
            .iter()
            .map(|s| {
                let pose = s.pose.place(&Pose { position: s.shape.shift, orientation: s.shape.rotation });
                let solid = solid_of(s.shape.kind, s.shape.size, s.shape.hull.as_deref());
                let mass = solid.volume * s.density;
                volume_mass += mass;
                first += (pose.position + pose.orientation * solid.centre) * mass;
                (pose, solid, mass)
            })
            .collect();
        let centroid = if volume_mass > 0.0 { first / volume_mass } else { DVec3::ZERO };
        let centre = body.center.unwrap_or(centroid);
        let mass = body.mass.unwrap_or(volume_mass);
        let scale = if volume_mass > 0.0 { mass / volume_mass } else { 0.0 };
        let mut tensor = DMat3::ZERO;
        for ((pose, solid, own), s) in solids.iter().zip(&shapes) {
            let r = DMat3::from_quat(pose.orientation);
            let away = pose.position + pose.orientation * solid.centre - centre;
            let steiner = DMat3::from_diagonal(DVec3::splat(away.length_squared()))
                - DMat3::from_cols(away * away.x, away * away.y, away * away.z);
            tensor += (r * (solid.inertia * s.density) * r.transpose() + steiner * *own) * scale;
        }
        let tensor = body.inertia.unwrap_or(tensor);
        let moves_ever = !body.fixed;
        let diagonal = tensor.x_axis.y == 0.0 && tensor.x_axis.z == 0.0 && tensor.y_axis.z == 0.0;
        let (moments, rotation) = if diagonal {
            (DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z), DQuat::IDENTITY)
        } else {
            principal(tensor)
        };
        if moves_ever && !(mass > 0.0 && mass.is_finite()) {
            return Err(format!("has a mass of {mass} kg, expected a number above 0"));
        }
        if moves_ever && !(moments.min_element() > 0.0 && moments.is_finite()) {
            return Err("has no moment of inertia: give it shapes or an `inertia`".into());
        }
        let id = self.model.n_bodies() as u32;
        let (inv_mass, inv_inertia) = if moves_ever { (1.0 / mass, moments.recip()) } else { (0.0, DVec3::ZERO) };
        let model = &mut self.model;
        if body.appears > 0.0 || (moves_ever && body.moves > 0.0) {
            model.scheduled.push(Scheduled { body: id, appears: body.appears, moves: body.moves });
        }
        model.inv_mass.push(inv_mass);
        model.inv_inertia.push(inv_inertia);
        model.class.push(body.class);
        // The principal frame in the file's frame, and its inverse.
        let own = Pose { position: centre, orientation: rotation };
        model.body_frame.push(own.inverse());
        let world = body.place.place(&own);
        self.state.position.push(world.position);
        self.state.orientation.push(world.orientation.normalize());
        self.state.velocity.push(if moves_ever { body.velocity } else { DVec3::ZERO });
        let spin = rotation.inverse() * body.angular_velocity;
        self.state.angular_velocity.push(if moves_ever { spin } else { DVec3::ZERO });
        for (s, (pose, _, _)) in shapes.into_iter().zip(solids) {
            self.add_shape(id, own.inverse().place(&pose), s);
        }
        Ok(id)
    }

    pub(super) fn add_shape(&mut self, body: u32, pose: Pose, s: NewShape) {
        let model = &mut self.model;
        let mut part = 0;
        if let Some(hull) = s.shape.hull {
            let bits = hull.vertices.iter().map(|v| v.to_array().map(f64::to_bits)).collect();
            part = *self.hulls.entry(bits).or_insert_with(|| {
                model.hulls.push(Arc::unwrap_or_clone(hull));
                model.hulls.len() as u32 - 1
            });
        }
        if let Some(surface) = s.shape.surface {
            model.surfaces.push(surface);
            part = model.surfaces.len() as u32 - 1;
        }
        model.shape_body.push(body);
        model.shape_kind.push(s.shape.kind);
        model.shape_size.push(s.shape.size);
        model.shape_pose.push(pose);
        model.shape_material.push(s.material);
        model.shape_group.push(s.group);
        model.shape_part.push(part);
    }

    pub(super) fn release(&mut self, key: &str, name: &str, time: f64) -> Result<(), Fault> {
        let body = self.find(key, name)?;
        let model = &mut self.model;
        match model.scheduled.iter_mut().find(|s| s.body == body) {
            Some(scheduled) => scheduled.moves = scheduled.moves.max(time),
            None if model.inv_mass[body as usize] == 0.0 => {
                return Err(self.doc.fault(key, format!("`{name}` is fixed and cannot be released")));
            }
            None => model.scheduled.push(Scheduled { body, appears: 0.0, moves: time }),
        }
        Ok(())
    }
}
