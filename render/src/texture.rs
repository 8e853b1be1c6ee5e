//! Textures: images as mip-maps, looked up with a filter as wide as a micropolygon.

pub mod texels;

use sl::ir::Lookup;
use sl::machine::MapQuery;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use texels::{Cache, Levels, Texels, decoded};

/// An image and its reductions by halves; four channels.
pub struct Texture {
    levels: Levels,
    /// What lies beyond its edges: `black`, `clamp` or `periodic`, along s and t.
    wrap: [Wrap; 2],
    /// Channels of its file.
    channels: u8,
}

/// What lies beyond an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrap {
    /// Nothing.
    Black,
    /// The edge's own values.
    Clamp,
    /// The image again.
    Periodic,
}

impl Wrap {
    /// By its name.
    pub fn of_name(name: &str) -> Option<Wrap> {
        match name {
            "black" => Some(Wrap::Black),
            "clamp" => Some(Wrap::Clamp),
            "periodic" => Some(Wrap::Periodic),
            _ => None,
        }
    }
}

/// What `MakeTexture` and its kin make a texture of.
#[derive(Clone, PartialEq)]
pub enum Source {
    /// One image.
    Image(PathBuf, [Wrap; 2]),
    /// An image of all directions, by longitude and latitude.
    LatLong(PathBuf),
    /// Views along +x, −x, +y, −y, +z, −z, and their angle, degrees.
    CubeFaces([PathBuf; 6], f32),
}

/// What textures are made of, by their names.
pub type Made = HashMap<String, Source>;

/// A texture's levels, and what lies beyond its edges along s and t: 0 nothing, 1 the edge, 2 the image again.
pub struct TextureLevels<'a> {
    pub levels: &'a Levels,
    pub wrap: [u32; 2],
    /// Channels of its file.
    pub channels: u32,
}

/// A texture as it is looked up.
enum Map {
    Image(Texture),
    /// Six faces, and the tangent of half their angle.
    Cube(Box<[Texture; 6]>, f32),
}

/// The textures of a scene, read when they are first asked for.
#[derive(Default)]
pub struct Textures {
    /// Folders to look in.
    folders: Vec<PathBuf>,
    /// What `MakeTexture` and its kin named.
    made: Made,
    loaded: Mutex<HashMap<String, Result<Arc<Map>, String>>>,
    /// Those that graphics devices are given, in the order of their numbers, from 1.
    numbered: Mutex<Vec<String>>,
    /// Bytes that textures may take in memory.
    memory: usize,
    /// Whether colours of whole numbers are encoded for screens, if an option says.
    encoded: Option<bool>,
    cache: Arc<Cache>,
}

impl Map {
    /// Bytes that it takes in memory.
    fn bytes(&self) -> usize {
        match self {
            Map::Image(texture) => texture.levels.bytes(),
            Map::Cube(faces, _) => faces.iter().map(|f| f.levels.bytes()).sum(),
        }
    }
}

impl Source {
    /// The files of its images.
    fn paths(&self) -> &[PathBuf] {
        match self {
            Source::Image(path, _) | Source::LatLong(path) => std::slice::from_ref(path),
            Source::CubeFaces(paths, _) => paths,
        }
    }

    /// The first of its images that there is no file of.
    pub fn missing(&self, folders: &[PathBuf]) -> Option<&Path> {
        self.paths().iter().find(|path| find(path, folders).is_none()).map(PathBuf::as_path)
    }

    /// The first of its images whose file does not begin as one, and why.
    pub fn unreadable(&self, folders: &[PathBuf]) -> Option<(PathBuf, String)> {
        let found = self.paths().iter().filter_map(|path| find(path, folders));
        found.filter_map(|path| guard::check_image(&path).err().map(|why| (path, why))).next()
    }
}

