//! Calls that set attributes and make lights.

use crate::context::state::Context;
use crate::scene::area::{Area, AreaLight};
use crate::scene::camera::Camera;
use glam::Vec3;
use ri::{Fail, Params, RiResult, Values};
use sl::machine::{Answer, BoundShader};
use std::sync::Arc;

impl Context {
    /// Back to the attributes of the last `AttributeBegin`.
    pub(super) fn pop_attributes(&mut self) -> RiResult {
        let floor = self.to_camera.is_some() as usize;
        if self.attribute_stack.len() <= floor {
            return Err(Fail::new("AttributeEnd without AttributeBegin"));
        }
        if let Some((attributes, place)) = self.attribute_stack.pop() {
            self.attributes = attributes;
            (self.transform, self.moves) = place;
        }
        Ok(())
    }

    /// An attribute of a group.
    pub(super) fn set_attribute(&mut self, name: &str, params: Params) -> RiResult {
        for param in &params {
            let answer = match &param.values {
                Values::Floats(v) => Answer::Numbers(v.clone()),
                Values::Strings(v) => Answer::Text(v.first().cloned().unwrap_or_default()),
            };
            let key = format!("{name}:{}", param.decl.name);
            let user = Arc::make_mut(&mut self.attributes.user);
            user.retain(|(n, _)| *n != key);
            user.push((key, answer));
            let number = param.numbers().first().copied();
            match (name, param.decl.name.as_str(), number) {
                ("displacementbound", "sphere", Some(bound)) => {
                    self.attributes.displacement_bound = Some(bound.max(0.0))
                }
                ("light", "nsamples", Some(n)) => {
                    if !(1.0..=4096.0).contains(&n) {
                        return Err(Fail::new(format!("an area light of {n} samples, expected 1 to 4096")));
                    }
                    self.attributes.light_samples = n as usize;
                }
                ("visibility", "camera", Some(on)) => self.attributes.visible = on != 0.0,
                ("visibility", "transmission", Some(on)) => self.attributes.casts_shadows = on != 0.0,
                ("visibility", "transmission", None) => {
                    self.attributes.casts_shadows = param.text() != Some("transparent");
                    self.attributes.whole_shadows = param.text() == Some("opaque");
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// A light, which is on.
    pub(super) fn add_light(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        let light = self.shader(name, "light", params)?;
        self.attributes.lights.retain(|(h, _)| h != handle);
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
        self.attributes.lights.retain(|(h, _)| h != handle);
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
        if let Some((_, shader)) = self.known_lights.iter().find(|(h, _)| h == handle) {
            let samples = self.attributes.light_samples;
            self.attributes.area_light = Some(self.scene.area_lights.len());
            self.scene.area_lights.push(AreaLight { shader: shader.clone(), samples, area: Area::default() });
        }
        Ok(())
    }

    /// Square pixels that a box of object space covers, scaled by the relative detail.
    pub(super) fn raster_area(&self, [x0, x1, y0, y1, z0, z1]: [f32; 6]) -> f32 {
        let Some(to_camera) = self.to_camera else { return f32::INFINITY };
        let camera = Camera::new(&self.options, to_camera, vec![]);
        let m = to_camera * self.transform;
        let corners = (0..8).map(|k| {
            let pick = |bit: usize, a: f32, b: f32| if k >> bit & 1 == 0 { a } else { b };
            m.transform_point3(Vec3::new(pick(0, x0, x1), pick(1, y0, y1), pick(2, z0, z1)))
        });
        let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
        camera.bound(min, max).map_or(0.0, |b| (b.max.x - b.min.x) * (b.max.y - b.min.y)) * self.options.relative_detail
    }

    /// Interpolation of colours over a micropolygon.
    pub(super) fn set_interpolation(&mut self, kind: &str) -> RiResult {
        self.attributes.smooth = match kind {
            "smooth" => true,
            "constant" => false,
            other => return Err(Fail::new(format!("unknown interpolation `{other}`, expected constant or smooth"))),
        };
        Ok(())
    }

    /// Which side is outside.
    pub(super) fn set_orientation(&mut self, kind: &str) -> RiResult {
        self.attributes.reversed = match kind {
            "outside" | "lh" => false,
            "inside" | "rh" => true,
            other => {
                return Err(Fail::new(format!("unknown orientation `{other}`, expected outside, inside, lh or rh")));
            }
        };
        Ok(())
    }

    /// How much of the current level of detail is seen: 0 out of its range, 1 in its middle, in between in a transition (RISpec
    /// 5.6).
    pub(super) fn level_changed(&mut self) {
        let ([least, lower, upper, most], detail) = (self.attributes.detail_range, self.attributes.detail);
        self.attributes.level = match detail {
            d if d < least || d > most => 0.0,
            d if d < lower => (d - least) / (lower - least),
            d if d > upper => (most - d) / (most - upper),
            _ => 1.0,
        };
    }

    pub(super) fn lights_changed(&mut self) {
        self.attributes.light_list = Arc::new(self.attributes.lights.iter().map(|(_, l)| l.clone()).collect());
    }
}
