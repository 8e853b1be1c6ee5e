//! Displays (RISpec 4.1.2) and their layers: colour, coverage, depth and arbitrary output variables, all rendered in one pass.

use sl::ir::Kind;
use std::collections::HashMap;

/// An arbitrary output variable (AOV): a value of surfaces, other than colour and coverage, that goes to a display.
///
/// It is named after a shading variable (`P`, `N`, `Ng`, `I`, `u`, `v`, `s`, `t`, `Cs`, `Os`, `Ci`, `Oi`; points and directions in
/// world space), an output parameter of the surface shader or a primitive variable, or it is one of these: `z`, the depth in camera
/// space; `id`, the id of the primitive or instance, from 1; `motion`, the displacement on the raster while the shutter is open,
/// pixels to the right and down.
///
/// Colours are filtered and composited like `Ci`: `Ci` and `Oi` as the shader leaves them, which are by the opacity already, and others,
/// values of a surface, by its opacity, so that a surface that is not seen adds nothing. Other values are means over the surfaces that cover the pixel and are not behind
/// a surface more than half opaque. `z` is the minimum in the pixel, infinity where no surface is; `id` is that of the sample
/// nearest the pixel's centre, 0 where no surface is.
#[derive(Clone, Debug, PartialEq)]
pub struct Aov {
    /// Name of the variable.
    pub name: String,
    /// Type of the variable.
    pub kind: Kind,
}

impl Aov {
    /// Whether it counts by the opacity of the surface.
    pub fn is_weighted(&self) -> bool {
        self.kind == Kind::Color && !matches!(self.name.as_str(), "Ci" | "Oi")
    }

    /// Count of numbers in a value: 1 for a float, 3 for a colour, point, vector or normal.
    pub fn width(&self) -> usize {
        self.kind.width()
    }

    /// What a display's mode asks for besides colour: the name with or without class and type before it. `declared` has the
    /// types of names that `Declare` gave.
    fn of_mode(mode: &str, declared: &HashMap<String, Kind>) -> Result<Aov, String> {
        let words: Vec<&str> = mode.split_whitespace().collect();
        let name = match words.last() {
            Some(&"Z") => "z",
            Some(name) => name,
            None => return Err("the display's mode is empty, expected rgb, rgba, a, z or a variable".into()),
        };
        let own = match name {
            "z" | "id" | "u" | "v" | "s" | "t" => Some(Kind::Float),
            "P" => Some(Kind::Point),
            "N" | "Ng" => Some(Kind::Normal),
            "I" | "motion" => Some(Kind::Vector),
            "Cs" | "Os" | "Ci" | "Oi" => Some(Kind::Color),
            _ => None,
        };
        let named = |word: &&str| {
            [Kind::Float, Kind::Color, Kind::Point, Kind::Vector, Kind::Normal].into_iter().find(|k| k.name() == *word)
        };
        let before = &words[..words.len() - 1];
        let strange = before.iter().find(|w| {
            !matches!(**w, "constant" | "uniform" | "varying" | "vertex" | "facevarying") && named(w).is_none()
        });
        if let Some(word) = strange {
            return Err(format!(
                "the display's mode `{mode}` begins with `{word}`, expected a class and one of float, color, point, vector, normal"
            ));
        }
        let kind = own.or(before.iter().find_map(named)).or(declared.get(name).copied());
        match kind {
            Some(kind) => Ok(Aov { name: name.into(), kind }),
            None => Err(format!(
                "the display's mode `{mode}` names a variable without its type: expected rgb, rgba, a, z, or for instance `color {name}`"
            )),
        }
    }
}

/// A layer of a display: colour, coverage or an arbitrary output variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// Red, green, blue.
    Rgb,
    /// Red, green, blue and coverage.
    Rgba,
    /// Coverage alone.
    Alpha,
    /// An arbitrary output variable.
    Aov(Aov),
}

/// The file format of a name or an ending.
fn format_named(name: &str) -> Option<&'static str> {
    match name.to_lowercase().as_str() {
        "png" => Some("png"),
        "exr" | "openexr" => Some("exr"),
        "tif" | "tiff" => Some("tiff"),
        _ => None,
    }
}

/// Whether a file format stores floats with this quantization.
pub fn stores_floats(format: &str, [_, one, _, max]: [i32; 4]) -> bool {
    format == "exr" || format == "tiff" && one == 0 && max == 0
}

