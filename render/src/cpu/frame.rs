//! What all buckets of an image read.

use crate::cpu::coplanar::Coplanar;
use crate::cpu::displace::displace;
use crate::cpu::displaced::Displace;
use crate::cpu::known::Known;
use crate::cpu::rays::Rays;
use crate::film::display::{self, Aov, aovs};
use crate::film::filter::PixelFilter;
use crate::film::jitter::Jitter;
use crate::scene::camera::{Camera, RasterPlane};
use crate::scene::options::Options;
use crate::scene::world::Scene;
use std::sync::Arc;

/// What all buckets of an image read.
pub struct Frame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What rays meet.
    pub rays: Rays<'a>,
    /// What rays of displacement shaders meet.
    pub displacement_rays: Arc<Rays<'a>>,
    /// What lies behind others in its plane.
    pub coplanar: Coplanar,
    /// Where displaced grids have been found.
    pub known: Known,
    /// The options.
    pub options: &'a Options,
    /// The camera.
    pub camera: Camera,
    /// User clipping planes.
    pub planes: Vec<RasterPlane>,
    /// Where samples lie.
    pub jitter: Jitter,
    /// The pixel filter.
    pub filter: PixelFilter,
    /// What displays take besides colour; behind that, what surfaces say that a display shows of them, if some do.
    pub aovs: Vec<Aov>,
    /// Count of the numbers of a sample that these are.
    pub depth: usize,
    /// Count of the variables that displays take.
    pub n_taken: usize,
    /// The offsets of the colour that a display shows of surfaces and of how much it covers, if some say so.
    pub shown: Option<[usize; 2]>,
}

impl<'a> Frame<'a> {
    /// The frame of a scene, whose hierarchy is built.
    pub fn new(scene: &'a Scene, options: &'a Options, camera: Camera) -> Frame<'a> {
        let filter = PixelFilter::new(options.filter, options.filter_width);
        let filter = if options.samples == [1, 1] { filter.of_middles() } else { filter };
        let jitter = Jitter::new(options.samples, camera.has_lens(), scene.moves(&camera));
        let mut aovs = aovs(&options.displays);
        let n_taken = aovs.len();
        let any_shown = scene.sources.iter().any(|source| source.attributes.is_shown());
        let shown = if any_shown { display::add_shown(&mut aovs) } else { None };
        let depth = display::depth(&aovs);
        let displacement_rays = Arc::new(Rays::of_displacement(scene));
        let met = displacement_rays.clone();
        let displace: Displace<'a> =
            Arc::new(move |subject, grid, machine| displace(scene, &met, subject, grid, machine));
        let rays = Rays::new(scene, &camera, &displace);
        let planes = camera.raster_planes(&options.clipping_planes);
        let (known, coplanar) = (Known::default(), Coplanar::of(scene));
        Frame {
            known,
            coplanar,
            planes,
            scene,
            rays,
            displacement_rays,
            options,
            camera,
            jitter,
            filter,
            aovs,
            depth,
            n_taken,
            shown,
        }
    }

    /// Pixels around a bucket that its filters reach into, along x and y.
    pub fn margin(&self) -> [usize; 2] {
        self.filter.margin()
    }

    /// Whether a display takes u, v, s, t or Ng.
    pub fn needs_parameters(&self) -> bool {
        self.aovs.iter().any(|a| matches!(a.name.as_str(), "u" | "v" | "s" | "t" | "Ng"))
    }
}
