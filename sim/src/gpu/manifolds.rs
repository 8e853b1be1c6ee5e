//! Narrow phase of shapes of any kind: pairs are sorted into families, the contact points of each pair found and kept, their counts scanned, and
//! the contacts written. Each family has kernels of its own, over the list of its pairs.
//! in   position     [n_bodies]    fine units
//! in   orientation  [n_bodies]
//! in   margin       [n_spheres]   m
//! in   solid        [n_spheres]
//! in   fixture      [n_fixtures]
//! in   pairs        [n_pairs]
//! out  contact      [n_contacts]  in the order of the pairs
//! out  arms         [n_contacts]  m
//! out  room         [3]           whether there is room for all of them, and for how many it is needed
//! Kernels: pair_family.wgsl and the compaction, place_due.wgsl, round_contacts.wgsl, solid_contacts.wgsl, the scan, contact_room.wgsl,
//! kept_contacts.wgsl, contact_finish.wgsl.
//! Twin: cpu/contact_write.rs, cpu/collide.rs
//!
//! Points are found in single precision about the centre of mass of one of the bodies: gaps are right to 5e-7 of the pair's size.

use super::bodies::Bodies;
use super::bounds::Due;
use super::fixtures::Fixtures;
use super::pair_write::Pairs;
use super::parts::{Layout, ROWS, bits, kernel, kernel_with};
use super::rows::{Arms, Contact};
use super::solids::{Family, families};
use super::spheres::Spheres;
use crate::model::Model;
use gpu::compact::Compact;
use gpu::scan::Scan;
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels, Work};

/// Pairs of a workgroup of a family's kernels.
const PAIRS: usize = 64;

/// The stage's kernels and columns.
pub struct Manifolds {
    /// Arms of the contacts, m (n_contacts).
    pub arms: Buffer<Arms>,
    due: Kernel,
    round: [Kernel; 2],
    room: Kernel,
    finish: Kernel,
    scan: Scan,
    groups: Groups,
    of_contacts: Groups,
    /// Number of points of each pair, then of the contacts before it, and of all (n_pairs + 1).
    pub place: Buffer<u32>,
    n_places: Count,
    families: Vec<OfFamily>,
    put: Kernel,
    /// The points of the families, in any order: three rows each (3 n_contacts).
    kept: Buffer<[f32; 4]>,
    /// Their number (1).
    n_kept: Buffer<u32>,
}

/// What a family needs.
struct OfFamily {
    is_of: Kernel,
    points: Kernel,
    compact: Compact,
    groups: Groups,
    /// Whether each pair is of the family, and then where the points of each of its pairs are kept (n_pairs).
    flag: Buffer<u32>,
    /// The pairs of the family.
    list: Buffer<u32>,
    n: Count,
}