/// Quantization and dither (`Quantize`, RISpec 4.1.2), as [`Display::levels`] has them.
#[derive(Clone, Copy, Debug)]
pub struct Quantization {
    /// Of colours.
    pub colors: ([i32; 4], f32),
    /// Of depths that are alone in a file.
    pub depths: ([i32; 4], f32),
}

/// A display (`Display`, RISpec 4.1.2): a file, and the layers that are written to it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Display {
    /// File name. EXR displays of one name are layers of one file.
    pub name: String,
    /// Type of the display: `png`, `exr`, `tiff`, or `file`, which leaves the format to the file name's extension.
    pub kind: String,
    /// Mode: `rgb`, `rgba`, `a`, `z`, `rgbz`, `rgbaz`, or the type and name of an [`Aov`].
    pub mode: String,
    /// Whether colour and coverage of an EXR file are 16-bit floats, otherwise 32-bit.
    pub half: bool,
    /// Quantization of this display alone, if it is given: the values that 0 and 1 map to, and the least and the greatest.
    #[serde(default)]
    pub quantize: Option<[i32; 4]>,
    /// Dither of this display alone, if it is given: its amplitude in levels.
    #[serde(default)]
    pub dither: Option<f32>,
}

impl Display {
    /// The file format, `png`, `exr` or `tiff`: from the file name's extension, else from the type of the display, else `png`.
    pub fn format(&self) -> &'static str {
        let ending = std::path::Path::new(&self.name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        format_named(ending).or(format_named(&self.kind)).unwrap_or("png")
    }

    /// Quantization of its numbers, the values that 0 and 1 map to and the least and the greatest, and the amplitude of their dither; the
    /// image's if it has none of its own.
    pub fn levels(&self, image: &Quantization) -> ([i32; 4], f32) {
        let is_depth = |layer: &Layer| matches!(layer, Layer::Aov(aov) if aov.name == "z");
        let (levels, dither) = if self.layers().iter().all(is_depth) { image.depths } else { image.colors };
        (self.quantize.unwrap_or(levels), self.dither.unwrap_or(dither))
    }

