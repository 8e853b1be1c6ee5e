//! How open to the sky points are: by cones about fixed directions, each of which bodies around the point close in part.
//!
//! A sphere closes what its disc covers of a cone; a facet what lies on the inner side of its four edges; both fade over a cone's width,
//! so that shadows are soft and nothing is sampled: there is no noise, and what moves changes smoothly. Spheres count within some radii
//! of theirs; facets are kept in a hierarchy whose nodes stand for all of theirs from afar, as a disc of their area as seen from
//! there. Of a curved surface that is not closed, facets count little beside their own points, which lie under them in a hollow. Displaced bodies count as they are before displacement, parts of solids and what light gets through not at all. A point's answer depends on
//! no other point, so that the same bits come out however points are asked together.

use crate::cpu::openness::cones::{CONES, Cones, Tint, cones, phase};
use crate::cpu::openness::facets::{Facets, Shut};
use crate::cpu::openness::spheres::{Near, Spheres};
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::Vec3;
use sl::machine::{Open, OpenPlace, open_to};

pub mod cones;
pub mod facets;
pub mod spheres;

/// How much of the sun that shines from behind a surface gets past the body that it is of, to what it sees.
const PAST: f32 = 0.7;

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

    /// Answer for places on an item, which is of a whole: as [`sl::machine::Scene::openness`].
    pub fn open(&self, own: Item, whole: u32, places: &[OpenPlace], out: &mut [Open]) {
        let near = self.spheres.near(own, places);
        places.iter().zip(out).for_each(|(place, out)| *out = self.open_at(whole, &near, place));
    }

    fn open_at(&self, whole: u32, near: &Near, place: &OpenPlace) -> Open {
        let [at, normal, up, sun] = [place.at, place.normal, place.up, place.sun].map(Vec3::from);
        let mut beneath = Cones::OPEN;
        let none = [0.0f32; CONES];
        let mut shut = Shut { sun, closed: none, bright: none, far: none, tint: Tint::default() };
        near.close(at, normal, &mut beneath, &mut shut.tint);
        self.facets.close(whole, at, normal, &mut shut);
        let open: [f32; CONES] = std::array::from_fn(|k| beneath.0[k] * (1.0 - shut.closed[k].min(1.0)));
        // Sums over the cones that face the surface: all, and what is open of them; for an even sky, one that brightens with the height,
        // and what is below the horizon. And of what is closed: how large it is, and how bright under the sun.
        let (mut all, mut sum, mut low) = ([0.0f32; 3], [0.0f32; 3], 0.0);
        let (mut facing_all, mut closed, mut near_lit, mut far_lit) = (0.0f32, 0.0, 0.0, 0.0);
        let (mut sunny_all, mut sunny) = (0.0f32, 0.0);
        for (k, d) in cones().iter().enumerate().take(CONES) {
            let (height, before, toward) = (d.dot(up), d.dot(normal), d.dot(sun));
            let above = (0.5 + height).clamp(0.0, 1.0);
            let facing = before.max(0.0);
            let parts = [above, above * height.max(0.0), 1.0 - above].map(|part| part * facing);
            let seen = [open[k], open[k], beneath.0[k]];
            (0..3).for_each(|c| (all[c], sum[c]) = (all[c] + parts[c], sum[c] + parts[c] * seen[c]));
            low += parts[2] * open[k];
            let by_facets = facing * (beneath.0[k] - open[k]) / shut.closed[k].max(1e-6);
            (facing_all, closed) = (facing_all + facing, closed + facing * (1.0 - open[k]));
            near_lit += facing * (1.0 - beneath.0[k]) * phase(toward) + by_facets * shut.bright[k];
            far_lit += by_facets * shut.far[k];
            let lobe = toward.max(0.0) * toward.max(0.0);
            let past = PAST + (1.0 - PAST) * (0.5 + before).clamp(0.0, 1.0);
            (sunny_all, sunny) = (sunny_all + lobe, sunny + lobe * open[k] * past);
        }
        let free = open_to(normal.dot(up));
        let part = |c: usize, sum: f32| if all[c] > 0.0 { free[c] * sum / all[c] } else { free[c] };
        let of = |sum: f32, all: f32| if all > 0.0 { sum / all } else { 0.0 };
        Open {
            sky: [0, 1, 2].map(|c| part(c, sum[c])),
            low: part(2, low),
            closed: of(closed, facing_all),
            // The sun gets to what is near by as it does to here, and to all that is far.
            lit: if sunny_all > 0.0 {
                of(far_lit + (near_lit - far_lit) * (sunny / sunny_all), facing_all)
            } else {
                0.0
            },
            color: shut.tint.mean().to_array(),
        }
    }
}