impl Manifolds {
    /// With room for this many pairs and contacts.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        layout: Layout,
        (at, fixtures): (&Spheres, &Fixtures),
        [n_pairs, n_contacts]: [usize; 2],
    ) -> Result<Manifolds, GpuError> {
        let get = |name, text| kernel(device, kernels, name, text);
        let text = include_str!("round_contacts.wgsl");
        let round = |pass| kernel_with(layout, device, kernels, ("round_contacts", text), &[("pair_pass", pass)]);
        let kinds = families(&at.rows, &fixtures.kinds);
        Ok(Manifolds {
            arms: Buffer::zeros(device, "arms", n_contacts)?,
            due: get("place_due", include_str!("place_due.wgsl"))?,
            round: [round(include_str!("pair_count.wgsl"))?, round(include_str!("pair_pass.wgsl"))?],
            room: get("contact_room", include_str!("contact_room.wgsl"))?,
            finish: get("contact_finish", include_str!("contact_finish.wgsl"))?,
            scan: Scan::new(device, kernels, n_pairs + 1)?,
            groups: Groups::new(device, kernels, ROWS)?,
            of_contacts: Groups::new(device, kernels, ROWS)?,
            place: Buffer::zeros(device, "contact places", n_pairs + 1)?,
            n_places: Count::found(device, n_pairs + 1)?,
            put: get("kept_contacts", include_str!("kept_contacts.wgsl"))?,
            kept: Buffer::zeros(device, "kept points", 3 * n_contacts)?,
            n_kept: Buffer::zeros(device, "kept points", 1)?,
            families: kinds
                .into_iter()
                .map(|f| OfFamily::new(device, kernels, (layout, f), n_pairs))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Record the stage; where the pairs hold, so do the lists of the families.
    pub fn record(
        &self,
        device: &Device,
        c: &mut Commands,
        model: &Model,
        (bodies, at, fixtures): (&Bodies, &Spheres, &Fixtures),
        (due, hold): (&Due, bool),
        (from, contact, n): (&Pairs, &Buffer<Contact>, &Count),
    ) {
        let of_pairs = self.groups.of_level(&from.n, 0);
        self.groups.record(device, c, &from.n);
        c.dispatch(
            device,
            &self.due,
            &[self.place.bind(), self.n_places.n.bind(), from.n.n.bind(), self.n_kept.bind()],
            &[],
            Work::Groups(1),
        );
        let shapes = [at.sphere.bind(), at.solid.bind(), fixtures.fixture.bind()];
        for family in self.families.iter().filter(|_| !hold) {
            family.record_list(device, c, shapes, from, of_pairs);
        }
        let (n_materials, fine, unit) = (model.material_names.len() as u32, bodies.scale.fine(), bodies.scale.unit);
        let [fine, envelope, unit] = [fine, model.envelope, unit].map(bits);
        let place = [bodies.position.bind(), bodies.orientation.bind()];
        let rest = [at.margin.bind(), from.pairs.bind(), self.place.bind()];
        let out = [contact.bind(), self.arms.bind(), n.n.bind()];
        let bound: Vec<Bound> = place.into_iter().chain(shapes).chain(rest).chain(out).collect();
        let all: Vec<Bound> = bound.iter().copied().chain([from.n.n.bind()]).collect();
        let [count, write] = &self.round;
        c.dispatch(device, count, &all, &[envelope, unit], of_pairs);
        for family in &self.families {
            let own = [family.list.bind(), family.n.n.bind(), at.hulls.hull.bind()];
            let keeps = [self.kept.bind(), self.n_kept.bind(), family.flag.bind()];
            let bound: Vec<Bound> = place.into_iter().chain(shapes).chain(rest).chain(own).chain(keeps).collect();
            let work = family.groups.of_level(&family.n, 0);
            c.dispatch(device, &family.points, &bound, &[fine, envelope], work);
        }
        self.scan.record(device, c, &self.place, &self.n_places);
        let rooms = [from.pairs.capacity() as u32, contact.capacity() as u32, hold as u32];
        let counts = [from.room.bind(), n.n.bind(), from.n.n.bind(), due.left.bind(), due.lost.bind()];
        let of_room: Vec<Bound> = [self.place.bind()].into_iter().chain(counts).collect();
        c.dispatch(device, &self.room, &of_room, &rooms, Work::Groups(1));
        c.dispatch(device, write, &all, &[envelope, unit], of_pairs);
        for family in &self.families {
            let own = [family.list.bind(), family.n.n.bind(), self.kept.bind(), family.flag.bind()];
            let bound: Vec<Bound> = [from.pairs.bind(), self.place.bind()].into_iter().chain(out).chain(own).collect();
            c.dispatch(device, &self.put, &bound, &[], family.groups.of_level(&family.n, 0));
        }
        self.of_contacts.record(device, c, n);
        let [sphere, solid, fixture] = shapes;
        let from = [bodies.position.bind(), sphere, solid, fixture, bodies.activity.bind()];
        let bound: Vec<Bound> = from.into_iter().chain(out).collect();
        c.dispatch(device, &self.finish, &bound, &[n_materials, fine], self.of_contacts.of_level(n, 0));
    }
}

impl OfFamily {
    fn new(
        device: &Device,
        kernels: &Kernels,
        (layout, family): (Layout, Family),
        n_pairs: usize,
    ) -> Result<OfFamily, GpuError> {
        let text = include_str!("solid_contacts.wgsl");
        let is_of = include_str!("pair_family.wgsl");
        let own = Layout { hulls: layout.hulls && family.hulls, ..layout };
        Ok(OfFamily {
            is_of: kernel_with(layout, device, kernels, ("pair_family", is_of), &[("family", family.pairs)])?,
            points: kernel_with(own, device, kernels, (family.name, text), &[("points", family.points)])?,
            compact: Compact::new(device, kernels, n_pairs)?,
            groups: Groups::new(device, kernels, PAIRS)?,
            flag: Buffer::zeros(device, "family", n_pairs)?,
            list: Buffer::zeros(device, "pairs of the family", n_pairs)?,
            n: Count::found(device, n_pairs)?,
        })
    }

    /// Record the list of the family's pairs.
    fn record_list(&self, device: &Device, c: &mut Commands, shapes: [Bound; 3], from: &Pairs, of_pairs: Work) {
        let [sphere, solid, fixture] = shapes;
        let bound = [sphere, solid, fixture, from.pairs.bind(), self.flag.bind(), from.n.n.bind()];
        c.dispatch(device, &self.is_of, &bound, &[], of_pairs);
        self.compact.record(device, c, &self.flag, &from.n, &self.list, &self.n);
        self.groups.record(device, c, &self.n);
    }
}
