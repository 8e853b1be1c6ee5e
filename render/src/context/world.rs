//! `WorldBegin` and `WorldEnd`, which renders.

use crate::context::copies::Copies;
use crate::context::result::{DrawnBy, RenderResult};
use crate::context::state::Context;
use crate::cpu::rays::say_open;
use crate::cpu::render::render;
use crate::cpu::volumes::say_idle;
use crate::drawn::Drawn;
use crate::film::display;
use crate::film::filter::FilterKind;
use crate::film::image::{Image, expose};
use crate::scene::camera::Camera;
use crate::scene::channels::say_unprovided;
use crate::scene::emitters;
use crate::scene::motion;
use crate::scene::options::{Hider, Options};
use crate::scene::twins::hide_twins;
use crate::scene::world::Scene;
use crate::stats::Stats;
use crate::texture::Textures;
use glam::Mat4;
use ri::{Fail, RiResult};
use sl::machine::{Answer, BoundShader};
use std::path::Path;
use std::sync::Arc;

impl Context {
    /// `WorldBegin`: the camera is where the current transformation leads, and the scene begins.
    pub(super) fn begin_world(&mut self) -> RiResult {
        if self.to_camera.is_some() {
            return Err(Fail::new("WorldBegin within WorldBegin"));
        }
        let to_camera = self.transform;
        if !(to_camera.determinant().abs() > 0.0) {
            return Err(Fail::new("the camera's transformation cannot be inverted"));
        }
        self.to_camera = Some(to_camera);
        self.before_world = (self.known_lights.clone(), self.scene.spaces.clone());
        self.scene = Scene {
            camera_to_world: to_camera.inverse(),
            warnings: std::mem::take(&mut self.scene.warnings),
            spaces: std::mem::take(&mut self.scene.spaces),
            solids: std::mem::take(&mut self.scene.solids),
            options: std::mem::take(&mut self.scene.options),
            clipping: self.options.clipping,
            shutter: self.options.shutter,
            textures: Textures::new(
                self.files.folders.clone(),
                self.made.clone(),
                self.options.texture_memory,
                self.options.texture_encoded,
            ),
            ..Scene::default()
        };
        self.copies = Copies::default();
        self.tell_options();
        self.say_levels_of_depths();
        self.say_missing_images();
        // Spaces that were set before are in camera space.
        self.scene.spaces.values_mut().for_each(|m| *m = to_camera.inverse() * *m);
        let camera = Camera::new(&self.options, to_camera, vec![]);
        let spaces = camera.image_spaces(&self.options).map(|(name, from_world)| (name.into(), from_world.inverse()));
        self.scene.spaces.extend(spaces);
        self.outside = [self.attribute_stack.len(), self.transform_stack.len()];
        self.attribute_stack.push((self.attributes.clone(), self.place(), self.geometry.clone()));
        self.bring_shaders(to_camera.inverse());
        self.camera_moves = std::mem::take(&mut self.moves);
        self.transform = Mat4::IDENTITY;
        Ok(())
    }

    /// Bring the shaders that were set before the world, in camera space, to that of the world.
    fn bring_shaders(&mut self, to_world: Mat4) {
        let mut known: Vec<(Arc<BoundShader>, Arc<BoundShader>)> = vec![];
        // What is named twice stays one.
        let mut bring = |shader: &mut Arc<BoundShader>| {
            let there = known.iter().find(|(here, _)| Arc::ptr_eq(here, shader)).map(|(_, there)| there.clone());
            let there = there.unwrap_or_else(|| {
                let mut there = BoundShader::clone(shader);
                there.transform(to_world);
                let there = Arc::new(there);
                known.push((shader.clone(), there.clone()));
                there
            });
            *shader = there;
        };
        let a = &mut self.attributes;
        let volumes = [&mut a.interior, &mut a.exterior].into_iter().flatten().map(|(shader, space)| (shader, space));
        let own = [
            (Some(&mut a.surface), &mut a.surface_space),
            (a.displacement.as_mut(), &mut a.displacement_space),
            (a.atmosphere.as_mut(), &mut a.atmosphere_space),
        ];
        for (shader, space) in own.into_iter().chain(volumes.map(|(shader, space)| (Some(shader), space))) {
            *space = to_world * *space;
            shader.into_iter().for_each(&mut bring);
        }
        a.lights.iter_mut().chain(&mut self.known_lights).for_each(|(_, light)| bring(light));
        self.lights_changed();
    }

    /// Options of the image for shaders that ask (RISpec 15.8).
    fn tell_options(&mut self) {
        let o = &self.options;
        let pixels = |[width, height]: [usize; 2]| [width as f32, height as f32, o.pixel_aspect];
        let lens = o.lens.unwrap_or([f32::INFINITY; 3]);
        let all: [(&str, &[f32]); 8] = [
            ("Format", &pixels(o.format)),
            ("DeviceResolution", &pixels([o.width, o.height])),
            ("FrameAspectRatio", &[o.aspect()]),
            ("CropWindow", &o.crop),
            ("Shutter", &o.shutter),
            ("DepthOfField", &lens),
            ("Exposure", &[o.gain, o.gamma]),
            ("PixelSamples", &o.samples.map(|n| n as f32)),
        ];
        let all: Vec<_> = all.into_iter().map(|(name, v)| (name.to_string(), Answer::Numbers(v.to_vec()))).collect();
        self.scene.options.retain(|(name, _)| all.iter().all(|(n, _)| n != name));
        self.scene.options.extend(all);
    }

