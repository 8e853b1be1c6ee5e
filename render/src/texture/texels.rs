//! Where a texture's texels are: in memory, or where textures would take more than they may, in a file of tiles that is read as it
//! is needed, with the tiles used last kept.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::sync::{Arc, Mutex};

/// Texels along a tile's edge.
const TILE: usize = 32;

/// What textures may take in memory if no option says, bytes.
pub const MEMORY: usize = 1 << 30;

/// The minimum that is kept of textures in files, bytes.
const MIN_BYTES: usize = 1 << 20;

/// Texels in rows: those of images of whole bytes stay such.
pub enum Texels {
    /// Red, green, blue, coverage; and whether the colours are encoded for screens (IEC 61966-2-1), else linear.
    Bytes(Vec<[u8; 4]>, bool),
    /// The same, linear light.
    Floats(Vec<[f32; 4]>),
}

/// Linear light of a byte that is encoded for screens.
fn linear() -> &'static [f32; 256] {
    static TABLE: std::sync::OnceLock<[f32; 256]> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|i| decoded(i as f32 / 255.0)))
}

/// Linear light of a number that is encoded for screens.
pub fn decoded(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn encoded(x: f32) -> f32 {
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Texels::Bytes(v, _) => v.len(),
            Texels::Floats(v) => v.len(),
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.len() * self.texel()
    }

    /// Bytes of one.
    fn texel(&self) -> usize {
        match self {
            Texels::Bytes(..) => 4,
            Texels::Floats(_) => 16,
        }
    }

    /// One, linear.
    #[inline]
    pub fn at(&self, i: usize) -> [f32; 4] {
        match self {
            Texels::Bytes(v, false) => v[i].map(|x| x as f32 / 255.0),
            Texels::Bytes(v, true) => {
                let ([r, g, b, a], table) = (v[i], linear());
                [table[r as usize], table[g as usize], table[b as usize], a as f32 / 255.0]
            }
            Texels::Floats(v) => v[i],
        }
    }

    /// As many of the same kind, from linear ones.
    fn of(&self, values: impl Iterator<Item = [f32; 4]>) -> Texels {
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        match self {
            Texels::Bytes(_, false) => Texels::Bytes(values.map(|v| v.map(byte)).collect(), false),
            Texels::Bytes(_, true) => Texels::Bytes(
                values.map(|[r, g, b, a]| [byte(encoded(r)), byte(encoded(g)), byte(encoded(b)), byte(a)]).collect(),
                true,
            ),
            Texels::Floats(_) => Texels::Floats(values.collect()),
        }
    }

    /// The image at half its size: means of four.
    pub fn halved(&self, w: usize, h: usize) -> (usize, usize, Texels) {
        let (nw, nh) = (w.div_ceil(2), h.div_ceil(2));
        let mean = |k: usize| {
            let at = |di: usize, dj: usize| {
                let (i, j) = (2 * (k % nw) + di, 2 * (k / nw) + dj);
                self.at(j.min(h - 1) * w + i.min(w - 1))
            };
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            [0, 1, 2, 3].map(|c| four.iter().map(|t| t[c]).sum::<f32>() * 0.25)
        };
        (nw, nh, self.of((0..nw * nh).map(mean)))
    }

    /// A tile of an image of size `w` × `h`, as bytes; what lies beyond the image is 0.
    fn tile_bytes(&self, w: usize, h: usize, tile: usize, out: &mut Vec<u8>) {
        let (x0, y0) = (tile % w.div_ceil(TILE) * TILE, tile / w.div_ceil(TILE) * TILE);
        for (y, x) in (y0..y0 + TILE).flat_map(|y| (x0..x0 + TILE).map(move |x| (y, x))) {
            let i = (x < w && y < h).then_some(y * w + x);
            match self {
                Texels::Bytes(v, _) => out.extend(i.map_or([0; 4], |i| v[i])),
                Texels::Floats(v) => out.extend(i.map_or([0.0; 4], |i| v[i]).iter().flat_map(|x| x.to_ne_bytes())),
            }
        }
    }

    /// A tile of bytes as they came from [`Texels::tile_bytes`].
    fn of_bytes(bytes: &[u8], floats: bool, encoded: bool) -> Texels {
        let float = |b: &[u8]| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
        if floats {
            Texels::Floats(bytes.chunks_exact(16).map(|b| [0, 4, 8, 12].map(|i| float(&b[i..i + 4]))).collect())
        } else {
            Texels::Bytes(bytes.chunks_exact(4).map(|b| [b[0], b[1], b[2], b[3]]).collect(), encoded)
        }
    }
}

