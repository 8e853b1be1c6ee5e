//! VTK files in XML: the tree of their elements, and the points of those with data (VTK User's Guide, "XML File Formats").
//!
//! Data that is appended stands behind all other elements and may be of any bytes, so the tree ends where it begins.

use super::arrays::{Array, Points, Scalar, Source, Words, check_width};
use super::encoding::{Encoding, Input};
use crate::{Column, Fault};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::ops::Range;

/// Most elements within each other.
const DEEPEST: usize = 64;

/// An element: its name, attributes, text and children.
#[derive(Debug)]
pub(super) struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    /// Where it begins.
    pub(super) at: usize,
    /// Where its text stands.
    text: Range<usize>,
    children: Vec<Element>,
}

impl Element {
    /// The value of an attribute.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// The children of a name.
    pub(super) fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The arrays in the first child of a name.
    fn arrays(&self, child: &'static str) -> impl Iterator<Item = &Element> {
        self.all(child).take(1).flat_map(|child| child.all("DataArray"))
    }
}

/// The head of a file, and where its data is.
pub(super) struct File<'a> {
    pub(super) source: Source<'a>,
    pub(super) root: Element,
    encoding: Encoding,
    /// The data that is appended, and whether as it is or in base64.
    appended: Option<(Range<usize>, bool)>,
}