/// Note the files of the texture of this name, if there is one.
pub fn note(name: &str, made: &Made, folders: &[PathBuf]) {
    let own = [PathBuf::from(name)];
    let paths = made.get(name).map_or(&own[..], Source::paths);
    paths.iter().filter_map(|path| find(path, folders)).for_each(|path| guard::note(&path));
}

/// The file of an image: in one of the folders, or where its path leads.
fn find(path: &Path, folders: &[PathBuf]) -> Option<PathBuf> {
    let mut places = folders.iter().map(|f| f.join(path)).chain([path.into()]);
    places.find(|place| {
        guard::look_for(place);
        place.is_file() && guard::permit(place).is_ok()
    })
}

impl Textures {
    /// Textures of files in folders.
    pub fn new(folders: Vec<PathBuf>, made: Made, memory: usize, encoded: Option<bool>) -> Textures {
        let cache = Arc::new(Cache::default());
        // A quarter is for the tiles of those that find no room.
        cache.limit(memory / 4);
        Textures { folders, made, loaded: Mutex::default(), numbered: Mutex::default(), memory, encoded, cache }
    }

    /// A texture by its name, or why there is none.
    fn get(&self, name: &str) -> Result<Arc<Map>, String> {
        let mut loaded = self.loaded.lock().unwrap_or_else(|e| e.into_inner());
        if let Some(known) = loaded.get(name) {
            return known.clone();
        }
        let taken = loaded.values().flatten().map(|map| map.bytes()).sum::<usize>();
        let room = std::cell::Cell::new((self.memory / 4 * 3).saturating_sub(taken));
        let read = |path: &PathBuf, wrap| {
            let found = find(path, &self.folders);
            let path = found.as_ref().unwrap_or(path);
            let encoded = self.encoded.unwrap_or_else(|| is_for_screens(path));
            let texture = Texture::read(path, wrap, encoded, room.get(), &self.cache)
                .map_err(|e| format!("`{}`: {e}", path.display()))?;
            room.set(room.get().saturating_sub(texture.levels.bytes()));
            Ok(texture)
        };
        let map: Result<Map, String> = match self.made.get(name) {
            Some(Source::Image(path, wrap)) => read(path, *wrap).map(Map::Image),
            Some(Source::LatLong(path)) => read(path, [Wrap::Periodic, Wrap::Clamp]).map(Map::Image),
            Some(Source::CubeFaces(paths, fov)) => {
                let faces: Result<Vec<_>, _> = paths.iter().map(|p| read(p, [Wrap::Clamp; 2])).collect();
                let tangent = (0.5 * fov.to_radians()).tan();
                faces.map(|f| Map::Cube(Box::new(f.try_into().unwrap_or_else(|_| unreachable!("six"))), tangent))
            }
            None => read(&PathBuf::from(name), [Wrap::Black; 2]).map(Map::Image),
        };
        let said = |message| format!("texture `{name}` cannot be read and is black: {message}");
        let map = map.map(Arc::new).map_err(said);
        loaded.insert(name.into(), map.clone());
        map
    }

    /// Width and height of a texture, or of a face of it, and how many channels it has, if it can be read.
    pub fn size(&self, name: &str) -> Option<([f32; 2], f32)> {
        let map = self.get(name).ok()?;
        let first = match &*map {
            Map::Image(image) => image,
            Map::Cube(faces, _) => &faces[0],
        };
        let (w, h) = first.levels.size(0);
        Some(([w as f32, h as f32], first.channels.into()))
    }

    /// Whether there are the files of a texture; nothing if there are and they cannot be read.
    pub fn exists(&self, name: &str) -> Option<bool> {
        let is_there = match self.made.get(name) {
            Some(source) => source.missing(&self.folders).is_none(),
            None => find(Path::new(name), &self.folders).is_some(),
        };
        if is_there { self.get(name).ok().map(|_| true) } else { Some(false) }
    }

