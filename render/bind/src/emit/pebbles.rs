//! Pebbles on the scene's ground: small stones with shadows, at the same places in every frame.

use super::camera::{self, Stand};
use super::instances::Prepared;
use crate::binding::{Binding, Object, Projection, Quality, Shape};
use glam::{Quat, Vec3};
use ri::{Class, InstanceShape, Instances, Param, Ri, RiResult, Type, Values};

/// Pebbles of one size. Lengths are in parts of the view, which is the same in all frames.
struct Sort {
    /// Edge of the squares that have one or none.
    cell: f32,
    /// Share of the squares that have one.
    share: f32,
    /// Least and largest radius; most are small.
    radius: [f32; 2],
    /// How far from what the camera looks at they lie: none within the first.
    from: [f32; 2],
}

const SORTS: [Sort; 3] = [
    Sort { cell: 0.06, share: 0.45, radius: [0.0012, 0.0036], from: [0.0, 1.3] },
    Sort { cell: 0.11, share: 0.36, radius: [0.002, 0.0065], from: [0.0, 2.6] },
    Sort { cell: 0.5, share: 0.25, radius: [0.004, 0.014], from: [1.3, 10.0] },
];

/// Pebbles with the surface and displacement that the scene has there, on its ground or the data's. None where there is no level ground,
/// where its surface has `stones` 0, in drafts, and in images with channels, in which they would be bodies.
pub(super) fn inject(
    binding: &Binding,
    prepared: &[Prepared<'_>],
    stand: Option<Stand>,
    has_ground: bool,
    ri: &mut dyn Ri,
) -> RiResult {
    let output = &binding.output;
    let (Some(view), Some(stand)) = (camera::view(binding), stand) else { return Ok(()) };
    if output.quality == Quality::Draft || !output.channels.is_empty() {
        return Ok(());
    }
    let Some(height) = ground(binding, prepared, has_ground) else { return Ok(()) };
    let ([x, y], _) = stand.floor();
    let all = scattered([x, y, height], view, &Sight::of(stand, output.resolution));
    let largest = SORTS.iter().map(|sort| sort.radius[1] * view).fold(0.0, f32::max);
    let number = |name: &str, x: f32| vec![Param::floats(name, Class::Uniform, Type::Float, [x])];
    ri.attribute("displacementbound", number("sphere", 0.5 * largest))?;
    ri.attribute("trace", number("displacements", 0.0))?;
    ri.instances(all)
}

/// Height of the ground that pebbles lie on: the scene's own, a level plane of the data that is soil, or the floor under data that brings none.
fn ground(binding: &Binding, prepared: &[Prepared<'_>], has_ground: bool) -> Option<f32> {
    if has_ground {
        return Some(binding.ground_height.unwrap_or(0.0));
    }
    let by_surface = |object: &Object| object.surface.as_ref().is_some_and(|surface| surface.name == "ground");
    let is_bare = |object: &Object| {
        let params = object.surface.iter().flat_map(|surface| &surface.params);
        params.into_iter().any(|p| p.decl.name == "stones" && matches!(&p.values, Values::Floats(x) if x == &[0.0]))
    };
    let grounds = || {
        prepared
            .iter()
            .filter(|p| p.object.is_ground || by_surface(p.object) || matches!(p.object.shape, Shape::Plane(_)))
    };
    if grounds().next().is_none() {
        return binding.ground_height;
    }
    let soil =
        |p: &&Prepared<'_>| matches!(p.object.shape, Shape::Plane(_)) && by_surface(p.object) && !is_bare(p.object);
    let level = |all: &Instances, i: usize| {
        let turn = all.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
        ((turn * Vec3::Z).z > 0.9999).then(|| all.position[i][2])
    };
    let sets = grounds().filter(soil).flat_map(|p| &p.groups).flat_map(|group| &group.instances);
    sets.flat_map(|all| (0..all.len()).filter_map(|i| level(all, i))).reduce(f32::min)
}

/// What a camera may see.
struct Sight {
    eye: Vec3,
    forward: Vec3,
    /// Cosine of the angle from its middle to a corner and a little more; none in parallel projection.
    cosine: Option<f32>,
}

impl Sight {
    /// Radius of the least pebble that is seen, in parts of its distance: about half a pixel.
    const LEAST: f32 = 3e-4;

    fn of(stand: Stand, resolution: [u32; 2]) -> Sight {
        let [eye, at] = [stand.eye, stand.at].map(Vec3::from);
        let [w, h] = resolution.map(|n| n as f32);
        let corner = w.hypot(h) / w.min(h);
        let cosine = match stand.projection {
            Projection::Perspective(fov) => Some((((0.5 * fov).to_radians().tan() * corner).atan() + 0.05).cos()),
            Projection::Parallel(_) => None,
        };
        Sight { eye, forward: (at - eye).normalize(), cosine }
    }

    fn sees(&self, at: Vec3, r: f32) -> bool {
        let way = at - self.eye;
        self.cosine.is_none_or(|cosine| way.dot(self.forward) > cosine * way.length() && r > Self::LEAST * way.length())
    }
}

/// The visible pebbles about a point of the ground; `view` is the width of the view at what the camera looks at, m.
fn scattered(about: [f32; 3], view: f32, sight: &Sight) -> Instances {
    let (mut position, mut orientation, mut scale) = (vec![], vec![], vec![]);
    let (mut ids, mut colors) = (vec![], vec![]);
    for (k, sort) in SORTS.iter().enumerate() {
        let cell = sort.cell * view;
        let [near, far] = sort.from.map(|r| r * view);
        let range = |middle: f32| ((middle - far) / cell).floor() as i64..=((middle + far) / cell).floor() as i64;
        for (i, j) in range(about[0]).flat_map(|i| range(about[1]).map(move |j| (i, j))) {
            let draw = Draw(i, j, k as u64);
            // They lie in patches of some squares.
            let patch = Draw(i.div_euclid(7), j.div_euclid(5), 100 + k as u64).number(0);
            if draw.number(0) > sort.share * (0.4 + 1.2 * patch) {
                continue;
            }
            let [x, y] = [(i as f32 + draw.number(1)) * cell, (j as f32 + draw.number(2)) * cell];
            let away = (x - about[0]).hypot(y - about[1]);
            // At the rim they are as small as nothing, so that none comes or goes at once where the camera moves.
            let rim = ((far - away) / (0.3 * far)).min((away - near) / (0.3 * near.max(1e-6 * far))).clamp(0.0, 1.0);
            // One in five is of quartz, which breaks into larger pieces.
            let is_pale = draw.number(11) < 0.2;
            let part = draw.number(3).powf(if is_pale { 1.5 } else { 3.0 });
            let r = rim * view * (sort.radius[0] + (sort.radius[1] - sort.radius[0]) * part);
            if r <= 0.0 || !sight.sees(Vec3::new(x, y, about[2]), r) {
                continue;
            }
            position.push([x, y, about[2] + (0.1 + 0.5 * draw.number(4)) * r]);
            scale.push([r; 3]);
            let q = Quat::from_euler(
                glam::EulerRot::ZYX,
                std::f32::consts::TAU * draw.number(5),
                3.1 * draw.number(6),
                std::f32::consts::TAU * draw.number(7),
            );
            orientation.push(q.to_array());
            ids.push((draw.bits(8) % 4096) as f32);
            let (tone, warm) =
                (if is_pale { 0.95 } else { 0.28 + 0.3 * draw.number(9) }, 0.93 + 0.12 * draw.number(10));
            colors.extend([tone * warm, tone * 0.94, tone * 0.88 / warm]);
        }
    }
    let params = vec![
        Param::floats("Cs", Class::Uniform, Type::Color, colors),
        Param::floats("id", Class::Uniform, Type::Float, ids),
    ];
    Instances { shape: InstanceShape::Sphere, position, orientation, scale, offset: vec![], params, moved: None }
}

/// Numbers that belong to a square.
struct Draw(i64, i64, u64);

impl Draw {
    /// The `n`th, as bits.
    fn bits(&self, n: u64) -> u64 {
        let mut h =
            (self.0 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (self.1 as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        h ^= (self.2 << 8 | n).wrapping_mul(0x1656_67b1_9e37_79f9);
        h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        h ^ h >> 31
    }

    /// The `n`th, from 0 to 1.
    fn number(&self, n: u64) -> f32 {
        (self.bits(n) >> 40) as f32 / (1u64 << 24) as f32
    }
}