/// An image and its reductions by halves.
pub enum Levels {
    /// In memory: width, height and texels of each.
    Resident(Vec<(usize, usize, Texels)>),
    /// In a file.
    Paged(Pages),
}

impl Levels {
    /// All reductions of an image; they go to a file if `room` is less than they take.
    pub fn new(w: usize, h: usize, first: Texels, room: usize, cache: &Arc<Cache>) -> std::io::Result<Levels> {
        let resident = first.bytes() / 3 * 4 <= room;
        let mut pages = if resident { None } else { Some(Pages::new(&first, cache)?) };
        let mut levels = vec![];
        let (mut w, mut h, mut texels) = (w, h, first);
        loop {
            let next = (w > 1 || h > 1).then(|| texels.halved(w, h));
            match &mut pages {
                Some(pages) => pages.push(w, h, &texels)?,
                None => levels.push((w, h, texels)),
            }
            match next {
                Some(smaller) => (w, h, texels) = smaller,
                None => return Ok(pages.map_or(Levels::Resident(levels), Levels::Paged)),
            }
        }
    }

    /// Bytes in memory, those of kept tiles aside.
    pub fn bytes(&self) -> usize {
        match self {
            Levels::Resident(levels) => levels.iter().map(|(.., texels)| texels.bytes()).sum(),
            Levels::Paged(_) => 0,
        }
    }

    /// Count of levels.
    pub fn len(&self) -> usize {
        match self {
            Levels::Resident(levels) => levels.len(),
            Levels::Paged(pages) => pages.levels.len(),
        }
    }

    /// Width and height of one.
    pub fn size(&self, level: usize) -> (usize, usize) {
        match self {
            Levels::Resident(levels) => (levels[level].0, levels[level].1),
            Levels::Paged(pages) => (pages.levels[level].0, pages.levels[level].1),
        }
    }

    /// A texel of one.
    #[inline]
    pub fn at(&self, level: usize, i: usize, j: usize) -> [f32; 4] {
        match self {
            Levels::Resident(levels) => levels[level].2.at(j * levels[level].0 + i),
            Levels::Paged(pages) => pages.at(level, i, j),
        }
    }
}

/// Tiles in a file without a name, which goes away with the program.
pub struct Pages {
    file: Mutex<File>,
    /// Width, height and first tile of each level.
    levels: Vec<(usize, usize, usize)>,
    tiles: usize,
    floats: bool,
    /// Bytes are encoded for screens.
    encoded: bool,
    number: u64,
    cache: Arc<Cache>,
}

impl Pages {
    fn new(texels: &Texels, cache: &Arc<Cache>) -> std::io::Result<Pages> {
        static NUMBER: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let file = Mutex::new(tempfile::tempfile()?);
        let (floats, encoded) = match texels {
            Texels::Floats(_) => (true, false),
            Texels::Bytes(_, encoded) => (false, *encoded),
        };
        Ok(Pages { file, levels: vec![], tiles: 0, floats, encoded, number, cache: cache.clone() })
    }

    fn tile_bytes(&self) -> usize {
        TILE * TILE * if self.floats { 16 } else { 4 }
    }

    fn push(&mut self, w: usize, h: usize, texels: &Texels) -> std::io::Result<()> {
        use std::io::Write;
        let tiles = w.div_ceil(TILE) * h.div_ceil(TILE);
        let mut bytes = Vec::with_capacity(self.tile_bytes());
        let file = self.file.get_mut().unwrap_or_else(|e| e.into_inner());
        for tile in 0..tiles {
            bytes.clear();
            texels.tile_bytes(w, h, tile, &mut bytes);
            file.write_all(&bytes)?;
        }
        self.levels.push((w, h, self.tiles));
        self.tiles += tiles;
        Ok(())
    }

    fn at(&self, level: usize, i: usize, j: usize) -> [f32; 4] {
        let (w, _, first) = self.levels[level];
        let tile = first + j / TILE * w.div_ceil(TILE) + i / TILE;
        let texels = self.cache.get((self.number, tile), || self.read(tile));
        texels.at(j % TILE * TILE + i % TILE)
    }

