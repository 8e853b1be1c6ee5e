//! What shaders' kernels read of the scene: what stops light, and what closes the sky. The layout stands in `world.wgsl`, `rays.wgsl` and
//! `sky.wgsl`.

use crate::cpu::bvh::{Bvh, Occluder};
use crate::cpu::openness::Surroundings;
use crate::cpu::tree::Tree;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use crate::texture::TextureLevels;
use crate::texture::texels::{Levels, Texels, decoded};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use sl::wgsl::Query;
use std::collections::HashMap;

/// The queries that kernels may ask, and the text of their answers: where no maps are named other than shadow maps, and where some are.
pub const FUNCTIONS: [[(Query, &str); 4]; 2] = [
    functions(concat!(include_str!("shadow.wgsl"), "\n", include_str!("shadows_alone.wgsl"))),
    functions(concat!(include_str!("shadow.wgsl"), "\n", include_str!("maps.wgsl"))),
];

const fn functions(maps: &'static str) -> [(Query, &'static str); 4] {
    [
        (Query::Transmission, include_str!("transmission.wgsl")),
        (Query::Map, maps),
        (Query::Hit, include_str!("hit.wgsl")),
        (Query::Openness, include_str!("sky.wgsl")),
    ]
}

/// Those that ask what rays meet, besides lookups in shadow maps.
pub const OF_RAYS: [Query; 2] = [Query::Transmission, Query::Hit];

/// What these need, where nothing that casts shadows lets a part of the light through, and where something does.
pub const DECLARATIONS: [&str; 2] = [
    concat!(include_str!("world.wgsl"), "\n", include_str!("rays.wgsl"), "\n", include_str!("light.wgsl")),
    concat!(include_str!("world.wgsl"), "\n", include_str!("rays.wgsl"), "\n", include_str!("light_through.wgsl")),
];

/// What rays meet: undisplaced, and the triangles of what is displaced, each with how near its start a ray does not meet it.
pub struct Met<'a> {
    pub bvh: &'a Bvh,
    pub facets: Vec<(Item, [Vec3; 3], f32)>,
}

/// Bytes of a triangle and of its part of the tree.
pub const FACET_BYTES: usize = 96;

/// Rows of the head.
const HEAD: usize = 4;

/// The rows of a scene: what stops light, where shaders ask for that, and what closes the sky.
pub fn rows(
    scene: &Scene,
    rays: Option<Met<'_>>,
    sky: Option<&Surroundings>,
    maps: &[String],
    id: &(dyn Fn(Item) -> u32 + Sync),
) -> Result<Vec<[u32; 4]>, String> {
    let mut rows = vec![[0; 4]; HEAD];
    if let Some(rays) = rays {
        push_rays(&mut rows, scene, &rays, id);
    }
    if let Some(sky) = sky {
        push_sky(&mut rows, sky, id);
    }
    if !maps.is_empty() {
        push_maps(&mut rows, scene, maps)?;
    }
    Ok(rows)
}

/// Add the textures of names; the first number is that of no map.
fn push_maps(rows: &mut Vec<[u32; 4]>, scene: &Scene, names: &[String]) -> Result<(), String> {
    let first = rows.len();
    rows[3] = [first as u32, 1 + names.len() as u32, 0, 0];
    rows.resize(first + 1 + names.len(), [0; 4]);
    rows[3][2] = rows.len() as u32;
    rows.extend((0..64).map(|k| [0, 1, 2, 3].map(|i| decoded((4 * k + i) as f32 / 255.0).to_bits())));
    for (k, name) in names.iter().enumerate() {
        let added = scene.textures.visit(name, |textures, tangent| {
            let at = rows.len();
            rows[first + 1 + k] = [1 + (textures.len() > 1) as u32, at as u32, tangent.to_bits(), 0];
            rows.resize(at + textures.len().div_ceil(4), [0; 4]);
            textures.iter().enumerate().try_for_each(|(i, texture)| {
                rows[at + i / 4][i % 4] = rows.len() as u32;
                push_texture(rows, texture)
            })
        });
        if added == Some(None) {
            return Err(name.clone());
        }
    }
    Ok(())
}

