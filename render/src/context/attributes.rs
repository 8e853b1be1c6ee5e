//! Calls that set attributes and make lights.

use super::options::answer_of;
use crate::context::state::Context;
use crate::gprim::bound::longest;
use crate::scene::area::{Area, AreaLight};
use crate::scene::attributes::{Attribute, DisplacementBound};
use crate::scene::camera::Camera;
use glam::{Mat4, Vec3};
use ri::{Fail, Param, Params, RiResult};
use sl::machine::BoundShader;
use std::sync::Arc;

impl Context {
    /// Back to the attributes of the last `AttributeBegin`.
    pub(super) fn pop_attributes(&mut self) -> RiResult {
        let floor = self.open_object.as_ref().map_or(self.to_camera.is_some() as usize, |object| object.depth());
        if self.attribute_stack.len() <= floor {
            return Err(Fail::new("AttributeEnd without AttributeBegin"));
        }
        if let Some((attributes, place, geometry)) = self.attribute_stack.pop() {
            (self.attributes, self.geometry) = (attributes, geometry);
            (self.transform, self.moves) = place;
        }
        Ok(())
    }

    /// The colour or the opacity; in a motion block, that at one of its times.
    pub(super) fn set_color(&mut self, which: Attribute, value: [f32; 3]) -> RiResult {
        let is_beyond = which == Attribute::Opacity && value.iter().any(|o| !(0.0..=1.0).contains(o));
        if is_beyond {
            let [r, g, b] = value;
            self.scene
                .warn(format!("`Opacity` is [{r} {g} {b}], expected 0 to 1: what is below or above counts as that"));
        }
        let value = if is_beyond { value.map(|o| o.clamp(0.0, 1.0)) } else { value };
        if let Some(block) = &mut self.motion {
            block.colors.push((which, value));
            return Ok(());
        }
        self.set_color_over_time(which, value, vec![])
    }

    /// The colour or the opacity as the shutter opens, and its keys if it moves.
    pub(super) fn set_color_over_time(
        &mut self,
        which: Attribute,
        value: [f32; 3],
        keys: Vec<(f32, [f32; 3])>,
    ) -> RiResult {
        self.sets(which);
        let a = &mut self.attributes;
        if which == Attribute::Opacity {
            (a.opacity, a.opacity_moves) = (value, keys);
        } else {
            (a.color, a.color_moves) = (value, keys);
        }
        Ok(())
    }

    /// An attribute of a group.
    pub(super) fn set_attribute(&mut self, name: &str, params: Params) -> RiResult {
        for param in &params {
            let answer = answer_of(param.values.clone());
            let key = format!("{name}:{}", param.decl.name);
            let user = Arc::make_mut(&mut self.attributes.user);
            user.retain(|(n, _)| *n != key);
            user.push((key, answer));
            self.sets(Attribute::User);
            let number = param.numbers().first().copied();
            if let ("visibility", what, Some(on)) = (name, param.decl.name.as_str(), number)
                && on != 0.0
                && on != 1.0
            {
                self.scene.warn(format!("visibility `{what}` is {on}, expected 0 or 1: it counts as 1"));
            }
            match (name, param.decl.name.as_str(), number) {
                ("displacementbound", "sphere" | "coordinatesystem", _) => {}
                ("trimcurve", "sense", _) => self.set_trim_sense(param.text())?,
                ("light", "nsamples", Some(n)) => {
                    if !(1.0..=4096.0).contains(&n) {
                        return Err(Fail::new(format!("an area light of {n} samples, expected 1 to 4096")));
                    }
                    self.sets(Attribute::LightSamples);
                    self.attributes.light_samples = n as usize;
                }
                ("visibility", "camera", Some(on)) => {
                    self.sets(Attribute::Visibility);
                    self.attributes.visible = on != 0.0;
                }
                ("visibility", "transmission", Some(on)) => {
                    self.sets(Attribute::Shadows);
                    self.attributes.casts_shadows = on != 0.0;
                }
                ("visibility", "transmission", None) => {
                    self.sets(Attribute::Shadows);
                    let kind = param.text().unwrap_or("");
                    if !["transparent", "opaque", "Os", "shader"].contains(&kind) {
                        self.scene.warn(format!(
                            "unknown transmission `{kind}`, expected transparent, opaque, Os or shader: `shader` is taken"
                        ));
                    }
                    self.attributes.casts_shadows = kind != "transparent";
                    self.attributes.whole_shadows = kind == "opaque";
                    self.attributes.shadows_of_opacity = kind == "Os";
                }
                ("user", ..)
                | ("trace", "displacements", Some(_))
                | ("shape", "kind", _)
                | ("identifier", "name" | "shadinggroup", _) => {}
                ("shape", "size" | "offset", _) => self.set_fit(param)?,
                (group, name, _) => self.scene.warn(format!(
                    "attribute `{group}:{name}` is not supported: shaders may ask for it, it has no other effect"
                )),
            }
        }
        if name == "displacementbound" { self.set_displacement_bound(&params) } else { Ok(()) }
    }

