//! Materials: the kernels of a surface and its atmosphere in their lights, one for attributes whose shaders differ in numbers alone.

use crate::cpu::frame::Frame;
use crate::cpu::view::View;
use crate::gpu::refusal::Refusal;
use crate::gpu::world::{DECLARATIONS, FUNCTIONS, OF_RAYS};
use crate::scene::attributes::Attributes;
use crate::scene::source::{Item, ItemView, Source};
use crate::scene::world::Scene;
use gpu::{Buffer, Device, GpuError};
use rayon::prelude::*;
use sl::Global;
use sl::ir::{Ask, Lookup, Program};
use sl::machine::BoundShader;
use sl::wgsl::{Host, Kernel, Query, Target};
use std::collections::HashSet;
use std::sync::Arc;

/// Points of a grid that looks at neighbours, at least as many as any has.
const GROUP: u32 = 320;

/// Kernels of shaders, and what they are for.
pub struct Material {
    surface: Arc<BoundShader>,
    pub lights: Arc<Vec<Arc<BoundShader>>>,
    atmosphere: Option<Arc<BoundShader>>,
    /// That of the surface.
    pub kernel: Kernel,
    /// That of the atmosphere.
    pub through: Option<Kernel>,
    /// Of the surface's shader and of the atmosphere's: points with what is no finite number, and the first source of these; points of the first
    /// with what is no number; points with opacities below 0 or above 1, and the first source of these.
    pub lost: Buffer<u32>,
}

/// The materials of a frame.
pub struct Materials<'a> {
    device: &'a Device,
    pub all: Vec<Material>,
    /// Those of sources, as far as they are known.
    of_source: Vec<Option<usize>>,
}

