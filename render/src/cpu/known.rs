//! Where displaced grids have been found on the raster: a bucket that they do not reach need not displace them again to know.
//!
//! How far a surface may be displaced is known before, how far it is only after its shader has run. A bound that is wide leads all buckets
//! around to the same grids.

use crate::gprim::grid::Grid;
use crate::scene::camera::RasterBound;
use crate::scene::source::Item;
use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};
use std::sync::{Mutex, PoisonError};

/// Tables, so that threads seldom wait for each other.
const TABLES: usize = 64;

/// The most grids of a table: some tens of megabytes in all.
const MOST: usize = 1 << 14;

/// A grid: item, patch, and the ranges of its parameters to the bit; or face and ranges of a sphere's lattice.
type Key = ([u32; 3], [u32; 4]);

/// What has been found.
pub struct Known {
    hasher: RandomState,
    tables: Vec<Mutex<HashMap<Key, Option<RasterBound>>>>,
}

impl Default for Known {
    fn default() -> Known {
        Known { hasher: RandomState::new(), tables: (0..TABLES).map(|_| Mutex::default()).collect() }
    }
}

impl Known {
    fn key(item: Item, grid: &Grid) -> Option<Key> {
        if let Some([face, range @ ..]) = grid.tile {
            return Some(([item.source, item.index, face], range));
        }
        let origin = grid.origin?;
        let range = [origin.u[0], origin.u[1], origin.v[0], origin.v[1]];
        Some(([item.source, item.index, origin.patch], range.map(f32::to_bits)))
    }

    fn table(&self, key: &Key) -> &Mutex<HashMap<Key, Option<RasterBound>>> {
        &self.tables[self.hasher.hash_one(key) as usize % TABLES]
    }

    /// The bound of a grid as displaced, if it is known; none in it if nothing of the grid is in front of the camera.
    pub fn bound(&self, item: Item, grid: &Grid) -> Option<Option<RasterBound>> {
        let key = Known::key(item, grid)?;
        self.table(&key).lock().unwrap_or_else(PoisonError::into_inner).get(&key).copied()
    }

    /// Note the bound of a grid as displaced.
    pub fn note(&self, item: Item, grid: &Grid, bound: Option<RasterBound>) {
        let Some(key) = Known::key(item, grid) else { return };
        let mut table = self.table(&key).lock().unwrap_or_else(PoisonError::into_inner);
        if table.len() < MOST {
            table.insert(key, bound);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gprim::grid::Origin;
    use glam::Vec2;

    #[test]
    fn grids_of_patches_and_of_spheres_are_known_again() {
        let known = Known::default();
        let item = Item { source: 1, index: 2 };
        let origin = |u: f32| Some(Origin { patch: 0, u: [u, 1.0], v: [0.0, 1.0] });
        let tile = |i: u32| Some([5, i, i + 1, 0, 8]);
        let of = |origin, tile| Grid { origin, tile, ..Grid::default() };
        let all = [of(origin(0.0), None), of(origin(0.5), None), of(None, tile(0)), of(None, tile(1))];
        for (k, grid) in all.iter().enumerate() {
            assert!(known.bound(item, grid).is_none());
            let (min, max) = (Vec2::splat(k as f32), Vec2::splat(9.0));
            known.note(item, grid, Some(RasterBound { min, max, z: 1.0 }));
        }
        for (k, grid) in all.iter().enumerate() {
            assert_eq!(known.bound(item, grid).unwrap().unwrap().min.x, k as f32);
        }
        assert!(known.bound(item, &Grid::default()).is_none());
    }
}
