//! PLY files as frames: the element `vertex` of a cloud of points or a mesh, a row for each vertex and a column for each property.
//!
//! Text, and binary in both orders of bytes, as G. Turk's "The PLY Polygon File Format" (1994) has it. Lists have no column, other
//! elements are passed over, but for the faces of a [mesh](crate::mesh).

mod body;
mod head;

use crate::{Column, Fault, FaultKind, Field, Frame, gzip};
use body::{Bytes, Words};
pub(crate) use head::Faces;
use head::Format;
use std::path::Path;

/// Whether a file begins as PLY files do.
pub(crate) fn is_ply(start: &[u8]) -> bool {
    start.starts_with(b"ply\n") || start.starts_with(b"ply\r")
}

/// Read the vertices of a file as the frame `number`, at time 0.
pub fn read(path: &Path, number: u64) -> Result<Frame, Fault> {
    Ok(Frame { number, time: 0.0, columns: parse(path, &gzip::read(path)?, None)? })
}

/// The columns of the vertices that a file of these bytes has, and its faces where they are wanted.
pub(crate) fn parse(path: &Path, bytes: &[u8], faces: Option<&mut Faces>) -> Result<Vec<(Field, Column)>, Fault> {
    let head = head::read(path, bytes)?;
    let Some(vertex) = head.elements.iter().find(|element| element.name == "vertex") else {
        return Err(Fault::whole(FaultKind::Data, path, "has no element `vertex`, and so no rows"));
    };
    let names: Vec<&str> = vertex.properties.iter().filter(|p| p.list.is_none()).map(|p| p.name.as_str()).collect();
    let wrong = match crate::repeated(names.iter().copied()) {
        _ if names.is_empty() => Some("the element `vertex` has no properties but lists".to_string()),
        Some(i) => Some(format!("two properties of the element `vertex` are named `{}`", names[i])),
        None => None,
    };
    if let Some(wrong) = wrong {
        return Err(Fault::whole(FaultKind::Data, path, wrong));
    }
    let body = &bytes[head.length..];
    match head.format {
        Format::Text => Words::new(path, body, head.lines)?.read(&head.elements, faces),
        Format::Little => Bytes::<false>::new(path, body).read(&head.elements, faces),
        Format::Big => Bytes::<true>::new(path, body).read(&head.elements, faces),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::tests::mutated;

    const HEAD: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement camera 1\nproperty list uchar float view\n\
         element vertex 2\nproperty float x\nproperty double y\nproperty list uchar int near\nproperty uchar red\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const BODY: &str = "2 0.5 0.5\n0.5 1.5 2 7 8 255\n-1 2 0 3\n3 0 1 1\n";

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        file
    }

    fn binary(is_big: bool) -> Vec<u8> {
        let order = if is_big { "binary_big_endian" } else { "binary_little_endian" };
        let mut out = HEAD.replace("ascii", order).into_bytes();
        let mut put = |bytes: &[u8], is_number: bool| {
            let mut bytes = bytes.to_vec();
            if is_big && is_number {
                bytes.reverse();
            }
            out.extend(bytes);
        };
        put(&[2], false);
        [0.5f32, 0.5].iter().for_each(|x| put(&x.to_le_bytes(), true));
        for (x, y, near, red) in [(0.5f32, 1.5f64, vec![7i32, 8], 255u8), (-1.0, 2.0, vec![], 3)] {
            put(&x.to_le_bytes(), true);
            put(&y.to_le_bytes(), true);
            put(&[near.len() as u8], false);
            near.iter().for_each(|n| put(&n.to_le_bytes(), true));
            put(&[red], false);
        }
        put(&[3], false);
        [0i32, 1, 1].iter().for_each(|n| put(&n.to_le_bytes(), true));
        out
    }

    #[test]
    fn vertices_are_the_same_in_all_formats() {
        for bytes in [[HEAD, BODY].concat().into_bytes(), binary(false), binary(true)] {
            let frame = read(file(&bytes).path(), 3).unwrap();
            assert_eq!((frame.names(), frame.number), (vec!["x", "y", "red"], 3));
            assert_eq!(frame.column("x"), Some(&Column::F32(vec![0.5, -1.0])));
            assert_eq!(frame.column("y"), Some(&Column::F64(vec![1.5, 2.0])));
            assert_eq!(frame.column("red"), Some(&Column::I64(vec![255, 3])));
        }
    }

    #[test]
    fn plain_rows_are_read_at_once() {
        let head = "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty short k\r\nend_header\r\n";
        let rows = (0..3i16).flat_map(|k| [&(k as f32 * 0.5).to_le_bytes()[..], &(-k).to_le_bytes()].concat());
        let frame = read(file(&head.bytes().chain(rows).collect::<Vec<u8>>()).path(), 0).unwrap();
        assert_eq!(frame.column("x"), Some(&Column::F32(vec![0.0, 0.5, 1.0])));
        assert_eq!(frame.column("k"), Some(&Column::I64(vec![0, -1, -2])));
    }

    #[test]
    fn wrong_files_are_faults() {
        let text = [HEAD, BODY].concat();
        for (text, line, message) in [
            (text.replace("-1 2 0 3", "-1 2 0"), 16, "row of `vertex` has 3 cells"),
            (text.replace("-1 2 0 3", "-1 2 0 3 4"), 16, "more cells"),
            (text.replace("-1 2 0 3", "-1 2 2 3"), 16, "row of `vertex` has 4 cells"),
            (text.replace("-1 2 0 3", "-1 b 0 3"), 16, "`b` is no number"),
            (text.replace("-1 2 0 3", "-1 2 0 1.5"), 16, "`1.5` is no whole number"),
            (text.replace("3 0 1 1\n", ""), 16, "ends here, expected 1 rows of `face`"),
            (text.replace("vertex 2", "vertex 99999999999999"), 17, "row of `vertex` has"),
            (text.replace("vertex 2", "vertex -2"), 6, "`-2` is no count"),
            (text.replace("property double y", "property text y"), 8, "`text` is no type"),
            (text.replace("property double y", "property double x"), 0, "two properties"),
            (text.replace("element vertex", "element corner"), 0, "no element `vertex`"),
            (text.replace("ascii", "morse"), 2, "`morse` is no format"),
            (text.replace("end_header\n", ""), 13, "is no line of a PLY file's head"),
            (HEAD.replace("end_header\n", ""), 0, "ends before `end_header`"),
        ] {
            let fault = read(file(text.as_bytes()).path(), 0).unwrap_err();
            assert!(fault.message.contains(message) && fault.line == line, "{fault} for\n{text}");
        }
        for is_big in [false, true] {
            let good = binary(is_big);
            for end in 0..good.len() {
                assert!(read(file(&good[..end]).path(), 0).is_err(), "{end}");
            }
            let lie = String::from_utf8_lossy(&good).contains("vertex 2");
            assert!(lie);
            mutated(&good, |_, path| drop(read(path, 0)));
        }
        mutated(text.as_bytes(), |_, path| drop(read(path, 0)));
    }

    #[test]
    fn counts_that_lie_take_no_memory() {
        let head = "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nproperty float x\nend_header\n\0\0\0\0";
        assert!(read(file(head.as_bytes()).path(), 0).unwrap_err().message.contains("truncated"));
        let empty = head
            .replace("element vertex", "element nothing 9999999999999\nelement vertex")
            .replace("18446744073709551615", "1");
        assert_eq!(read(file(empty.as_bytes()).path(), 0).unwrap().rows(), 1);
    }
}