impl<'a> Materials<'a> {
    /// None yet.
    pub fn new(device: &'a Device) -> Materials<'a> {
        Materials { device, all: vec![], of_source: vec![] }
    }

    /// Find kernels for all that the camera may see, of whose sources some become layers; whether any asks what stops light, and what closes
    /// the sky.
    ///
    /// # Errors
    /// A shader that has no kernel.
    pub fn find(&mut self, frame: &Frame<'_>, layered: &[bool]) -> Result<[bool; 2], Refusal> {
        let is_wanted = |source: &Source, is_layered: bool| {
            let is_shaded = !source.attributes.matte || is_layered;
            source.attributes.visible && is_shaded && source.len() > 0
        };
        let sources = (0..).zip(&frame.scene.sources).zip(layered);
        let wanted = sources.filter(|((_, source), is_layered)| is_wanted(source, **is_layered));
        let items: Vec<Item> = wanted.map(|((source, _), _)| Item { source, index: 0 }).collect();
        // Those of programs are written at once; the others differ from these in numbers alone, as far as strings do not.
        let mut known = HashSet::new();
        let first: Vec<Item> =
            items.iter().copied().filter(|item| known.insert(programs_of(frame.scene.attributes(*item)))).collect();
        let written: Vec<_> = first.par_iter().map(|item| self.write(frame, *item, &frame.scene.view(*item))).collect();
        for (item, kernels) in first.into_iter().zip(written) {
            let view = frame.scene.view(item);
            if self.known(frame, item, &view).is_none() {
                self.push(view.attributes, kernels?)?;
            }
        }
        for item in items {
            self.of_view(frame, item, &frame.scene.view(item))?;
        }
        let kernels =
            || self.all.iter().flat_map(|material| [Some(&material.kernel), material.through.as_ref()]).flatten();
        let asks = |queries: &[Query]| kernels().any(|kernel| queries.iter().any(|query| kernel.asks(*query)));
        let has_shadows = kernels().any(|kernel| kernel.maps().any(|(how, ..)| how == Lookup::Shadow));
        for (_, name, _) in kernels().flat_map(Kernel::maps).filter(|(how, ..)| *how != Lookup::Shadow) {
            frame.scene.textures.number(name);
        }
        if asks(&[Query::Hit]) && frame.rays.any_translucent() {
            let why = "a shader asks what translucent surfaces hide, which is not built for graphics devices";
            return Err(Refusal::Unsupported(why.into()));
        }
        Ok([has_shadows || asks(&OF_RAYS), asks(&[Query::Openness])])
    }

    /// The index of the material of an item, which is that of its source.
    ///
    /// # Errors
    /// A shader that has no kernel.
    pub fn of(&mut self, frame: &Frame<'_>, item: Item) -> Result<usize, Refusal> {
        let source = item.source as usize;
        if let Some(material) = self.of_source.get(source).copied().flatten() {
            return Ok(material);
        }
        let material = self.of_view(frame, item, &frame.scene.view(item))?;
        self.of_source.resize(self.of_source.len().max(source + 1), None);
        self.of_source[source] = Some(material);
        Ok(material)
    }

    /// The index of the material of an item of a view.
    fn of_view(&mut self, frame: &Frame<'_>, item: Item, view: &ItemView<'_>) -> Result<usize, Refusal> {
        match self.known(frame, item, view) {
            Some(k) => Ok(k),
            None => self.push(view.attributes, self.write(frame, item, view)?),
        }
    }

    /// The index of the material of an item of a view, if it is there. Kernels are for the strings that the scene answers with, too.
    fn known(&self, frame: &Frame<'_>, item: Item, view: &ItemView<'_>) -> Option<usize> {
        let scene = View::new(frame.scene, &frame.rays, item, view, [0.0; 2]);
        self.all.iter().position(|material| {
            let mut kernels = [Some(&material.kernel), material.through.as_ref()].into_iter().flatten();
            material.is_of(view.attributes) && kernels.all(|kernel| kernel.is_answered_by(&scene))
        })
    }

    /// Write the kernels of an item of a view: that of its surface, and that of its atmosphere.
    fn write(&self, frame: &Frame<'_>, item: Item, view: &ItemView<'_>) -> Result<(Kernel, Option<Kernel>), Refusal> {
        let a = view.attributes;
        let scene = View::new(frame.scene, &frame.rays, item, view, [0.0; 2]);
        let kernel = self.kernel(frame, &a.surface, &a.light_list, &scene)?;
        let Some(shader) = &a.atmosphere else { return Ok((kernel, None)) };
        let scene = View { shader_to_world: a.atmosphere_space, ..scene };
        let through = self.kernel(frame, shader, &a.light_list, &scene)?;
        if through.asks_by_name(Ask::Surface) {
            return Err(Refusal::of_shader(&shader.program.name, "asks a surface shader what it has left"));
        }
        let changes = |target| !matches!(target, Target::Global(Global::Ci | Global::Oi) | Target::Parameter(_));
        if kernel.outputs().iter().any(|output| changes(output.target)) {
            return Err(Refusal::of_shader(&a.surface.program.name, "changes more than colours before an atmosphere"));
        }
        Ok((kernel, Some(through)))
    }

    /// Add the material of some attributes; its index.
    fn push(&mut self, a: &Attributes, (kernel, through): (Kernel, Option<Kernel>)) -> Result<usize, Refusal> {
        let (surface, lights, atmosphere) = (a.surface.clone(), a.light_list.clone(), a.atmosphere.clone());
        let lost =
            Buffer::of(self.device, "points without finite colours", &[0, u32::MAX, 0, u32::MAX, 0, 0, u32::MAX])?;
        self.all.push(Material { surface, lights, atmosphere, kernel, through, lost });
        Ok(self.all.len() - 1)
    }

    /// Write the kernel of a shader for lights.
    fn kernel(
        &self,
        frame: &Frame<'_>,
        shader: &Arc<BoundShader>,
        lights: &[Arc<BoundShader>],
        scene: &View<'_>,
    ) -> Result<Kernel, Refusal> {
        let group = GROUP.min(self.device.adapter.max_invocations);
        let declarations = DECLARATIONS[frame.rays.any_translucent() as usize];
        let host = |functions| Host { group, functions, declarations, scene };
        let mut kernel = Kernel::new(shader, lights, host(&FUNCTIONS[0]))?;
        if kernel.maps().any(|(how, ..)| how != Lookup::Shadow) {
            kernel = Kernel::new(shader, lights, host(&FUNCTIONS[1]))?;
        }
        if let Some((_, map, _)) = kernel.maps().find(|(how, _, by_light)| *how == Lookup::Shadow && !by_light) {
            return Err(Refusal::of_shader(&shader.program.name, &format!("looks up the shadow map `{map}`")));
        }
        if let Some(light) = kernel.light_of_primitive() {
            return Err(Refusal::of_shader(light, "is a light's that reads what differs from primitive to primitive"));
        }
        Ok(kernel)
    }

    /// Tell the scene of colours and opacities that are no finite numbers, and of what are no opacities.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn report(&self, scene: &Scene) -> Result<(), GpuError> {
        for material in &self.all {
            let lost = material.lost.read(self.device, 7)?;
            if lost[0] > 0 {
                scene.not_finite(&material.surface.program, lost[0] as usize, lost[1]);
            }
            let more = lost[2].saturating_sub(lost[4]);
            if let Some(atmosphere) = material.atmosphere.as_ref().filter(|_| more > 0) {
                scene.not_finite(&atmosphere.program, more as usize, lost[3]);
            }
            if lost[5] > 0 {
                scene.not_opacities(&material.surface.program, lost[5] as usize, lost[6]);
            }
        }
        Ok(())
    }
}

impl Material {
    /// Whether it is that of these attributes.
    fn is_of(&self, a: &Attributes) -> bool {
        let same = |a: &[Arc<BoundShader>], b: &[Arc<BoundShader>]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
        };
        let through = match (&self.atmosphere, &a.atmosphere) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (None, None) => true,
            _ => false,
        };
        let is_same = Arc::ptr_eq(&self.surface, &a.surface) || self.kernel.is_of(&a.surface);
        through && is_same && same(&self.lights, &a.light_list)
    }
}

/// The programs of the shaders of some attributes, and their lights, by where they are.
fn programs_of(a: &Attributes) -> (*const Program, Option<*const BoundShader>, Vec<*const BoundShader>) {
    let lights = a.light_list.iter().map(Arc::as_ptr).collect();
    (Arc::as_ptr(&a.surface.program), a.atmosphere.as_ref().map(Arc::as_ptr), lights)
}