    /// A tile from the file; black if it can no longer be read.
    fn read(&self, tile: usize) -> Texels {
        use std::io::{Read, Seek, SeekFrom};
        let mut bytes = vec![0; self.tile_bytes()];
        let mut file = self.file.lock().unwrap_or_else(|e| e.into_inner());
        let place = SeekFrom::Start((tile * self.tile_bytes()) as u64);
        if file.seek(place).and_then(|_| file.read_exact(&mut bytes)).is_err() {
            bytes.fill(0);
        }
        Texels::of_bytes(&bytes, self.floats, self.encoded)
    }
}

/// A tile by its texture and its index there.
type Name = (u64, usize);

/// Tiles that were used last, of all textures that are in files.
#[derive(Default)]
pub struct Cache {
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    tiles: HashMap<Name, (Arc<Texels>, bool)>,
    /// In the order in which they came.
    order: VecDeque<Name>,
    bytes: usize,
    max_bytes: usize,
}

thread_local! {
    /// The tiles that this thread used last.
    static RECENT: std::cell::RefCell<VecDeque<(Name, Arc<Texels>)>> = const { std::cell::RefCell::new(VecDeque::new()) };
}

impl Cache {
    /// Keep at most `max_bytes`.
    pub fn limit(&self, max_bytes: usize) {
        self.kept.lock().unwrap_or_else(|e| e.into_inner()).max_bytes = max_bytes.max(MIN_BYTES);
    }

    fn get(&self, name: Name, read: impl FnOnce() -> Texels) -> Arc<Texels> {
        let recent = RECENT.with_borrow(|r| r.iter().find(|(n, _)| *n == name).map(|(_, t)| t.clone()));
        if let Some(tile) = recent {
            return tile;
        }
        let mut kept = self.kept.lock().unwrap_or_else(|e| e.into_inner());
        let found = kept.tiles.get_mut(&name).map(|(tile, used)| {
            *used = true;
            tile.clone()
        });
        let tile = match found {
            Some(tile) => tile,
            None => {
                drop(kept);
                let tile = Arc::new(read());
                kept = self.kept.lock().unwrap_or_else(|e| e.into_inner());
                kept.keep(name, &tile);
                tile
            }
        };
        drop(kept);
        RECENT.with_borrow_mut(|r| {
            r.push_front((name, tile.clone()));
            r.truncate(4);
        });
        tile
    }
}

impl Kept {
    /// Keep a tile, and evict those that came first and were not used since.
    fn keep(&mut self, name: Name, tile: &Arc<Texels>) {
        if self.tiles.insert(name, (tile.clone(), false)).is_some() {
            return;
        }
        self.order.push_back(name);
        self.bytes += tile.bytes();
        while self.bytes > self.max_bytes {
            let Some(first) = self.order.pop_front() else { break };
            let Some((old, used)) = self.tiles.get_mut(&first) else { continue };
            if std::mem::take(used) && first != name {
                self.order.push_back(first);
                continue;
            }
            self.bytes -= old.bytes();
            self.tiles.remove(&first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_in_files_are_those_in_memory_and_take_no_more_than_they_may() {
        let (w, h) = (333, 201);
        let noise = |k: usize| (k as u32).wrapping_mul(0x9e37_79b9) >> 8;
        let all = || (0..w * h).map(|k| [0, 7, 11, 17].map(|s| (noise(k) >> s) as u8)).collect();
        let (bytes, linear) = (|| Texels::Bytes(all(), true), || Texels::Bytes(all(), false));
        let floats = || Texels::Floats((0..w * h).map(|k| [0, 1, 2, 3].map(|s| noise(4 * k + s) as f32)).collect());
        for make in [&bytes as &dyn Fn() -> Texels, &linear, &floats] {
            let cache = Arc::new(Cache::default());
            cache.limit(0);
            let resident = Levels::new(w, h, make(), usize::MAX, &cache).unwrap();
            let paged = Levels::new(w, h, make(), 0, &cache).unwrap();
            assert!(matches!(paged, Levels::Paged(_)) && paged.bytes() == 0 && resident.bytes() > 300_000);
            assert_eq!((paged.len(), resident.len()), (10, 10));
            for k in 0..20_000 {
                let level = k % 10;
                let (w, h) = resident.size(level);
                assert_eq!(paged.size(level), (w, h));
                let (i, j) = (noise(k) as usize % w, noise(k + 77) as usize % h);
                assert_eq!(paged.at(level, i, j), resident.at(level, i, j), "{level} {i} {j}");
                assert!(cache.kept.lock().unwrap().bytes <= MIN_BYTES);
            }
            assert_eq!(paged.at(9, 0, 0), resident.at(9, 0, 0));
        }
    }
}
