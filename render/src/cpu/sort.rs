//! Sorting of items to the buckets that they may be visible in.

use crate::cpu::frame::Frame;
use crate::gprim::bound::raster_bound;
use crate::scene::motion::instants;
use crate::scene::source::Item;
use rayon::prelude::*;
use std::collections::HashMap;

/// For each bucket of a size, pixels, its items with their least depth, nearest first.
pub fn items_of_buckets(frame: &Frame<'_>, size: [usize; 2], [columns, rows]: [usize; 2]) -> Vec<Vec<(f32, Item)>> {
    let [width, height] = size.map(|n| n as f32);
    let margin = frame.margin().map(|n| n as f32);
    let items: Vec<Item> =
        frame.scene.items().filter(|i| frame.scene.sources[i.source as usize].attributes.visible).collect();
    let bounds: Vec<_> = items
        .par_iter()
        .with_min_len(1024)
        .map_init(Vec::new, |moments, item| {
            let view = frame.scene.view(*item);
            instants(&frame.camera, &view, moments);
            raster_bound(&frame.camera, &view, moments)
        })
        .collect();
    // The primitives of a solid come together, when the first of them does.
    let root = |item: &Item| frame.scene.root(*item);
    let mut first: HashMap<u32, f32> = HashMap::new();
    for (item, bound) in items.iter().zip(&bounds) {
        if let (Some(root), Some(bound)) = (root(item), bound) {
            let z = first.entry(root).or_insert(bound.z);
            *z = z.min(bound.z);
        }
    }
    let mut lists: Vec<Vec<(f32, Item)>> = vec![Vec::new(); columns * rows];
    for (item, bound) in items.iter().zip(bounds) {
        let Some(bound) = bound else { continue };
        let z = root(item).and_then(|root| first.get(&root).copied()).unwrap_or(bound.z);
        let range = |[lo, hi]: [f32; 2], margin: f32, size: f32, n: usize| {
            let first = ((lo - margin) / size).floor().max(0.0);
            let last = ((hi + margin) / size).floor().min(n as f32 - 1.0);
            (first <= last).then_some(first as usize..last as usize + 1)
        };
        let across = range([bound.min.x, bound.max.x], margin[0], width, columns);
        let down = range([bound.min.y, bound.max.y], margin[1], height, rows);
        if let (Some(across), Some(down)) = (across, down) {
            for row in down {
                for column in across.clone() {
                    lists[row * columns + column].push((z, *item));
                }
            }
        }
    }
    lists.par_iter_mut().for_each(|list| {
        // No two are equal.
        list.par_sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then((a.1.source, a.1.index).cmp(&(b.1.source, b.1.index)))
        });
    });
    lists
}