impl<'a> File<'a> {
    /// Read the elements of a file.
    pub(super) fn open(source: Source<'a>) -> Result<File<'a>, Fault> {
        let end = memchr::memmem::find(source.bytes, b"<AppendedData");
        let head = &source.bytes[..end.unwrap_or(source.bytes.len())];
        let head = std::str::from_utf8(head).map_err(|e| source.fault(e.valid_up_to(), "is not UTF-8 text"))?;
        let skip = if head.starts_with(crate::text::MARK) { crate::text::MARK.len() } else { 0 };
        let root = tree(source, &head[skip..], skip, end.is_some())?;
        if root.name != "VTKFile" {
            return Err(source.fault(root.at, "expected the element `VTKFile`"));
        }
        let encoding = Encoding::of(|name| root.get(name)).map_err(|e| source.fault(root.at, e))?;
        let appended = end.map(|at| appended(source, at)).transpose()?;
        Ok(File { source, root, encoding, appended })
    }

    /// What the file has, as it says.
    pub(super) fn kind(&self) -> &str {
        self.root.get("type").unwrap_or("")
    }

    /// The element of the file's kind.
    pub(super) fn data(&self) -> Result<&Element, Fault> {
        let missing = || self.source.fault(self.root.at, format!("expected an element `{}` within", self.kind()));
        self.root.all(self.kind()).next().ok_or_else(missing)
    }

    /// The points of all pieces.
    pub(super) fn points(&self) -> Result<Points, Fault> {
        let data = self.data()?;
        let mut points = Points::default();
        for array in self.root.arrays("FieldData").chain(data.arrays("FieldData")) {
            let is_one = array.get("NumberOfTuples").is_none_or(|n| n == "1");
            if array.get("Name") == Some("TimeValue") && is_one {
                points.time = self.array(array, 1)?.and_then(|time| time.columns.first()?.number(0));
            }
        }
        for piece in data.all("Piece") {
            let own = self.piece(piece)?;
            points.append(own).map_err(|e| self.source.fault(piece.at, format!("this piece {e}")))?;
            guard::memory::check()
                .map_err(|e| self.source.fault(piece.at, format!("the pieces are too large: {e}")))?;
        }
        Ok(points)
    }

    fn piece(&self, piece: &Element) -> Result<Points, Fault> {
        let n = self.count(piece, "NumberOfPoints")?;
        let mut points = Points::default();
        if let Some(place) = piece.arrays("Points").next() {
            let place = self.array(place, n)?.filter(|place| place.columns.len() == 3);
            points.place =
                place.ok_or_else(|| self.source.fault(piece.at, "expected points of three numbers"))?.columns;
        } else if n > 0 {
            return Err(self.source.fault(piece.at, "expected an element `Points` with an array"));
        }
        for array in piece.arrays("PointData") {
            points.arrays.extend(self.array(array, n)?);
        }
        // Polygonal data has cells of four kinds, of which vertices are one.
        let (count, cells) =
            if self.kind() == "PolyData" { ("NumberOfVerts", "Verts") } else { ("NumberOfCells", "Cells") };
        let others = ["NumberOfLines", "NumberOfStrips", "NumberOfPolys"];
        let is_of_points = piece.get(count).and_then(|text| text.parse().ok()) == Some(n)
            && others.iter().all(|name| piece.get(name).is_none_or(|count| count == "0"));
        if n > 0 && is_of_points && piece.arrays("CellData").next().is_some() {
            let numbers = |name: &str| -> Result<Option<Vec<i64>>, Fault> {
                let array = piece.arrays(cells).find(|array| array.get("Name") == Some(name));
                let column = array.map(|array| self.array(array, n)).transpose()?.flatten();
                Ok(column.and_then(|array| match array.columns.into_iter().next() {
                    Some(Column::I64(numbers)) => Some(numbers),
                    _ => None,
                }))
            };
            // The n-th cell ends with the n-th point if each has one.
            let is_vertex = numbers("offsets")?.is_some_and(|ends| ends.iter().zip(1..).all(|(end, k)| *end == k));
            if is_vertex && let Some(point) = numbers("connectivity")? {
                let arrays = piece.arrays("CellData").map(|array| self.array(array, n));
                points.add_cells(arrays.filter_map(Result::transpose).collect::<Result<_, _>>()?, &point);
            }
        }
        Ok(points)
    }

    /// The count that an attribute is.
    fn count(&self, element: &Element, name: &str) -> Result<usize, Fault> {
        let count = element.get(name).and_then(|text| text.trim().parse().ok());
        count.ok_or_else(|| self.source.fault(element.at, format!("expected `{name}`, a whole number")))
    }

    /// The array of an element, with `n` tuples; none if it is of words.
    fn array(&self, element: &Element, n: usize) -> Result<Option<Array>, Fault> {
        let fault = |message: String| self.source.fault(element.at, message);
        let name = element.get("Name").unwrap_or("unnamed").to_string();
        let kind = match element.get("type").unwrap_or("") {
            "String" => return Ok(None),
            kind => Scalar::of_xml(kind)
                .ok_or_else(|| fault(format!("has the type `{kind}`, expected one such as `Float32` or `Int64`")))?,
        };
        let width = match element.get("NumberOfComponents") {
            Some(text) => text.trim().parse().map_err(|_| fault("has a count of components that is none".into()))?,
            None => 1,
        };
        let width = check_width(if width == 0 { 1 } else { width }).map_err(fault)?;
        let format = element.get("format").unwrap_or("ascii");
        let input = match (format, &self.appended) {
            ("ascii", _) => {
                let mut words = Words { source: self.source, at: element.text.start, end: element.text.end };
                let columns = words.columns(kind, n, width, &format!("`{name}`"))?;
                if !words.is_empty() {
                    let message = format!("`{name}` has more than {n} × {width} numbers");
                    return Err(self.source.fault(words.at, message));
                }
                return Ok(Some(Array { name, columns }));
            }
            ("binary", _) => Input::base64(self.source.bytes, element.text.clone()),
            ("appended", Some((range, is_raw))) => {
                let offset: usize =
                    element.get("offset").and_then(|text| text.trim().parse().ok()).unwrap_or(usize::MAX);
                let start = range.start.checked_add(offset).filter(|start| *start <= range.end);
                let start = start.ok_or_else(|| fault("has an `offset` that is none of the appended data".into()))?;
                let new = if *is_raw { Input::raw } else { Input::base64 };
                new(self.source.bytes, start..range.end)
            }
            ("appended", None) => return Err(fault("has its data in `AppendedData`, and there is none".into())),
            _ => return Err(fault("expected the format `ascii`, `binary` or `appended`".into())),
        };
        let length = n.checked_mul(width).and_then(|count| kind.bytes(count)).unwrap_or(usize::MAX);
        let bytes = self.encoding.read(input, length);
        let bytes = bytes.map_err(|(at, e)| self.source.fault(at, format!("`{name}` {e}")))?;
        if 8 * (n * width) as u64 > guard::memory::room() {
            return Err(fault(format!("`{name}` is too large: {}", guard::memory::Full)));
        }
        Ok(Some(Array { name, columns: kind.columns(&bytes, n, width, self.encoding.order) }))
    }
}

/// The root of the tree of elements; with `is_cut`, those that are still open at the end are taken as they are.
fn tree(source: Source<'_>, text: &str, skip: usize, is_cut: bool) -> Result<Element, Fault> {
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Element> = vec![];
    let place = |reader: &Reader<&[u8]>| skip + usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
    loop {
        let at = place(&reader);
        let event = reader.read_event().map_err(|e| {
            let at = skip + usize::try_from(reader.error_position()).unwrap_or(usize::MAX);
            source.fault(at, format!("is no XML: {e}")).hint("the file was cut off, or is still being written")
        })?;
        let is_whole = matches!(event, Event::Empty(_));
        match event {
            Event::Start(start) | Event::Empty(start) => {
                guard::memory::check().map_err(|e| source.fault(at, format!("has too many elements: {e}")))?;
                if open.len() == DEEPEST {
                    return Err(source.fault(at, format!("has more than {DEEPEST} elements within each other")));
                }
                let end = place(&reader);
                open.push(Element { text: end..end, ..element(source, &start, at)? });
                if is_whole && let Some(root) = close(&mut open) {
                    return Ok(root);
                }
            }
            Event::End(_) => {
                if let Some(root) = close(&mut open) {
                    return Ok(root);
                }
            }
            Event::Text(part) => {
                let part = part.into_inner();
                let start = skip + (part.as_ptr() as usize).saturating_sub(text.as_ptr() as usize);
                if let Some(element) = open.last_mut()
                    && !part.trim_ascii().is_empty()
                {
                    if !element.text.is_empty() {
                        return Err(source.fault(start, "expected the data of an array in one piece"));
                    }
                    element.text = start..start + part.len();
                }
            }
            Event::Eof => {
                while is_cut && !open.is_empty() {
                    if let Some(root) = close(&mut open) {
                        return Ok(root);
                    }
                }
                let message = match open.last() {
                    Some(element) => format!("ends within the element `{}`", element.name),
                    None => "has no elements".into(),
                };
                let fault = source.fault(source.bytes.len(), message);
                return Err(fault.hint("the file was cut off, or is still being written"));
            }
            Event::CData(_) | Event::GeneralRef(_) => {
                return Err(source.fault(at, "has a reference or CDATA, and VTK files have none"));
            }
            _ => {}
        }
    }
}

/// Close the last open element; the root is given back.
fn close(open: &mut Vec<Element>) -> Option<Element> {
    let done = open.pop()?;
    match open.last_mut() {
        Some(parent) => parent.children.push(done),
        None => return Some(done),
    }
    None
}

fn element(source: Source<'_>, start: &BytesStart<'_>, at: usize) -> Result<Element, Fault> {
    let mut attributes = vec![];
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|e| source.fault(at, format!("has an attribute that is none: {e}")))?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0);
        let value = value.map_err(|e| source.fault(at, format!("has an attribute that is none: {e}")))?;
        attributes.push((attribute.key.as_ref().to_string(), value.into_owned()));
    }
    let name = start.name().as_ref().to_string();
    Ok(Element { name, attributes, at, text: 0..0, children: vec![] })
}

