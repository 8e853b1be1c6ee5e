//! Displays and what goes to them: colour and coverage, depth, and other values of surfaces, all in one pass (RISpec 4.1.9).

use sl::ir::Kind;
use std::collections::HashMap;

/// A value of surfaces that goes to a display besides colour: an "arbitrary output variable".
///
/// Its name is one of a shading variable (`P`, `N`, `Ng`, `I`, `u`, `v`, `s`, `t`, `Cs`, `Os`, `Ci`, `Oi`; points and directions in
/// world space), of a surface shader's output parameter or of a primitive variable, or one of these:
/// `z`, the depth before the camera; `id`, the id of the primitive or instance, from 1; `motion`, how far it moves on the
/// raster while the shutter is open, pixels to the right and down.
///
/// Colours are filtered and composited like Ci. Other values are means over what covers the pixel, seen through nothing that is
/// more than half opaque. `z` is the least in the pixel, infinity where nothing is; `id` that of the sample nearest its middle, 0
/// where nothing is.
#[derive(Clone, Debug, PartialEq)]
pub struct Aov {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Kind,
}

impl Aov {
    /// Numbers of a value.
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

/// What goes to a display.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// Red, green, blue.
    Rgb,
    /// And coverage.
    Rgba,
    /// Coverage alone.
    Alpha,
    /// Something else.
    Aov(Aov),
}

/// Where an image goes.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Display {
    /// File name. EXR displays of one name are layers of one file.
    pub name: String,
    /// The driver: `png`, `exr`, `tiff`, or `file`, which goes by the name's ending.
    pub kind: String,
    /// What it takes: `rgb`, `rgba`, `a`, `z`, `rgbz`, `rgbaz`, or an [`Aov`] with its type.
    pub mode: String,
    /// Floats of EXR have 16 bits.
    pub half: bool,
}

impl Display {
    /// The file's kind: by its driver's name, else by its own ending; PNG if neither says.
    pub fn format(&self) -> &'static str {
        let of = |name: &str| match name.to_lowercase().as_str() {
            "png" => Some("png"),
            "exr" | "openexr" => Some("exr"),
            "tif" | "tiff" => Some("tiff"),
            _ => None,
        };
        let ending = std::path::Path::new(&self.name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        of(ending).or(of(&self.kind)).unwrap_or("png")
    }

    /// Hold a mode to what is known, and write the type of its variable out; an error says what is wrong with it.
    pub fn with_type(mode: &str, declared: &HashMap<String, Kind>) -> Result<String, String> {
        let plain = matches!(mode, "rgb" | "rgba" | "a" | "rgbz" | "rgbaz");
        if plain {
            return Ok(mode.into());
        }
        let aov = Aov::of_mode(mode, declared)?;
        Ok(format!("{} {}", aov.kind.name(), aov.name))
    }

    /// What goes to it.
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

/// The files of some displays, and the displays of each: EXR displays of one name share a file.
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

/// All values besides colour that some displays take, each once.
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

/// Some values with the places of their first numbers among those of a point or a pixel.
pub fn placed(aovs: &[Aov]) -> impl Iterator<Item = (usize, &Aov)> {
    aovs.iter().scan(0, |next, aov| {
        let first = *next;
        *next += aov.width();
        Some((first, aov))
    })
}

/// The place of the first number of a value of some name.
pub fn place_of(aovs: &[Aov], name: &str) -> Option<usize> {
    placed(aovs).find(|(_, aov)| aov.name == name).map(|(first, _)| first)
}

/// Count of the numbers of some values.
pub fn depth(aovs: &[Aov]) -> usize {
    aovs.iter().map(Aov::width).sum()
}

/// A channel of a file: its name, and which number of a pixel it is.
pub struct Channel {
    /// Its name: R, G, B, A, Z, or the variable's with a suffix.
    pub name: String,
    /// 0 to 3 for red, green, blue and coverage, from 4 on the values besides colour.
    pub at: usize,
}

/// The channels of a file that takes some layers of an image with these values besides colour.
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