    /// What a texture was made as: `texture` or `environment`.
    pub fn kind(&self, name: &str) -> &'static str {
        match self.made.get(name) {
            Some(Source::LatLong(_) | Source::CubeFaces(..)) => "environment",
            _ => "texture",
        }
    }

    /// The number of a texture on graphics devices, which it is given when it is first asked for.
    pub fn number(&self, name: &str) -> u32 {
        let mut all = self.numbered.lock().unwrap_or_else(|e| e.into_inner());
        let known = all.iter().position(|other| other == name);
        let index = known.unwrap_or_else(|| {
            all.push(name.into());
            all.len() - 1
        });
        index as u32 + 1
    }

    /// The textures that have numbers, in the order of these.
    pub fn numbered(&self) -> Vec<String> {
        self.numbered.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }

    /// Visit the images of a texture, one or six faces, and the tangent of half the angle of a face, if it can be read.
    pub fn visit<R>(&self, name: &str, visit: impl FnOnce(&[TextureLevels<'_>], f32) -> R) -> Option<R> {
        let map = self.get(name).ok()?;
        fn of(texture: &Texture) -> TextureLevels<'_> {
            TextureLevels {
                levels: &texture.levels,
                wrap: texture.wrap.map(|w| w as u32),
                channels: texture.channels.into(),
            }
        }
        Some(match &*map {
            Map::Image(texture) => visit(&[of(texture)], 0.0),
            Map::Cube(faces, tangent) => visit(&faces.each_ref().map(of), *tangent),
        })
    }

    /// Why a map is black, if it cannot be read.
    pub fn fault(&self, name: &str) -> Option<String> {
        // Shaders whose map is optional ask for none.
        if name.is_empty() { None } else { self.get(name).err() }
    }

    /// Four channels of a map at a place; of one that cannot be read they are 0.
    pub fn look_up(&self, q: &MapQuery) -> [f32; 4] {
        // Shaders whose map is optional ask for none.
        if q.name.is_empty() {
            return [0.0; 4];
        }
        let Ok(map) = self.get(q.name) else { return [0.0; 4] };
        let (texture, at, change) = match (&*map, q.how) {
            (Map::Cube(faces, tangent), _) => {
                let (face, here) = cube_place(q.at, *tangent);
                let change = q.change.map(|c| {
                    let next = on_face(face, [0, 1, 2].map(|k| q.at[k] + c[k]), *tangent);
                    [next[0] - here[0], next[1] - here[1]]
                });
                (&faces[face], here, change)
            }
            (Map::Image(texture), Lookup::Environment) => {
                // A map of longitude and latitude: z is up.
                let place = |d: [f32; 3]| {
                    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt().max(1e-20);
                    let s = d[1].atan2(d[0]) / std::f32::consts::TAU;
                    [s.rem_euclid(1.0), (d[2] / length).clamp(-1.0, 1.0).acos() / std::f32::consts::PI]
                };
                let here = place(q.at);
                let change = q.change.map(|c| {
                    let next = place([0, 1, 2].map(|k| q.at[k] + c[k]));
                    let d = (next[0] - here[0] + 0.5).rem_euclid(1.0) - 0.5;
                    [d, next[1] - here[1]]
                });
                (texture, here, change)
            }
            (Map::Image(texture), _) => (texture, [q.at[0], q.at[1]], q.change.map(|c| [c[0], c[1]])),
        };
        let mut value = texture.filtered(at, change.map(|c| c.map(|d| d * q.width)), q.blur);
        if q.channel > 0 {
            value = [0, 1, 2, 3].map(|k| texture.channel(&value, k + q.channel).unwrap_or(q.fill));
        }
        value
    }
}