    /// The greatest displacement: in object units, or in those of a coordinate system that is named.
    fn set_displacement_bound(&mut self, params: &Params) -> RiResult {
        let given = |name: &str| params.iter().find(|p| p.decl.name == name);
        let Some(sphere) = given("sphere") else { return Ok(()) };
        let bound = match *sphere.numbers() {
            [bound] if bound >= 0.0 => bound,
            [bound] => return Err(Fail::new(format!("the displacement bound is {bound}, expected 0 or more"))),
            _ => return Err(Fail::new("the displacement bound: expected a number")),
        };
        let bound = match given("coordinatesystem").and_then(|p| p.text()) {
            None | Some("object" | "shader") => DisplacementBound::Object(bound),
            Some("current" | "world" | "camera" | "eye") => DisplacementBound::World(bound),
            Some(name) => {
                let space = self.scene.spaces.get(name);
                let space = space.ok_or_else(|| Fail::new(format!("there is no coordinate system `{name}`")))?;
                DisplacementBound::World(bound * longest(*space))
            }
        };
        self.sets(Attribute::DisplacementBound);
        self.attributes.displacement_bound = Some(bound);
        Ok(())
    }

    /// The size of a shape in its object space, or its place there.
    fn set_fit(&mut self, param: &Param) -> RiResult {
        let name = param.decl.name.as_str();
        let &[x, y, z] = param.numbers() else {
            return Err(Fail::new(format!("`shape:{name}` has {} numbers, expected 3", param.numbers().len())));
        };
        let fit = &mut self.attributes.fit;
        if name == "offset" {
            fit.offset = Vec3::new(x, y, z);
        } else if [x, y, z].iter().all(|size| *size > 0.0 && size.is_finite()) {
            fit.size = Vec3::new(x, y, z);
        } else {
            return Err(Fail::new(format!("the size of a shape is [{x} {y} {z}], expected numbers above 0")));
        }
        Ok(())
    }

    /// Which side of the trim curves that follow is kept.
    fn set_trim_sense(&mut self, sense: Option<&str>) -> RiResult {
        self.geometry.trims_inside = match sense {
            Some("inside") => false,
            Some("outside") => true,
            other => {
                let other = other.unwrap_or("");
                return Err(Fail::new(format!("unknown sense of trim curves `{other}`, expected inside or outside")));
            }
        };
        Ok(())
    }

    /// A light, which is on.
    pub(super) fn add_light(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        let mut light = BoundShader::clone(&*self.shader(name, "light", params)?);
        self.changes += 1;
        let space = format!("the space of light {}", self.changes);
        light.set_space(&space);
        self.scene.spaces.insert(space, self.transform);
        let light = Arc::new(light);
        // A handle that is used again names the new light from now on; the other shines as before.
        self.attributes.lights.push((handle.into(), light.clone()));
        self.known_lights.retain(|(h, _)| h != handle);
        self.known_lights.push((handle.into(), light));
        self.lights_changed();
        Ok(())
    }

    /// Switch a light on or off.
    pub(super) fn switch_light(&mut self, handle: &str, on: bool) -> RiResult {
        let known = |lights: &[(String, Arc<BoundShader>)]| lights.iter().find(|(h, _)| h == handle).cloned();
        let light = known(&self.known_lights);
        let Some(light) = light else { return Err(Fail::new(format!("there is no light `{handle}`"))) };
        self.attributes.lights.retain(|(_, l)| !Arc::ptr_eq(l, &light.1));
        if on {
            self.attributes.lights.push(light);
        }
        self.lights_changed();
        Ok(())
    }

