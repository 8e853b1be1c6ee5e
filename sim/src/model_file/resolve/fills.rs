//! Fills, terrains and assemblies, which expand to many bodies.

use super::*;

/// The most boulders of a terrain.
const MAX_BOULDERS: usize = 1_000_000;

impl Builder<'_> {
    /// The distribution of radii of a fill.
    fn radii(&self, key: &str, file: &RadiusFile) -> Result<Radii, Fault> {
        let doc = self.doc;
        let key = format!("{key}.radius");
        match file {
            RadiusFile::Uniform([min, max]) => {
                finite(doc, &key, &[*min, *max])?;
                positive(doc, &key, *min)?;
                if max < min {
                    let message = format!("runs from {min} to {max}, expected the smaller radius first");
                    return Err(doc.fault(&key, message));
                }
                Ok(Radii::Uniform(*min, *max))
            }
            RadiusFile::Normal(n) => {
                positive(doc, &format!("{key}.mean"), n.mean)?;
                not_negative(doc, &format!("{key}.deviation"), n.deviation)?;
                positive(doc, &format!("{key}.least"), n.least)?;
                if !(n.least <= n.mean && n.mean <= n.greatest && n.greatest.is_finite()) {
                    let message = format!(
                        "`least` is {}, `mean` {} and `greatest` {}, expected them in ascending order",
                        n.least, n.mean, n.greatest
                    );
                    return Err(doc.fault(&key, message));
                }
                Ok(Radii::Normal(n.clone()))
            }
            RadiusFile::Sieve(s) => {
                let rises = s.sieve.windows(2).all(|p| p[1][0] > p[0][0] && p[1][1] >= p[0][1]);
                let is_valid = s.sieve.len() >= 2
                    && rises
                    && s.sieve[0][0] > 0.0
                    && s.sieve[0][1] >= 0.0
                    && s.sieve.last().is_some_and(|p| p[1] == 1.0 && p[0].is_finite());
                if !is_valid {
                    let message = "expected at least two pairs [mesh width, fraction passing], both ascending, the last fraction 1";
                    return Err(doc.fault(&format!("{key}.sieve"), message));
                }
                Ok(Radii::sieve(&s.sieve))
            }
        }
    }

    pub(super) fn fill(&mut self, key: &str, fill: &FillFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let (material, density) = self.material(&format!("{key}.material"), &fill.material)?;
        let radii = self.radii(key, &fill.radius)?;
        for (name, values) in [("min", fill.min), ("max", fill.max), ("velocity", fill.velocity)] {
            finite(doc, &format!("{key}.{name}"), &values)?;
        }
        if let Some(axis) = (0..3).find(|axis| fill.min[*axis] > fill.max[*axis]) {
            let (min, max, axis_name) = (fill.min[axis], fill.max[axis], ["x", "y", "z"][axis]);
            let message = format!("`min` and `max` are swapped along {axis_name}: `min` is {min}, `max` is {max}");
            return Err(doc.fault(&format!("{key}.min"), message));
        }
        if let Some(mass) = fill.mass {
            positive(doc, &format!("{key}.mass"), mass)?;
        }
        if let Some(r) = fill.within_radius {
            positive(doc, &format!("{key}.within_radius"), r)?;
        }
        let region = fill::Region { min: fill.min.into(), max: fill.max.into(), within: fill.within_radius };
        let count = fill.count.map_or(fill::Count::AllThatFit, fill::Count::Exactly);
        let max = radii.max();
        let sites = match fill.packing {
            Packing::Lattice => fill::lattice(&region, max, count, &mut self.random),
            Packing::Hexagonal => fill::hexagonal(&region, max, count),
            Packing::PoissonDisk => fill::poisson_disk(&region, max, count, &mut self.random),
        }
        .map_err(|fits| {
            if fits == 0 && region.has_too_many_sites(max) {
                let message = format!("the region is too large to be packed so with spheres of radius {max} m");
                return doc.fault(&format!("{key}.max"), message).hint("a `lattice` fills it from the bottom up");
            }
            let count = fill.count.unwrap_or(0);
            doc.fault(
                &format!("{key}.count"),
                format!("is {count}, but only {fits} spheres of radius {max} m fit in the region"),
            )
            .hint("enlarge the region between `min` and `max`, or reduce the count")
        })?;
        if sites.is_empty() {
            return Err(doc.fault(key, format!("no sphere of radius {max} m fits in the region")));
        }
        if fill.packing != Packing::PoissonDisk && fill::is_one_sided(&sites, &region) {
            let message =
                format!("{} spheres cover one side of the region alone: a lattice is filled row by row", sites.len());
            let doubt = doc.fault(&format!("{key}.count"), message).hint("`packing: poisson_disk` spreads them");
            self.warnings.push(doubt.to_string());
        }
        let class = self.class(&fill.name);
        let group = self.group(fill.group.as_deref());
        let appears = fill.appears.unwrap_or(begins);
        not_negative(doc, &format!("{key}.appears"), appears)?;
        for position in sites {
            let radius = radii.draw(&mut self.random);
            let orientation = self.random.rotation();
            let shape = Shape::simple(ShapeKind::Sphere, DVec3::splat(radius));
            let pose = Pose::default();
            let body = NewBody {
                class,
                place: Pose { position, orientation },
                velocity: fill.velocity.into(),
                angular_velocity: DVec3::ZERO,
                fixed: false,
                mass: fill.mass,
                inertia: None,
                center: None,
                appears,
                moves: appears,
            };
            self.add(body, vec![NewShape { shape, pose, material, density, group }])
                .map_err(|message| doc.fault(key, format!("a sphere of the fill {message}")))?;
        }
        Ok(())
    }

    pub(super) fn terrain(&mut self, key: &str, t: &TerrainFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        let (material, density) = self.material(&at("material"), &t.material)?;
        for (part, value) in
            [("size", t.size[0]), ("size", t.size[1]), ("spacing", t.spacing), ("wavelength", t.wavelength)]
        {
            positive(doc, &at(part), value)?;
        }
        not_negative(doc, &at("amplitude"), t.amplitude)?;
        not_negative(doc, &at("flat_radius"), t.flat_radius)?;
        finite(doc, &at("position"), &t.position)?;
        if (t.size[0] / t.spacing) * (t.size[1] / t.spacing) > 2e7 {
            return Err(
                doc.fault(&at("spacing"), "makes a grid of more than 20 million points: expected a larger spacing")
            );
        }
        for (i, d) in t.ditches.iter().enumerate() {
            positive(doc, &at(&format!("ditches.{i}.width")), d.width)?;
            finite(doc, &at(&format!("ditches.{i}")), &[d.depth, d.from[0], d.from[1], d.to[0], d.to[1]])?;
        }
        let ground = Ground::new(t, &mut self.random);
        let (heights, n, origin, spacing) = ground.grid();
        let surface = Surface::height_field(&heights, n, origin, spacing);
        let class = self.class(&t.name);
        let place = Pose { position: t.position.into(), orientation: DQuat::IDENTITY };
        let fixed = |class: u32, place: Pose| NewBody {
            class,
            place,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            fixed: true,
            mass: None,
            inertia: None,
            center: Some(DVec3::ZERO),
            appears: begins,
            moves: begins,
        };
        let pose = Pose::default();
        let shape = shape::surface_shape(ShapeKind::HeightField, surface);
        let id = self
            .add(fixed(class, place), vec![NewShape { shape, pose, material, density, group: 0 }])
            .map_err(|m| doc.fault(key, m))?;
        self.model.body_names.insert(t.name.clone(), id);
        if let Some(b) = &t.boulders {
            positive(doc, &at("boulders.radius"), b.radius[0])?;
            if b.count > MAX_BOULDERS {
                return Err(doc.fault(&at("boulders.count"), format!("is more than {MAX_BOULDERS}")));
            }
            if !(b.radius[1] >= b.radius[0] && b.radius[1].is_finite()) {
                let message =
                    format!("runs from {} to {}, expected the smaller radius first", b.radius[0], b.radius[1]);
                return Err(doc.fault(&at("boulders.radius"), message));
            }
            let (material, density) = match &b.material {
                Some(name) => self.material(&at("boulders.material"), name)?,
                None => (material, density),
            };
            let class = self.class(&format!("{}_boulder", t.name));
            for (position, radius) in ground.boulders(&mut self.random) {
                let stretch = [0; 3].map(|_| self.random.between(0.75, 1.0));
                let orientation = self.random.rotation();
                let shape = Shape::simple(ShapeKind::Ellipsoid, DVec3::from(stretch) * radius);
                let place = Pose { position: place.position + position, orientation };
                self.add(fixed(class, place), vec![NewShape { shape, pose, material, density, group: 0 }])
                    .map_err(|m| doc.fault(key, m))?;
            }
        }
        Ok(())
    }

    pub(super) fn assembly(&mut self, key: &str, file: &AssemblyFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let (kind, parts) = match (&file.tracked_vehicle, &file.helical_anchor) {
            (Some(v), None) => ("tracked_vehicle", v.build(&file.name)),
            (None, Some(a)) => ("helical_anchor", a.build(&file.name)),
            _ => return Err(doc.fault(key, "needs exactly one of `tracked_vehicle` and `helical_anchor`")),
        };
        let key = format!("{key}.{kind}");
        let parts = parts.map_err(|(part, why)| doc.fault(&format!("{key}.{part}"), why))?;
        for body in &parts.bodies {
            self.body(&key, body, begins)?;
        }
        for joint in &parts.joints {
            self.joint(&key, joint, begins)?;
        }
        for spring in &parts.springs {
            self.spring(&key, spring, begins)?;
        }
        for load in &parts.loads {
            self.load(&key, load, begins)?;
        }
        for [a, b] in &parts.pass_through {
            let pair = [self.group(Some(a)), self.group(Some(b))];
            self.groups_pass.push(pair);
        }
        Ok(())
    }
}