/// Whether an image says that its colours are encoded for screens: a PNG file by a chunk `sRGB`, or if it has none, by `gAMA` of 1/2.2
/// (PNG, third edition, 11.3.2.5: `sRGB` goes before `gAMA`, in whatever order they stand).
fn is_for_screens(path: &Path) -> bool {
    use std::io::Read;
    /// Bytes in which the chunks before the image stand.
    const HEAD: u64 = 1 << 16;
    let mut head = vec![];
    let Ok(file) = guard::open(path) else { return false };
    if file.take(HEAD).read_to_end(&mut head).is_err() || !head.starts_with(b"\x89PNG") {
        return false;
    }
    let mut rest = &head[8.min(head.len())..];
    let mut by_gamma = false;
    while let [a, b, c, d, kind @ ..] = rest {
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        let data = kind.get(4..).unwrap_or(&[]);
        match kind.get(..4) {
            Some(b"sRGB") => return true,
            Some(b"gAMA") if data.len() >= 4 => {
                by_gamma = u32::from_be_bytes([data[0], data[1], data[2], data[3]]).abs_diff(45_455) < 500;
            }
            Some(b"IDAT") | None => break,
            _ => {}
        }
        rest = data.get(length + 4..).unwrap_or(&[]);
    }
    by_gamma
}

/// The most places along the longer axis of a filter.
const MAX_TAPS: f32 = 16.0;

/// An ellipse: the direction of its longer axis, and the lengths of both.
struct Ellipse {
    axis: [f32; 2],
    long: f32,
    short: f32,
}

impl Ellipse {
    /// The one that two vectors span: the square roots of the eigenvalues of the sum of their dyads.
    fn of([[ax, ay], [bx, by]]: [[f32; 2]; 2]) -> Ellipse {
        let (xx, yy, xy) = (ax * ax + bx * bx, ay * ay + by * by, ax * ay + bx * by);
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let off = (half * half + xy * xy).sqrt();
        let long = (mean + off).sqrt();
        // What the vectors span keeps its area.
        let short = if long > 0.0 { (ax * by - ay * bx).abs() / long } else { 0.0 };
        let angle = 0.5 * xy.atan2(half);
        Ellipse { axis: if off > 0.0 { [angle.cos(), angle.sin()] } else { [1.0, 0.0] }, long, short }
    }
}

/// The face of a cube that a direction meets, and where.
fn cube_place(d: [f32; 3], tangent: f32) -> (usize, [f32; 2]) {
    let size = d.map(f32::abs);
    let axis = (0..3).fold(0, |a, k| if size[k] > size[a] { k } else { a });
    let face = 2 * axis + (d[axis] < 0.0) as usize;
    (face, on_face(face, d, tangent))
}

/// Where a direction meets the image of a face: each is seen from within, y up on the four sides, in the left-handed space of
/// the interface; the face above has +z below, the one beneath has +z on top.
fn on_face(face: usize, [x, y, z]: [f32; 3], tangent: f32) -> [f32; 2] {
    let (right, up, ahead) = match face {
        0 => (-z, y, x),
        1 => (z, y, -x),
        2 => (x, -z, y),
        3 => (x, z, -y),
        4 => (x, y, z),
        _ => (-x, y, -z),
    };
    let scale = 0.5 / (ahead.abs().max(1e-20) * tangent);
    [0.5 + right * scale, 0.5 - up * scale]
}