    /// What stands in the file, if it is of another kind than its name or the type of the display says.
    pub fn stands_in(&self) -> Option<String> {
        let ending = std::path::Path::new(&self.name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        let (format, kind) = (self.format(), &self.kind);
        if kind != "file" && format_named(kind).is_none() {
            return Some(format!(
                "the display type `{kind}` is not known, expected png, tiff, exr or file: `{}` is written as {format}",
                self.name
            ));
        }
        let images =
            ["jpg", "jpeg", "bmp", "gif", "tga", "webp", "ppm", "pgm", "hdr", "dpx", "cin", "sgi", "rgb", "iff", "pic"];
        let is_other = format_named(ending).is_none() && images.contains(&ending.to_lowercase().as_str());
        is_other.then(|| {
            format!("`{}` is written as {format}, whatever its name says: expected png, tif or exr", self.name)
        })
    }

    /// Check a mode and return it with the type of its variable written out. `declared` has the types that `Declare` gave to names.
    /// An error if the mode is empty, is malformed or names a variable without a type.
    pub fn with_type(mode: &str, declared: &HashMap<String, Kind>) -> Result<String, String> {
        let plain = matches!(mode, "rgb" | "rgba" | "a" | "rgbz" | "rgbaz");
        if plain {
            return Ok(mode.into());
        }
        let aov = Aov::of_mode(mode, declared)?;
        Ok(format!("{} {}", aov.kind.name(), aov.name))
    }

    /// The layers that the mode stands for.
    pub fn layers(&self) -> Vec<Layer> {
        let depth = || Layer::Aov(Aov { name: "z".into(), kind: Kind::Float });
        match self.mode.as_str() {
            "rgb" => vec![Layer::Rgb],
            "rgba" => vec![Layer::Rgba],
            "a" => vec![Layer::Alpha],
            "rgbz" => vec![Layer::Rgb, depth()],
            "rgbaz" => vec![Layer::Rgba, depth()],
            other => Aov::of_mode(other, &HashMap::new()).map(Layer::Aov).into_iter().collect(),
        }
    }
}

/// Group displays by file name, in their order: EXR displays of one name are layers of one file.
pub fn files(displays: &[Display]) -> Vec<(&str, Vec<&Display>)> {
    let mut files: Vec<(&str, Vec<&Display>)> = vec![];
    for display in displays {
        match files.iter_mut().find(|(name, _)| *name == display.name) {
            Some((_, list)) => list.push(display),
            None => files.push((&display.name, vec![display])),
        }
    }
    files
}

/// The arbitrary output variables of all displays, each once, in their order.
pub fn aovs(displays: &[Display]) -> Vec<Aov> {
    let mut all: Vec<Aov> = vec![];
    for layer in displays.iter().flat_map(Display::layers) {
        if let Layer::Aov(aov) = layer
            && all.iter().all(|a| a.name != aov.name)
        {
            all.push(aov);
        }
    }
    all
}

/// The output parameters of a surface shader that say what a display shows of it as it is, whatever exposes the rest: the colour, and how much of the
/// surface's opacity that is, both without the opacity. Ci must hold that colour, too, by the opacity.
pub const SHOWN: [&str; 2] = ["displaycolor", "displaycover"];

/// The variables of [`SHOWN`], added to those that displays take; the offsets of both among the numbers of a point or pixel.
pub fn add_shown(aovs: &mut Vec<Aov>) -> Option<[usize; 2]> {
    for name in SHOWN {
        if place_of(aovs, name).is_none() {
            aovs.push(Aov { name: name.into(), kind: Kind::Color });
        }
    }
    let [color, cover] = SHOWN.map(|name| {
        let is_color = |aov: &&Aov| aov.name == name && aov.kind == Kind::Color;
        aovs.iter().find(is_color).and_then(|_| place_of(aovs, name))
    });
    color.zip(cover).map(|(color, cover)| [color, cover])
}

/// Each variable with the offset of its first number among the [`depth`] numbers of a point or pixel.
pub fn placed(aovs: &[Aov]) -> impl Iterator<Item = (usize, &Aov)> {
    aovs.iter().scan(0, |next, aov| {
        let first = *next;
        *next += aov.width();
        Some((first, aov))
    })
}

/// The offset of the variable `name` among the [`depth`] numbers of a point or pixel.
pub fn place_of(aovs: &[Aov], name: &str) -> Option<usize> {
    placed(aovs).find(|(_, aov)| aov.name == name).map(|(first, _)| first)
}

/// Count of numbers that all these variables have at a point or pixel.
pub fn depth(aovs: &[Aov]) -> usize {
    aovs.iter().map(Aov::width).sum()
}

/// A channel of an image file: its name and its index among the numbers of a pixel.
pub struct Channel {
    /// Channel name: `R`, `G`, `B`, `A`, `Z`, or the variable's name with a suffix.
    pub name: String,
    /// Index of the number in a pixel: 0 to 3 are red, green, blue and coverage, from 4 on the arbitrary output variables.
    pub at: usize,
}

/// The channels of a file with these layers, of an image with these arbitrary output variables.
pub fn channels(layers: &[Layer], aovs: &[Aov]) -> Vec<Channel> {
    let channel = |name: &str, at: usize| Channel { name: name.into(), at };
    let alone = layers.len() == 1;
    let mut all = vec![];
    for layer in layers {
        match layer {
            Layer::Rgb => all.extend(["R", "G", "B"].iter().enumerate().map(|(i, n)| channel(n, i))),
            Layer::Rgba => all.extend(["R", "G", "B", "A"].iter().enumerate().map(|(i, n)| channel(n, i))),
            Layer::Alpha => all.push(channel("A", 3)),
            Layer::Aov(aov) => {
                let Some(first) = place_of(aovs, &aov.name) else { continue };
                let from = 4 + first;
                let suffixes = if aov.kind == Kind::Color || alone { ["R", "G", "B"] } else { ["X", "Y", "Z"] };
                match aov.width() {
                    1 if aov.name == "z" => all.push(channel("Z", from)),
                    1 => all.push(channel(&aov.name, from)),
                    // A file of one variable alone shows it as a colour.
                    _ if alone => all.extend(suffixes.iter().enumerate().map(|(i, s)| channel(s, from + i))),
                    _ => all.extend(
                        suffixes.iter().enumerate().map(|(i, s)| channel(&format!("{}.{s}", aov.name), from + i)),
                    ),
                }
            }
        }
    }
    // What two displays take is there once.
    let mut names = std::collections::HashSet::new();
    all.retain(|c| names.insert(c.name.clone()));
    all
}
