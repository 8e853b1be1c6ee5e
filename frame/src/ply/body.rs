//! The numbers of a PLY file, as text and in binary.

use super::head::{Element, Faces, Property, Type};
use crate::rows::Lines;
use crate::{Column, Fault, FaultKind, Field, text};
use guard::memory;
use std::path::Path;

/// The columns of an element's properties, but for lists, without rows.
fn columns(path: &Path, element: &Element, capacity: usize) -> Result<Vec<(Field, Column)>, Fault> {
    let plain = || element.properties.iter().filter(|property| property.list.is_none());
    let width = |of: Type| if of == Type::F32 { 4 } else { 8 };
    let row: usize = plain().map(|property| width(property.of)).sum();
    if (capacity as u64).saturating_mul(row as u64) > memory::room() {
        let message = format!("`{}` is too large: {}", element.name, memory::Full);
        return Err(Fault::whole(FaultKind::Data, path, message));
    }
    let column = |property: &Property| match property.of {
        Type::F32 => Column::F32(Vec::with_capacity(capacity)),
        Type::F64 => Column::F64(Vec::with_capacity(capacity)),
        _ => Column::I64(Vec::with_capacity(capacity)),
    };
    Ok(plain().map(|property| (Field::new(&property.name, ""), column(property))).collect())
}

/// Numbers as text, a row a line.
pub(super) struct Words<'a> {
    path: &'a Path,
    text: String,
    /// Lines before the text.
    before: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(path: &'a Path, bytes: &[u8], before: usize) -> Result<Words<'a>, Fault> {
        let text = text::decode(bytes.to_vec());
        let text = text.map_err(|_| Fault::whole(FaultKind::Data, path, "has bytes that are no text"))?;
        Ok(Words { path, text, before })
    }

    /// The columns of the vertices, and the faces where they are wanted.
    pub(super) fn read(&self, elements: &[Element], faces: Option<&mut Faces>) -> Result<Vec<(Field, Column)>, Fault> {
        self.elements(elements, faces).map_err(|fault| fault.moved(self.before))
    }

    fn elements(&self, elements: &[Element], mut faces: Option<&mut Faces>) -> Result<Vec<(Field, Column)>, Fault> {
        let mut lines = Lines::new(self.path, &self.text);
        let mut found = vec![];
        for element in elements.iter().filter(|element| !element.properties.is_empty()) {
            let is_vertex = element.name == "vertex" && found.is_empty();
            let mut columns = if is_vertex { columns(self.path, element, 0)? } else { vec![] };
            for k in 0..element.count {
                let line = loop {
                    let line = lines.next(format_args!("{} rows of `{}`, found {k},", element.count, element.name))?;
                    if !line.trim().is_empty() {
                        break line;
                    }
                };
                let mut row = line.split_ascii_whitespace();
                if is_vertex {
                    let mut columns = columns.iter_mut();
                    let mut put = |property: &Property, word: &str| match columns.next() {
                        Some((_, column)) => push(column, property, word),
                        None => Ok(()),
                    };
                    walk(&element.properties, &mut row, &mut put, None)
                } else {
                    let faces = faces.as_deref_mut().filter(|_| element.is_face());
                    walk(&element.properties, &mut row, &mut |_, _| Ok(()), faces)
                }
                .map_err(|message| match message {
                    None => {
                        let n = line.split_ascii_whitespace().count();
                        lines.fault(format!("row of `{}` has {n} cells, and its properties need more", element.name))
                    }
                    Some(message) => lines.fault(message),
                })?;
                if row.next().is_some() {
                    return Err(lines.fault(format!("row of `{}` has more cells than its properties", element.name)));
                }
            }
            if is_vertex {
                found = columns;
            }
        }
        Ok(found)
    }
}

/// Give the words of a row to `put`, but for those of lists; the corners of a face are added to `faces`. An error without a message if
/// there are too few.
fn walk<'w>(
    properties: &[Property],
    row: &mut impl Iterator<Item = &'w str>,
    put: &mut impl FnMut(&Property, &'w str) -> Result<(), String>,
    mut faces: Option<&mut Faces>,
) -> Result<(), Option<String>> {
    for property in properties {
        let word = row.next().ok_or(None)?;
        if property.list.is_some() {
            let n: u64 = word.parse().map_err(|_| Some(format!("`{word}` is no count of a list")))?;
            let mut faces = faces.as_deref_mut().filter(|_| property.is_corners());
            for _ in 0..n {
                let word = row.next().ok_or(None)?;
                if let Some(faces) = &mut faces {
                    faces.corners.push(word.parse().map_err(|_| Some(format!("`{word}` is no number of a vertex")))?);
                }
            }
            if let Some(faces) = faces {
                faces.arities.push(n as u32);
            }
        } else {
            put(property, word).map_err(Some)?;
        }
    }
    Ok(())
}

fn push(column: &mut Column, property: &Property, word: &str) -> Result<(), String> {
    let wrong = |what: &str| format!("`{word}` is no {what}, as `{}` has", property.name);
    match column {
        Column::F32(v) => v.push(word.parse().map_err(|_| wrong("number"))?),
        Column::F64(v) => v.push(word.parse().map_err(|_| wrong("number"))?),
        Column::I64(v) => v.push(word.parse().map_err(|_| wrong("whole number"))?),
        Column::Category { .. } => {}
    }
    Ok(())
}