/// Where the appended data of an element at a byte is, and whether it is raw.
fn appended(source: Source<'_>, at: usize) -> Result<(Range<usize>, bool), Fault> {
    /// Bytes that the tag and the blanks after it have at most.
    const LONGEST: usize = 1 << 12;
    let fault = |message: &str| source.fault(at, message);
    let tag = &source.bytes[at..source.bytes.len().min(at + LONGEST)];
    let length = 1 + memchr::memchr(b'>', tag).ok_or_else(|| fault("has no end of the tag"))?;
    let text = std::str::from_utf8(&tag[..length]).map_err(|_| fault("is not UTF-8 text"))?;
    let element = match Reader::from_str(text).read_event() {
        Ok(Event::Start(start)) => element(source, &start, at)?,
        _ => return Err(fault("has no appended data")),
    };
    let is_raw = match element.get("encoding") {
        Some("raw") => true,
        Some("base64") => false,
        _ => return Err(fault("expected the encoding `raw` or `base64`")),
    };
    let mark = tag[length..].iter().position(|b| !b.is_ascii_whitespace()).map(|k| length + k);
    let mark = mark.filter(|k| tag[*k] == b'_').ok_or_else(|| fault("expected `_` before the data"))?;
    let start = at + mark + 1;
    let end = if is_raw { None } else { memchr::memchr(b'<', &source.bytes[start..]).map(|length| start + length) };
    Ok((start..end.unwrap_or(source.bytes.len()), is_raw))
}