impl Texture {
    /// Read an image.
    fn read(
        path: &std::path::Path,
        wrap: [Wrap; 2],
        encoded: bool,
        room: usize,
        cache: &Arc<Cache>,
    ) -> Result<Texture, String> {
        let no_room = |e: std::io::Error| format!("no room for its tiles: {e}");
        let image = match guard::read_image(path) {
            Ok(image) => image,
            // Depths and heights are of one channel, which may be of floats.
            Err(why) => {
                let Some(gray) = guard::read_gray(path)? else { return Err(why) };
                let texels = Texels::Floats(gray.values.iter().map(|x| [*x, *x, *x, 1.0]).collect());
                let levels = Levels::new(gray.width, gray.height, texels, room, cache).map_err(no_room)?;
                return Ok(Texture { levels, wrap, channels: 1 });
            }
        };
        let (w, h) = (image.width() as usize, image.height() as usize);
        let channels = image.color().channel_count();
        use image::DynamicImage::{ImageLuma8, ImageLumaA8, ImageRgb8, ImageRgb32F, ImageRgba8, ImageRgba32F};
        let linear = matches!(image, ImageRgb32F(_) | ImageRgba32F(_));
        let texels = match image {
            ImageLuma8(_) | ImageLumaA8(_) | ImageRgb8(_) | ImageRgba8(_) => {
                Texels::Bytes(image.into_rgba8().pixels().map(|p| p.0).collect(), encoded)
            }
            _ => {
                let own = |[r, g, b, a]: [f32; 4]| {
                    if linear || !encoded { [r, g, b, a] } else { [decoded(r), decoded(g), decoded(b), a] }
                };
                Texels::Floats(image.into_rgba32f().pixels().map(|p| own(p.0)).collect())
            }
        };
        let levels = Levels::new(w, h, texels, room, cache).map_err(no_room)?;
        Ok(Texture { levels, wrap, channels })
    }

    /// A channel of its file, of four that are red, green, blue and coverage.
    fn channel(&self, [r, g, b, a]: &[f32; 4], k: usize) -> Option<f32> {
        let all = if self.channels == 2 { [*r, *a, 0.0, 0.0] } else { [*r, *g, *b, *a] };
        all[..usize::from(self.channels).min(4)].get(k).copied()
    }

    /// The mean about a place over the ellipse that the change to the next points spans, wider by a blur, all as parts of the image:
    /// between two levels that resolve its shorter axis, bilinear in each, and several along its longer one.
    fn filtered(&self, at: [f32; 2], change: [[f32; 2]; 2], blur: [f32; 2]) -> [f32; 4] {
        let (w, h) = self.levels.size(0);
        let (w, h) = (w as f32, h as f32);
        let mut change = change.map(|[s, t]| [s * w, t * h]);
        let even = blur[0].min(blur[1]).max(0.0);
        let rest = [2.0 * w * (blur[0] - even), 2.0 * h * (blur[1] - even)];
        if rest != [0.0; 2] {
            // A blur along one axis alone: so much wider is the ellipse along it.
            let grown = |axis: usize| (change[0][axis].hypot(change[1][axis]) + rest[axis]).max(0.0);
            change = [[grown(0), 0.0], [0.0, grown(1)]];
        }
        let Ellipse { axis, long, short } = Ellipse::of(change);
        let blurred = |length: f32, most: f32| (length + 2.0 * even * (w * h).sqrt()).clamp(1.0, most.max(1.0));
        // A map may be met many times along the ellipse.
        let (long, short) = (blurred(long, MAX_TAPS * w.max(h)), blurred(short, w.max(h)));
        let ratio = (long / short).min(MAX_TAPS);
        let taps = ratio.ceil() as usize;
        let level = (long / ratio).log2().clamp(0.0, (self.levels.len() - 1) as f32);
        let (lower, t) = (level.floor() as usize, level.fract());
        let upper = (lower + 1).min(self.levels.len() - 1);
        let mut sum = [0.0; 4];
        for k in 0..taps {
            let along = long * ((k as f32 + 0.5) / taps as f32 - 0.5);
            let place = [at[0] + axis[0] * along / w, at[1] + axis[1] * along / h];
            let a = self.bilinear(lower, place);
            let b = if t == 0.0 || upper == lower { a } else { self.bilinear(upper, place) };
            (0..4).for_each(|c| sum[c] += (a[c] * (1.0 - t) + b[c] * t) / taps as f32);
        }
        sum
    }