/// Add a texture; none if its texels are not in memory.
fn push_texture(rows: &mut Vec<[u32; 4]>, texture: &TextureLevels<'_>) -> Option<()> {
    let Levels::Resident(levels) = texture.levels else { return None };
    let first = rows.len();
    rows.resize(first + 1 + levels.len(), [0; 4]);
    let mut kind = texture.wrap[0] | texture.wrap[1] << 2 | texture.channels << 8;
    for (k, (w, h, texels)) in levels.iter().enumerate() {
        rows[first + 1 + k] = [*w as u32, *h as u32, rows.len() as u32, 0];
        match texels {
            Texels::Bytes(all, encoded) => {
                kind |= if *encoded { 32 } else { 16 };
                let word = |four: &[[u8; 4]], i: usize| four.get(i).map_or(0, |texel| u32::from_le_bytes(*texel));
                rows.extend(all.chunks(4).map(|four| [0, 1, 2, 3].map(|i| word(four, i))));
            }
            Texels::Floats(all) => rows.extend(all.iter().map(|texel| texel.map(f32::to_bits))),
        }
    }
    let (w, h, _) = levels.first()?;
    rows[first] = [*w as u32, *h as u32, levels.len() as u32, kind];
    Some(())
}

fn bits(v: Vec4) -> [u32; 4] {
    v.to_array().map(f32::to_bits)
}

fn point(v: Vec3) -> [u32; 4] {
    bits(v.extend(0.0))
}

/// Rows that are worth a thread.
const LEAST: usize = 1024;

/// Add the nodes of a tree; the row of the first.
fn push_tree(rows: &mut Vec<[u32; 4]>, tree: &Tree) -> u32 {
    let first = rows.len();
    let nodes = tree.nodes();
    let next =
        walk(nodes.len(), |k| (nodes[k].max_count.w.to_bits() == 0).then(|| nodes[k].min_at.w.to_bits() as usize));
    rows.resize(first + 2 * nodes.len(), [0; 4]);
    let each = rows[first..].par_chunks_exact_mut(2).zip(nodes).zip(next).with_min_len(LEAST);
    each.for_each(|((rows, node), next)| {
        let ([x, y, z, at], [u, v, w, count]) = (bits(node.min_at), bits(node.max_count));
        rows.copy_from_slice(&[[x, y, z, next], [u, v, w, if count == 0 { 0 } else { at << 3 | count }]]);
    });
    first as u32
}

/// Of the nodes of a tree, each of which stands before its first child, the next that is not below each: `second` has the second child of
/// an inner node.
fn walk(n: usize, second: impl Fn(usize) -> Option<usize>) -> Vec<u32> {
    let mut next = vec![n as u32; n];
    for k in 0..n {
        if let Some(second) = second(k) {
            next[second] = next[k];
            next[k + 1] = second as u32;
        }
    }
    next
}

/// Add what stops light, with the tree of it.
fn push_rays(
    rows: &mut Vec<[u32; 4]>,
    scene: &Scene,
    Met { bvh, facets }: &Met<'_>,
    id: &(dyn Fn(Item) -> u32 + Sync),
) {
    if bvh.occluders().is_empty() && facets.is_empty() {
        return;
    }
    let items = || bvh.occluders().iter().map(|(item, _)| *item).chain(facets.iter().map(|(item, ..)| *item));
    let translucent = push_translucent(rows, scene, items().filter(|item| bvh.is_translucent(*item)));
    let named = |item: Item| {
        let row = if bvh.is_translucent(item) { translucent[&scene.whole_of(item)] } else { 0 };
        [id(item), row]
    };
    let push = |rows: &mut Vec<[u32; 4]>, tree: &Tree, n: usize, of: &(dyn Fn(usize) -> usize + Sync)| {
        rows[0] = [push_tree(rows, tree), 0, tree.nodes().len() as u32, 0];
        rows[0][1] = rows.len() as u32;
        let first = rows.len();
        rows.resize(first + 4 * n, [0; 4]);
        rows[first..].par_chunks_exact_mut(4).enumerate().with_min_len(LEAST).for_each(|(place, rows)| {
            let k = of(place);
            rows.copy_from_slice(&match bvh.occluders().get(k) {
                Some((item, occluder)) => occluder_rows(bvh, named(*item), occluder),
                None => facet_rows(named, &facets[k - bvh.occluders().len()]),
            });
        });
    };
    if facets.is_empty() {
        return push(rows, bvh.tree(), bvh.occluders().len(), &|place| place);
    }
    // One tree over both.
    let of_facet = |(_, [a, b, c], _): &(Item, [Vec3; 3], f32)| {
        let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
        let room = 1e-6 * low.abs().max(high.abs()).max_element();
        (low - room, high + room)
    };
    let mut bounds: Vec<(Vec3, Vec3)> = bvh.occluders().iter().map(|(_, occluder)| bvh.bound(occluder)).collect();
    bounds.extend(facets.iter().map(of_facet));
    let (tree, order) = Tree::new(bounds.into_par_iter());
    push(rows, &tree, order.len(), &|place| order[place] as usize);
}

