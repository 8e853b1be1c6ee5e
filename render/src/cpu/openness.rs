//! How open to the sky points are: by cones about fixed directions, each of which bodies around the point close in part.
//!
//! A sphere closes what its disc covers of a cone; a facet what lies on the inner side of its four edges; both fade over a cone's width,
//! so that shadows are soft and nothing is sampled: there is no noise, and what moves changes smoothly. Spheres count within some radii
//! of theirs; facets are kept in a hierarchy whose nodes stand for all of theirs from afar, as a disc of their area as seen from
//! there. Displaced bodies count as they are before displacement, parts of solids and what light gets through not at all. A point's answer depends on
//! no other point, so that the same bits come out however points are asked together.

use crate::cpu::openness::cones::{CONES, Cones, cones};
use crate::cpu::openness::facets::Facets;
use crate::cpu::openness::spheres::{Near, Spheres};
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::Vec3;
use sl::machine::{OpenPlace, open_to};

pub mod cones;
pub mod facets;
pub mod spheres;

/// What closes cones in a scene.
pub struct Surroundings {
    pub spheres: Spheres,
    pub facets: Facets,
}

impl Surroundings {
    /// Of what casts whole shadows.
    pub fn new(scene: &Scene) -> Surroundings {
        let counts = |item: &Item| {
            let source = &scene.sources[item.source as usize];
            let a = &*source.attributes;
            a.casts_shadows && source.blocks_light() && a.solid.is_none()
        };
        let items: Vec<Item> = scene.items().filter(counts).collect();
        Surroundings { spheres: Spheres::new(scene, &items), facets: Facets::new(scene, &items) }
    }

    /// Answer for places on an item: as [`sl::machine::Scene::openness`].
    pub fn open(&self, own: Item, places: &[OpenPlace], out: &mut [[f32; 3]]) {
        let near = self.spheres.near(own, places);
        places.iter().zip(out).for_each(|(place, out)| *out = self.open_at(&near, place));
    }

    fn open_at(&self, near: &Near, place: &OpenPlace) -> [f32; 3] {
        let [at, normal, up] = [place.at, place.normal, place.up].map(Vec3::from);
        let mut open = Cones::OPEN;
        near.close(at, normal, &mut open);
        let beneath = open;
        self.facets.close(at, normal, &mut open);
        // Sums over the cones that face the surface: all, and what is open of them; for an even sky, one that brightens with the height,
        // and what is below the horizon.
        let (mut all, mut sum) = ([0.0f32; 3], [0.0f32; 3]);
        for (k, d) in cones().iter().enumerate().take(CONES) {
            let height = d.dot(up);
            let above = (0.5 + height).clamp(0.0, 1.0);
            let facing = d.dot(normal).max(0.0);
            let parts = [above, above * height.max(0.0), 1.0 - above].map(|part| part * facing);
            let seen = [open.0[k], open.0[k], beneath.0[k]];
            (0..3).for_each(|c| (all[c], sum[c]) = (all[c] + parts[c], sum[c] + parts[c] * seen[c]));
        }
        let free = open_to(normal.dot(up));
        [0, 1, 2].map(|c| if all[c] > 0.0 { free[c] * sum[c] / all[c] } else { free[c] })
    }
}
