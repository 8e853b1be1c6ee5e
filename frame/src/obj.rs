//! Wavefront OBJ files → their polygons: a mesh for each object or group, and of faces whose corners have normals or texture coordinates
//! a mesh of their own.

use crate::{Fault, FaultKind};
use std::collections::HashMap;
use std::path::Path;

/// Corners of a face: the indices of point, texture coordinates and normal.
type Corner = [Option<u32>; 3];

/// The polygons of an object or a group whose corners are of one kind, as those of a mesh.
#[derive(Debug)]
pub(crate) struct Polygons {
    /// Points.
    pub(crate) points: Vec<[f32; 3]>,
    /// Normals, one a point, or none at all.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Texture coordinates, one pair a point, or none at all.
    pub(crate) st: Vec<[f32; 2]>,
    /// Count of corners of each polygon, at least 3.
    pub(crate) arities: Vec<u32>,
    /// Points of the corners, polygon by polygon.
    pub(crate) corners: Vec<u32>,
}

/// The polygons of a file of these bytes. Statements besides those of points, faces, objects and groups are passed over: the shape alone is wanted.
/// Errors: a number that is none, and an index out of bounds, with line and column.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<Polygons>, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader { path, text: &text, columns: Default::default(), n_all: [0; 3] };
    for statement in Statements::new(&text) {
        if let Some(kind) = kind_of(statement.keyword) {
            reader.n_all[kind] += 1;
        }
    }
    let (mut groups, mut group) = (vec![], vec![]);
    for statement in Statements::new(&text) {
        match statement.keyword {
            "f" => {
                let face = reader.face(&statement.words)?;
                add(&mut group, &face);
            }
            "o" | "g" => groups.append(&mut group),
            keyword => {
                if let Some(kind) = kind_of(keyword) {
                    let values = reader.numbers(kind, &statement)?;
                    reader.columns[kind].push(values);
                }
            }
        }
    }
    groups.append(&mut group);
    Ok(groups.into_iter().map(|faces| faces.polygons(&reader.columns)).collect())
}

/// Which index of a corner counts the statements of a keyword.
fn kind_of(keyword: &str) -> Option<usize> {
    ["v", "vt", "vn"].iter().position(|k| *k == keyword)
}

/// What the indices of each kind count.
const NOUNS: [&str; 3] = ["point", "texture coordinate", "normal"];

struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
    /// The numbers of points, texture coordinates and normals so far.
    columns: [Vec<[f32; 3]>; 3],
    /// Number of each in the whole file.
    n_all: [usize; 3],
}

/// A word, and its line and column, from 1.
#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a str,
    line: usize,
    column: usize,
}

impl Reader<'_> {
    fn fault(&self, at: Word<'_>, message: String) -> Fault {
        Fault::at(FaultKind::Data, self.path, self.text, at.line, at.column, message)
    }

    /// The numbers of a point, a pair of texture coordinates or a normal.
    fn numbers(&self, kind: usize, statement: &Statement<'_>) -> Result<[f32; 3], Fault> {
        let mut values = [0.0; 3];
        let needed = if kind == 1 { 1 } else { 3 };
        if statement.words.len() < needed {
            let (keyword, n) = (statement.keyword, statement.words.len());
            return Err(self.fault(statement.at, format!("`{keyword}` has {n} numbers, expected {needed}")));
        }
        for (value, word) in values.iter_mut().zip(&statement.words) {
            *value = word.text.parse().map_err(|_| self.fault(*word, format!("`{}` is no number", word.text)))?;
        }
        Ok(values)
    }

    /// The corners of a face.
    fn face(&self, words: &[Word<'_>]) -> Result<Vec<Corner>, Fault> {
        let mut corners = Vec::with_capacity(words.len());
        for word in words {
            let mut corner = [None; 3];
            let parts: Vec<&str> = word.text.split('/').collect();
            if parts.len() > 3 || parts[0].is_empty() {
                let message = format!("`{}` is no corner of a face, expected `1`, `1/1`, `1//1` or `1/1/1`", word.text);
                return Err(self.fault(*word, message));
            }
            for (kind, part) in parts.iter().enumerate().filter(|(_, part)| !part.is_empty()) {
                corner[kind] = Some(self.index(kind, part).map_err(|message| self.fault(*word, message))?);
            }
            corners.push(corner);
        }
        Ok(corners)
    }

    /// An index, from 0: those of the file count from 1, or from the last one back.
    fn index(&self, kind: usize, text: &str) -> Result<u32, String> {
        let noun = NOUNS[kind];
        let given: i64 = text.parse().map_err(|_| format!("`{text}` is no number of a {noun}"))?;
        let index = if given < 0 { self.columns[kind].len() as i64 + given } else { given - 1 };
        u32::try_from(index).ok().filter(|i| (*i as usize) < self.n_all[kind]).ok_or_else(|| {
            let n = self.n_all[kind];
            format!("the {noun} `{text}` of a face is out of bounds: there {} {n}", if n == 1 { "is" } else { "are" })
        })
    }
}

/// The faces of an object or a group whose corners are of one kind.
#[derive(Default)]
struct Faces {
    /// Whether their corners have texture coordinates, and normals.
    has: [bool; 2],
    /// The points of the mesh, by the corners that they are, and in their order.
    known: HashMap<Corner, u32>,
    points: Vec<Corner>,
    arities: Vec<u32>,
    corners: Vec<u32>,
}