    fn bilinear(&self, level: usize, at: [f32; 2]) -> [f32; 4] {
        let (w, h) = self.levels.size(level);
        let (x, y) = (at[0] * w as f32 - 0.5, at[1] * h as f32 - 0.5);
        if !(x.is_finite() && y.is_finite()) {
            return [0.0; 4];
        }
        let (i, j) = (x.floor(), y.floor());
        let wrapped = |k: f32, n: usize, wrap: Wrap| match wrap {
            Wrap::Periodic if k >= 0.0 && k < n as f32 => Some(k as usize),
            Wrap::Periodic => Some((k as i64).rem_euclid(n as i64) as usize),
            Wrap::Clamp => Some(k.clamp(0.0, n as f32 - 1.0) as usize),
            // Half a texel beyond the edge still belongs to it.
            Wrap::Black if k >= -1.0 && k <= n as f32 => Some(k.clamp(0.0, n as f32 - 1.0) as usize),
            Wrap::Black => None,
        };
        let columns = [i, i + 1.0].map(|i| wrapped(i, w, self.wrap[0]));
        let rows = [j, j + 1.0].map(|j| wrapped(j, h, self.wrap[1]));
        let texel = |i: usize, j: usize| match (columns[i], rows[j]) {
            (Some(i), Some(j)) => self.levels.at(level, i, j),
            _ => [0.0; 4],
        };
        let (s, t) = (x - i, y - j);
        let (a, b, c, d) = (texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1));
        [0, 1, 2, 3].map(|k| (a[k] * (1.0 - s) + b[k] * s) * (1.0 - t) + (c[k] * (1.0 - s) + d[k] * s) * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_follows_the_ellipse_that_it_looks_through() {
        // Stripes along the diagonal, 8 texels from one to the next: a long way along one stays in it, one across sees their mean.
        let n = 64;
        let stripe = |k: usize| if (k % n + n - k / n) % 8 < 4 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
        let texels = Texels::Floats((0..n * n).map(stripe).collect());
        let levels = Levels::new(n, n, texels, usize::MAX, &Arc::new(Cache::default())).unwrap();
        let texture = Texture { levels, wrap: [Wrap::Periodic; 2], channels: 4 };
        let (long, short) = (12.0 / n as f32, 0.2 / n as f32);
        let (along, across) = ([long, long], [short, -short]);
        let at = [34.0 / n as f32, 32.5 / n as f32];
        let inside = texture.filtered(at, [along, across], [0.0; 2])[0];
        assert!(inside > 0.9, "{inside}");
        let mean = texture.filtered(at, [[long, -long], [short, short]], [0.0; 2])[0];
        assert!((mean - 0.5).abs() < 0.15, "{mean}");
        let ellipse = Ellipse::of([[3.0, 0.0], [0.0, 7.0]]);
        assert!((ellipse.long - 7.0).abs() < 1e-5 && (ellipse.short - 3.0).abs() < 1e-5 && ellipse.axis[1] > 0.999);
    }

    #[test]
    fn faces_of_a_cube_meet_at_their_edges() {
        // From either side of an edge the places on both faces are the same point of the cube's surface.
        let back = |face: usize, [s, t]: [f32; 2]| {
            let (r, u) = (2.0 * s - 1.0, 1.0 - 2.0 * t);
            match face {
                0 => [1.0, u, -r],
                1 => [-1.0, u, r],
                2 => [r, 1.0, -u],
                3 => [r, -1.0, u],
                4 => [r, u, 1.0],
                _ => [-r, u, -1.0],
            }
        };
        for k in 0..500 {
            let d = [0.37, 1.13, 2.71].map(|a| (a * (k as f32 + 0.5)).sin());
            let (face, place) = cube_place(d, 1.0);
            let most = d.iter().fold(0.0f32, |m, x| m.max(x.abs()));
            let there = back(face, place);
            assert!(place.iter().all(|p| (-1e-6..=1.000_001).contains(p)), "{d:?} {place:?}");
            (0..3).for_each(|c| assert!((there[c] - d[c] / most).abs() < 1e-5, "{d:?} on {face}: {there:?}"));
        }
    }
}