/// Numbers in binary, those of more than one byte with the most significant first if `BIG`.
pub(super) struct Bytes<'a, const BIG: bool> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl<'a, const BIG: bool> Bytes<'a, BIG> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Bytes<'a, BIG> {
        Bytes { path, bytes }
    }

    /// The columns of the vertices, and the faces where they are wanted.
    pub(super) fn read(
        mut self,
        elements: &[Element],
        mut faces: Option<&mut Faces>,
    ) -> Result<Vec<(Field, Column)>, Fault> {
        let mut found = vec![];
        for element in elements.iter().filter(|element| !element.properties.is_empty()) {
            // A row has no fewer bytes than this.
            let least: usize = element.properties.iter().map(|p| p.list.unwrap_or(p.of).size()).sum();
            let is_vertex = element.name == "vertex" && found.is_empty();
            let n = (self.bytes.len() / least) as u64;
            if element.count > n {
                return Err(self.truncated(element, None));
            }
            let count = element.count as usize;
            let mut columns = if is_vertex { columns(self.path, element, count)? } else { vec![] };
            if element.properties.iter().any(|property| property.list.is_some()) {
                for k in 0..count {
                    let faces = faces.as_deref_mut().filter(|_| element.is_face());
                    self.row(element, &mut columns, faces).ok_or_else(|| self.truncated(element, Some(k)))?;
                }
            } else {
                let (rows, rest) = self.bytes.split_at(count * least);
                let mut at = 0;
                let plain = element.properties.iter().zip(&mut columns);
                for (property, (_, column)) in plain {
                    let size = property.of.size();
                    rows.chunks_exact(least)
                        .for_each(|row| push_bytes::<BIG>(column, property.of, &row[at..at + size]));
                    at += size;
                }
                self.bytes = rest;
            }
            if is_vertex {
                found = columns;
            }
        }
        Ok(found)
    }

    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.bytes.split_at_checked(n)?;
        self.bytes = rest;
        Some(head)
    }

    /// Read a row that has lists; none if the file ends in it.
    fn row(&mut self, element: &Element, columns: &mut [(Field, Column)], mut faces: Option<&mut Faces>) -> Option<()> {
        let mut columns = columns.iter_mut();
        for property in &element.properties {
            match property.list {
                Some(list) => {
                    let mut count = Column::I64(vec![]);
                    push_bytes::<BIG>(&mut count, list, self.take(list.size())?);
                    let n = usize::try_from(count.number(0)? as i64).ok()?;
                    let list = self.take(n.checked_mul(property.of.size())?)?;
                    if let Some(faces) = faces.as_deref_mut().filter(|_| property.is_corners()) {
                        let mut corners = Column::I64(Vec::with_capacity(n));
                        list.chunks_exact(property.of.size())
                            .for_each(|bytes| push_bytes::<BIG>(&mut corners, property.of, bytes));
                        // What is no number of a vertex is none that a mesh has.
                        let corner = |k: usize| corners.number(k).map_or(u32::MAX, |x| x as u32);
                        faces.corners.extend((0..n).map(corner));
                        faces.arities.push(n as u32);
                    }
                }
                None => {
                    let bytes = self.take(property.of.size())?;
                    if let Some((_, column)) = columns.next() {
                        push_bytes::<BIG>(column, property.of, bytes);
                    }
                }
            }
        }
        Some(())
    }

    fn truncated(&self, element: &Element, row: Option<usize>) -> Fault {
        let at = row.map_or(String::new(), |k| format!(", in row {}", k + 1));
        let message = format!("is truncated in the {} rows of `{}`{at}", element.count, element.name);
        Fault::whole(FaultKind::Data, self.path, message)
            .hint("the program that wrote it was interrupted, or is still writing it")
    }
}

/// Append the number that bytes are, as many as its type has.
fn push_bytes<const BIG: bool>(column: &mut Column, of: Type, bytes: &[u8]) {
    fn array<const N: usize, const BIG: bool>(bytes: &[u8]) -> [u8; N] {
        let mut array: [u8; N] = bytes.try_into().unwrap_or([0; N]);
        if BIG {
            array.reverse();
        }
        array
    }
    match column {
        Column::F32(v) => v.push(f32::from_le_bytes(array::<4, BIG>(bytes))),
        Column::F64(v) => v.push(f64::from_le_bytes(array::<8, BIG>(bytes))),
        Column::I64(v) => v.push(match of {
            Type::I8 => i8::from_le_bytes(array::<1, BIG>(bytes)) as i64,
            Type::U8 => bytes[0] as i64,
            Type::I16 => i16::from_le_bytes(array::<2, BIG>(bytes)) as i64,
            Type::U16 => u16::from_le_bytes(array::<2, BIG>(bytes)) as i64,
            Type::I32 => i32::from_le_bytes(array::<4, BIG>(bytes)) as i64,
            _ => u32::from_le_bytes(array::<4, BIG>(bytes)) as i64,
        }),
        Column::Category { .. } => {}
    }
}