/// Add a face to those of its object or group. One of two corners is a line, which is no surface; one of whose corners some lack a normal has none.
fn add(group: &mut Vec<Faces>, face: &[Corner]) {
    if face.len() < 3 {
        return;
    }
    let has = [1, 2].map(|kind| face.iter().all(|corner| corner[kind].is_some()));
    let at = group.iter().position(|faces| faces.has == has).unwrap_or_else(|| {
        group.push(Faces { has, ..Faces::default() });
        group.len() - 1
    });
    let Faces { known, points, arities, corners, .. } = &mut group[at];
    arities.push(face.len() as u32);
    for [place, st, normal] in face {
        let corner = [*place, st.filter(|_| has[0]), normal.filter(|_| has[1])];
        corners.push(*known.entry(corner).or_insert_with(|| {
            points.push(corner);
            points.len() as u32 - 1
        }));
    }
}

impl Faces {
    /// The polygons, with the values of the file.
    fn polygons(self, [places, st, normals]: &[Vec<[f32; 3]>; 3]) -> Polygons {
        let of = |values: &[[f32; 3]], kind: usize| -> Vec<[f32; 3]> {
            self.points.iter().filter_map(|corner| Some(values[corner[kind]? as usize])).collect()
        };
        Polygons {
            points: of(places, 0),
            st: of(st, 1).into_iter().map(|[s, t, _]| [s, t]).collect(),
            normals: of(normals, 2),
            arities: self.arities,
            corners: self.corners,
        }
    }
}

/// A statement: its keyword and where that stands, and its words.
struct Statement<'a> {
    keyword: &'a str,
    at: Word<'a>,
    words: Vec<Word<'a>>,
}

/// The statements of a text. Numbers may go on behind a `\` at a line's end, and `#` begins a comment.
struct Statements<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
}

impl<'a> Statements<'a> {
    fn new(text: &'a str) -> Statements<'a> {
        Statements { lines: text.lines().enumerate() }
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        let mut words: Vec<Word<'a>> = vec![];
        for (i, line) in self.lines.by_ref() {
            let line = line.split('#').next().unwrap_or("");
            let trimmed = line.trim_end();
            let goes_on = trimmed.strip_suffix('\\');
            let mut before = 0;
            words.extend(goes_on.unwrap_or(trimmed).split_whitespace().map(|text| {
                // Each word begins behind the one before.
                let start = before + line[before..].find(text).unwrap_or(0);
                before = start + text.len();
                Word { text, line: i + 1, column: line[..start].chars().count() + 1 }
            }));
            // Names of files may end in the mark.
            let has_numbers = words.first().is_none_or(|w| w.text == "f" || kind_of(w.text).is_some());
            if words.is_empty() || goes_on.is_some() && has_numbers {
                continue;
            }
            break;
        }
        let at = *words.first()?;
        Some(Statement { keyword: at.text, at, words: words.split_off(1) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meshes(text: &str) -> Result<Vec<Polygons>, Fault> {
        parse(Path::new("a.obj"), text.as_bytes())
    }

    #[test]
    fn faces_of_all_kinds_of_corners_may_stand_in_one_object() {
        let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0.5\nvt 1 0\nvt 0 1\nvn 0 0 -1\n";
        let faces = "f 1//1 3//1 2//1\nf 1 2 4 # a comment\nf 2 3 4#c\nf 1/1 2/2 4/3\nf -4 \\\n  -2 -1\nf 1 2\ng b\nf 1/1/1 2/2/1 3/3/1\n";
        let found = meshes(&format!("{points}{faces}")).unwrap();
        let shape = |m: &Polygons| (m.points.len(), m.normals.len(), m.st.len(), m.arities.len());
        assert_eq!(
            found.iter().map(shape).collect::<Vec<_>>(),
            [(3, 3, 0, 1), (4, 0, 0, 3), (3, 0, 3, 1), (3, 3, 3, 1)]
        );
        assert_eq!(found[1].corners, [0, 1, 2, 1, 3, 2, 0, 3, 2]);
        assert_eq!(found[1].points[3], [0.0, 1.0, 0.0]);
        assert_eq!((found[2].st[1], found[3].normals[0]), ([1.0, 0.0], [0.0, 0.0, -1.0]));
        // Names are passed over, whatever they end in.
        assert_eq!(meshes("mtllib C:\\a\\\nv 0 0 0\nv 1 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n").unwrap().len(), 1);
        // A point may come after its face.
        assert_eq!(meshes("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap()[0].points.len(), 3);
    }

    #[test]
    fn faults_have_line_and_column() {
        let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (face, line, column, message) in [
            ("f 1 2 9", 4, 7, "out of bounds: there are 3"),
            ("f 1 2 \\\n 0", 5, 2, "out of bounds"),
            ("f 1 -4 2", 4, 5, "out of bounds"),
            ("f 1/1 2 3", 4, 3, "the texture coordinate `1`"),
            ("f 1 2 three", 4, 7, "`three` is no number of a point"),
            ("f 1 //2 3", 4, 5, "is no corner"),
            ("v 1 2", 4, 1, "`v` has 2 numbers, expected 3"),
            ("vn 0 zero 1", 4, 6, "`zero` is no number"),
        ] {
            let fault = meshes(&format!("{points}{face}\n")).unwrap_err();
            assert!(fault.message.contains(message), "{fault}");
            assert_eq!((fault.line, fault.column), (line, column), "{fault}");
        }
    }
}