    /// `WorldEnd`: the scene is rendered, and forgotten.
    pub(super) fn end_world(&mut self) -> RiResult {
        let Some(to_camera) = self.to_camera.take() else { return Err(Fail::new("WorldEnd without WorldBegin")) };
        // What is found wrong while the image is drawn has no place in the file.
        self.scene.warnings.set_place(None);
        say_unprovided(&self.scene, &display::aovs(&self.options.displays));
        if self.dry {
            return Ok(());
        }
        if self.options.displays.is_empty() && self.options.unsupported_display {
            return self.leave_world();
        }
        emitters::expand(&mut self.scene);
        say_open(&self.scene);
        say_idle(&self.scene);
        hide_twins(&mut self.scene);
        clear_before_shown(&mut self.scene);
        if self.options.hider == Hider::Null {
            let options = Options { displays: vec![], unsupported_display: true, ..self.options.clone() };
            let items = self.scene.sources.iter().map(|s| s.len() as u64).sum();
            let stats = Stats { items, ..Stats::default() };
            let warnings = self.scene.take_warnings();
            let image = Image::new(0, 0, vec![]);
            let (drawn_by, identities) = (DrawnBy::Cpu, vec![]);
            self.results.push(RenderResult {
                frame: self.frame,
                options,
                image,
                stats,
                warnings,
                drawn_by,
                identities,
            });
            return self.leave_world();
        }
        let moves = match self.camera_moves.as_slice() {
            [] => vec![],
            keys => motion::in_shutter(keys, self.open_shutter()).1,
        };
        if self.options.hider == Hider::Depth {
            self.options.samples = [1, 1];
            (self.options.filter, self.options.filter_width) = (FilterKind::Box, [1.0; 2]);
            self.options.lens = None;
        }
        let name = self.options.displays.first().map_or("an image", |display| &display.name);
        guard::memory::doing("rendering", Path::new(name));
        let camera = Camera::new(&self.options, to_camera, moves);
        self.options.shard = self.shard;
        self.options.about.clone_from(&self.about);
        self.options.keep_ids = self.keep_ids;
        let (Drawn { mut image, stats, identities }, drawn_by) = self.draw(camera);
        if let Some(message) = self.scene.stopped() {
            let at = self.scene.stopped_at().map(|spot| self.scene.warnings.place_of(spot));
            return Err(Fail::new(message).at(at));
        }
        image.keep_variables(display::aovs(&self.options.displays).len());
        // What an imager takes is exposed before it (RISpec 4.1.2, figure 4.2).
        if self.options.imager.is_none() {
            expose(&mut image.pixels, self.options.gain, self.options.gamma);
        }
        let warnings = self.scene.take_warnings();
        let (frame, options) = (self.frame, self.options.clone());
        self.results.push(RenderResult { frame, options, image, stats, warnings, drawn_by, identities });
        self.leave_world()
    }

    /// Draw the scene on the device, if there is one and it can, else on the processor.
    fn draw(&self, camera: Camera) -> (Drawn, DrawnBy) {
        let (scene, options, progress) = (&self.scene, &self.options, &*self.progress);
        let on_cpu = |camera| render(scene, options, camera, progress);
        let Some(device) = &self.device else { return (on_cpu(camera), DrawnBy::Cpu) };
        match device.render(scene, options, camera.clone(), progress) {
            Ok(drawn) => (drawn, DrawnBy::Gpu),
            Err(refusal) => (on_cpu(camera), DrawnBy::Fallback(refusal.to_string())),
        }
    }

    /// Back to what held before `WorldBegin`; options and warnings stay.
    fn leave_world(&mut self) -> RiResult {
        self.scene = Scene {
            options: std::mem::take(&mut self.scene.options),
            warnings: std::mem::take(&mut self.scene.warnings),
            ..Scene::default()
        };
        (self.known_lights, self.scene.spaces) = std::mem::take(&mut self.before_world);
        self.objects.clear();
        // Blocks that are still open end here.
        (self.motion, self.open_object) = (None, None);
        self.open_solids.clear();
        self.attribute_stack.truncate(self.outside[0] + 1);
        self.transform_stack.truncate(self.outside[1]);
        if let Some((attributes, place, geometry)) = self.attribute_stack.pop() {
            (self.attributes, self.geometry) = (attributes, geometry);
            (self.transform, self.moves) = place;
        }
        Ok(())
    }
}

/// What a display shows as it is has no atmosphere before it.
fn clear_before_shown(scene: &mut Scene) {
    for source in &mut scene.sources {
        if source.attributes.atmosphere.is_some() && source.attributes.is_shown() {
            Arc::make_mut(&mut source.attributes).atmosphere = None;
        }
    }
}
