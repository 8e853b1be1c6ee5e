//! The lines before the numbers of a PLY file: what its elements are, and how they are written.

use crate::{Fault, FaultKind};
use std::path::Path;

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(name: &str) -> Option<Type> {
        Some(match name {
            "char" | "int8" => Type::I8,
            "uchar" | "uint8" => Type::U8,
            "short" | "int16" => Type::I16,
            "ushort" | "uint16" => Type::U16,
            "int" | "int32" => Type::I32,
            "uint" | "uint32" => Type::U32,
            "float" | "float32" => Type::F32,
            "double" | "float64" => Type::F64,
            _ => return None,
        })
    }

    /// Count of its bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::F64 => 8,
        }
    }
}

/// What an element has.
pub(super) struct Property {
    pub(super) name: String,
    pub(super) of: Type,
    /// The type of the count, if it is a list.
    pub(super) list: Option<Type>,
}

impl Property {
    /// Whether it has the corners of a face.
    pub(super) fn is_corners(&self) -> bool {
        let is_whole = !matches!(self.of, Type::F32 | Type::F64);
        is_whole && self.list.is_some() && ["vertex_indices", "vertex_index"].contains(&self.name.as_str())
    }
}

/// Rows of one kind.
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Whether its rows are the faces of a mesh.
    pub(super) fn is_face(&self) -> bool {
        self.name == "face"
    }
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Text,
    Little,
    Big,
}

/// Polygons by the numbers of their vertices.
#[derive(Default)]
pub(crate) struct Faces {
    /// Count of corners of each polygon.
    pub(crate) arities: Vec<u32>,
    /// Vertices of the corners.
    pub(crate) corners: Vec<u32>,
}

/// The lines before the numbers.
pub(super) struct Head {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Count of its bytes.
    pub(super) length: usize,
    /// Count of its lines.
    pub(super) lines: usize,
}

/// Read the lines to `end_header`.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Head, Fault> {
    /// Elements and properties at most.
    const MOST: usize = 4096;
    let (mut format, mut elements, mut length, mut n_properties) = (None, Vec::<Element>::new(), 0, 0);
    for (k, line) in bytes.split_inclusive(|b| *b == b'\n').enumerate() {
        length += line.len();
        let text = String::from_utf8_lossy(&line[..line.len().min(1024)]);
        let text = text.trim();
        let fault = |message: String| Fault::at(FaultKind::Data, path, text, 1, 1, message).moved(k);
        let type_of = |name: &str| {
            Type::of(name)
                .ok_or_else(|| fault(format!("`{name}` is no type of PLY, expected one such as float or uchar")))
        };
        let mut add = |of: Type, list: Option<Type>, name: &str| match elements.last_mut() {
            Some(element) if n_properties < MOST => {
                element.properties.push(Property { name: name.into(), of, list });
                n_properties += 1;
                Ok(())
            }
            Some(_) => Err(fault(format!("has more than {MOST} properties"))),
            None => Err(fault("comes before an element".into())),
        };
        match text.split_whitespace().collect::<Vec<_>>()[..] {
            ["ply"] if k == 0 => {}
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _] => {
                format = match name {
                    "ascii" => Some(Format::Text),
                    "binary_little_endian" => Some(Format::Little),
                    "binary_big_endian" => Some(Format::Big),
                    _ => return Err(fault(format!("`{name}` is no format of PLY"))),
                }
            }
            ["element", name, count] => {
                let count =
                    count.parse().map_err(|_| fault(format!("`{count}` is no count, expected a whole number")))?;
                if elements.len() >= MOST {
                    return Err(fault(format!("has more than {MOST} elements")));
                }
                elements.push(Element { name: name.into(), count, properties: vec![] });
            }
            ["property", "list", count, of, name] => {
                let list = type_of(count)?;
                if matches!(list, Type::F32 | Type::F64) {
                    return Err(fault(format!("the counts of a list are whole numbers, not {count}")));
                }
                add(type_of(of)?, Some(list), name)?;
            }
            ["property", of, name] => add(type_of(of)?, None, name)?,
            ["end_header"] => {
                let Some(format) = format else { return Err(fault("ends without a format".into())) };
                return Ok(Head { format, elements, length, lines: k + 1 });
            }
            _ => return Err(fault("is no line of a PLY file's head".into())),
        }
    }
    Err(Fault::whole(FaultKind::Data, path, "ends before `end_header`")
        .hint("the program that wrote it was interrupted, or is still writing it"))
}