/// Add what lets a part of the light through: its opacity and its own row, which is the same for all parts of a thing; the rows by things.
fn push_translucent(rows: &mut Vec<[u32; 4]>, scene: &Scene, items: impl Iterator<Item = Item>) -> HashMap<u32, u32> {
    let mut all = HashMap::new();
    for item in items {
        all.entry(scene.whole_of(item)).or_insert_with(|| {
            let [r, g, b] = scene.attributes(item).opacity.map(f32::to_bits);
            let row = rows.len() as u32;
            rows.push([r, g, b, row]);
            row
        });
    }
    all
}

/// The rows of a triangle of what is displaced.
fn facet_rows(named: impl Fn(Item) -> [u32; 2], (item, [a, b, c], room): &(Item, [Vec3; 3], f32)) -> [[u32; 4]; 4] {
    let [id, row] = named(*item);
    [[4, id, room.to_bits(), row], point(*a), point(*b), point(*c)]
}

fn occluder_rows(bvh: &Bvh, [id, row]: [u32; 2], occluder: &Occluder) -> [[u32; 4]; 4] {
    let none = [0; 4];
    match *occluder {
        Occluder::Sphere { center, radius } => [[0, id, 0, row], bits(center.extend(radius)), none, none],
        Occluder::Ellipsoid { inverse } => {
            let m = bvh.inverse(inverse);
            [[1, id, 0, row], bits(m.row(0)), bits(m.row(1)), bits(m.row(2))]
        }
        Occluder::Triangle { corners, room } => {
            let [a, b, c] = corners;
            let kind = if room.is_none() { 2 } else { 3 };
            [[kind, id, room.unwrap_or(0.0).to_bits(), row], point(a), point(b), point(c)]
        }
    }
}

fn push_sky(rows: &mut Vec<[u32; 4]>, sky: &Surroundings, id: &dyn Fn(Item) -> u32) {
    let spheres = &sky.spheres;
    if !spheres.tree.is_empty() {
        rows[1] = [push_tree(rows, &spheres.tree), 0, 0, spheres.tree.nodes().len() as u32];
        rows[1][1] = rows.len() as u32;
        for round in &spheres.rounds {
            rows.push([id(round.item), round.axes.unwrap_or(0), round.axes.is_some() as u32, round.color.0]);
            rows.push(bits(round.center.extend(round.radius)));
        }
        rows[1][2] = rows.len() as u32;
        rows.extend(spheres.axes.iter().flat_map(|axes| axes.map(point)));
    }
    let facets = &sky.facets;
    if !facets.nodes.is_empty() {
        rows[2] = [rows.len() as u32, 0, facets.nodes.len() as u32, 0];
        let nodes = &facets.nodes;
        let next = walk(nodes.len(), |k| (!nodes[k].leaf).then_some(nodes[k].next as usize));
        for (node, next) in nodes.iter().zip(next) {
            rows.push(bits(node.center.extend(node.radius)));
            rows.push(bits(node.normal.extend(node.area)));
            rows.push([next, if node.leaf { node.next } else { 0 }, node.leaf as u32, node.color.0]);
        }
        rows[2][1] = rows.len() as u32;
        for facet in &facets.facets {
            let [a, mut b, mut c, mut d] = facet.corners.map(point);
            (b[3], c[3], d[3]) = (facet.color.0, facet.whole, facet.off.to_bits());
            let size = facet.area.length().sqrt();
            rows.extend([[a[0], a[1], a[2], facet.closed as u32], b, c, d, bits(facet.area.extend(size))]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::openness::cones::cones;

    #[test]
    fn kernels_have_the_axes_of_the_cones() {
        let rows =
            include_str!("sky.wgsl").lines().filter_map(|line| line.strip_prefix("    vec3<f32>(")?.strip_suffix("),"));
        let axes: Vec<Vec<f32>> = rows.map(|row| row.split(", ").filter_map(|x| x.parse().ok()).collect()).collect();
        let own: Vec<Vec<f32>> = cones().iter().map(|axis| axis.to_array().to_vec()).collect();
        assert_eq!(axes, own);
    }

    #[test]
    fn a_walk_goes_on_behind_what_it_leaves_out() {
        // 0 has 1 and 4, 1 has 2 and 3, 4 has 5 and 6.
        let second = [Some(4), Some(3), None, None, Some(6), None, None];
        assert_eq!(walk(7, |k| second[k]), [7, 4, 3, 4, 7, 6, 7]);
    }
}