    /// An area light: the primitives after it shine.
    pub(super) fn add_area_light(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        self.in_world("`AreaLightSource`")?;
        self.add_light(name, handle, params)?;
        self.sets(Attribute::AreaLight);
        if let Some((_, shader)) = self.known_lights.iter().find(|(h, _)| h == handle) {
            let samples = self.attributes.light_samples;
            self.attributes.area_light = Some(self.scene.area_lights.len());
            self.scene.area_lights.push(AreaLight { shader: shader.clone(), samples, area: Area::default() });
        }
        Ok(())
    }

    /// The corners of a box of object space in current space.
    pub(super) fn corners_of(&self, [x0, x1, y0, y1, z0, z1]: [f32; 6]) -> [Vec3; 8] {
        let pick = |k: usize, bit: usize, a: f32, b: f32| if k >> bit & 1 == 0 { a } else { b };
        std::array::from_fn(|k| {
            self.transform.transform_point3(Vec3::new(pick(k, 0, x0, x1), pick(k, 1, y0, y1), pick(k, 2, z0, z1)))
        })
    }

    /// Square pixels that a box covers, by its corners in current space, scaled by the relative detail.
    pub(super) fn raster_area(&self, corners: [Vec3; 8]) -> f32 {
        let Some(to_camera) = self.to_camera else { return f32::INFINITY };
        let camera = Camera::new(&self.options, to_camera, vec![]);
        let corners = corners.map(|p| to_camera.transform_point3(p));
        let (min, max) =
            corners.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        camera.bound(min, max).map_or(0.0, |b| (b.max.x - b.min.x) * (b.max.y - b.min.y)) * self.options.relative_detail
    }

    /// Interpolation of colours over a micropolygon.
    pub(super) fn set_interpolation(&mut self, kind: &str) -> RiResult {
        self.sets(Attribute::Interpolation);
        self.attributes.smooth = match kind {
            "smooth" => true,
            "constant" => false,
            other => return Err(Fail::new(format!("unknown interpolation `{other}`, expected constant or smooth"))),
        };
        Ok(())
    }

    /// Which side is outside: that of the handedness of the current space, the other, or that of a handedness as it is named (RISpec, `Orientation`).
    pub(super) fn set_orientation(&mut self, kind: &str) -> RiResult {
        self.sets(Attribute::Orientation);
        // The camera's space is left-handed.
        let to_camera = self.to_camera.unwrap_or(Mat4::IDENTITY) * self.transform;
        let is_right_handed = to_camera.determinant() < 0.0;
        self.attributes.reversed = match kind {
            "outside" => false,
            "inside" => true,
            "lh" => is_right_handed,
            "rh" => !is_right_handed,
            other => {
                return Err(Fail::new(format!("unknown orientation `{other}`, expected outside, inside, lh or rh")));
            }
        };
        Ok(())
    }

    /// The part of the samples that see the current level of detail: none out of its range, all in its middle; in a transition
    /// levels share the samples, so that together they are whole (RISpec 5.6).
    pub(super) fn level_changed(&mut self) {
        self.sets(Attribute::Detail);
        self.find_level();
    }

    /// The same, of attributes that an instance has from its object.
    pub(super) fn find_level(&mut self) {
        if let Some(corners) = self.attributes.detail_box {
            self.attributes.detail = self.raster_area(corners);
        }
        let ([least, lower, upper, most], detail) = (self.attributes.detail_range, self.attributes.detail);
        self.attributes.seen = match detail {
            d if d < least || d > most => [0.0; 2],
            d if d < lower => [0.0, (d - least) / (lower - least)],
            d if d > upper => [(d - upper) / (most - upper), 1.0],
            _ => [0.0, 1.0],
        };
    }

    pub(super) fn lights_changed(&mut self) {
        self.sets(Attribute::Lights);
        self.attributes.light_list = Arc::new(self.attributes.lights.iter().map(|(_, l)| l.clone()).collect());
    }
}