/// A distribution of radii, m.
enum Radii {
    Uniform(f64, f64),
    Normal(NormalFile),
    /// Cumulative distribution by count: pairs of radius, m, and the fraction of all grains up to it.
    Sieve(Vec<[f64; 2]>),
}

impl Radii {
    /// The distribution by count of a sieve curve by mass: the count of a size is its mass over the cube of the size.
    fn sieve(curve: &[[f64; 2]]) -> Radii {
        let mut by_count = vec![[0.5 * curve[0][0], 0.0]];
        for pair in curve.windows(2) {
            let ([d0, p0], [d1, p1]) = (pair[0], pair[1]);
            // Mass is uniform in size between two meshes: the mean of d⁻³ there.
            let mean = 0.5 * (d0.powi(-2) - d1.powi(-2)) / (d1 - d0);
            let before = by_count.last().map_or(0.0, |n| n[1]);
            by_count.push([0.5 * d1, before + (p1 - p0) * mean]);
        }
        let all = by_count.last().map_or(1.0, |n| n[1]);
        by_count.iter_mut().for_each(|n| n[1] /= all);
        Radii::Sieve(by_count)
    }

    fn max(&self) -> f64 {
        match self {
            Radii::Uniform(_, max) => *max,
            Radii::Normal(n) => n.greatest,
            Radii::Sieve(curve) => curve.last().map_or(0.0, |p| p[0]),
        }
    }

    fn draw(&self, random: &mut SplitMix64) -> f64 {
        match self {
            Radii::Uniform(min, max) => random.between(*min, *max),
            Radii::Normal(n) => loop {
                let (u, v) = (1.0 - random.uniform(), random.uniform());
                let z = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
                let r = n.mean + n.deviation * z;
                if (n.least..=n.greatest).contains(&r) {
                    return r;
                }
            },
            Radii::Sieve(curve) => {
                let u = random.uniform();
                let k = curve.partition_point(|p| p[1] <= u).clamp(1, curve.len() - 1);
                let ([r0, p0], [r1, p1]) = (curve[k - 1], curve[k]);
                // Mass is uniform in size between two meshes, so that the density by count falls with the cube of the size.
                let t = if p1 > p0 { (u - p0) / (p1 - p0) } else { 0.0 };
                (r0.powi(-2) + t * (r1.powi(-2) - r0.powi(-2))).powf(-0.5)
            }
        }
    }
}
