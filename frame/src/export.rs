//! Frames as files of other programs: VTU with PVD collections, Parquet, extended XYZ, PLY and CSV.

use crate::{Column, Frame, arrow, csv};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;
use std::fmt::Write;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// VTK's unstructured grid, XML with appended data: ParaView, VisIt.
    Vtu,
    /// Apache Parquet, zstd: pandas, Polars, DuckDB.
    Parquet,
    /// Extended XYZ: OVITO, ASE.
    Xyz,
    /// Stanford PLY, binary: Blender, MeshLab.
    Ply,
    /// CSV with units in the header, as scree reads it.
    Csv,
}

impl Format {
    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Vtu => "vtu",
            Format::Parquet => "parquet",
            Format::Xyz => "xyz",
            Format::Ply => "ply",
            Format::Csv => "csv",
        }
    }
}

/// A frame as the bytes of a file. An error says which columns it lacks.
pub fn encode(frame: &Frame, format: Format) -> Result<Vec<u8>, String> {
    match format {
        Format::Vtu => vtu(frame),
        Format::Parquet => parquet(frame),
        Format::Xyz => xyz(frame),
        Format::Ply => ply(frame),
        Format::Csv => Ok(csv::encode(frame).into_bytes()),
    }
}

/// The columns of positions, by the names that frames and most tables have.
fn positions(frame: &Frame) -> Result<[&Column; 3], String> {
    for names in [["pos_x", "pos_y", "pos_z"], ["x", "y", "z"], ["X", "Y", "Z"]] {
        let found = names.map(|name| frame.column(name).filter(|c| !matches!(c, Column::Category { .. })));
        if let [Some(x), Some(y), Some(z)] = found {
            return Ok([x, y, z]);
        }
    }
    Err(format!("has no columns pos_x, pos_y, pos_z or x, y, z of numbers, but {}", crate::listed(&frame.names())))
}

fn number(column: &Column, row: usize) -> f64 {
    column.number(row).unwrap_or(f64::NAN)
}

/// An array of a VTK file: its name, type, components and bytes.
struct Array {
    name: String,
    kind: &'static str,
    components: usize,
    bytes: Vec<u8>,
}

/// Columns that belong together: the name of all, and each of them.
struct Group<'a> {
    name: String,
    columns: Vec<&'a Column>,
}

/// The columns of a frame but for its positions, those of vectors together: `vel_x`, `vel_y` and `vel_z` are `vel`, `vx`, `vy` and `vz`
/// are `v`, and a quaternion is x, y, z and w.
fn groups<'a>(frame: &'a Frame, at: &[&Column; 3]) -> Vec<Group<'a>> {
    let mut joined: Vec<String> = vec![];
    let mut all = vec![];
    for (field, column) in &frame.columns {
        if at.iter().any(|own| std::ptr::eq(*own, column)) || joined.contains(&field.name) {
            continue;
        }
        let turn = ["x", "y", "z", "w"];
        let quaternion = field.name.strip_suffix("_w").and_then(|stem| together(frame, &format!("{stem}_"), &turn));
        let vector = || field.name.strip_suffix('x').and_then(|stem| together(frame, stem, &turn[..3]));
        match quaternion.or_else(vector) {
            Some((names, columns)) => {
                let name = names[0].trim_end_matches('x').trim_end_matches('_').to_string();
                joined.extend(names);
                all.push(Group { name, columns });
            }
            None => all.push(Group { name: field.name.clone(), columns: vec![column] }),
        }
    }
    all
}

/// The columns of real numbers whose names are a stem and an axis, if there is one for each axis.
fn together<'a>(frame: &'a Frame, stem: &str, axes: &[&str]) -> Option<(Vec<String>, Vec<&'a Column>)> {
    let names: Vec<String> = axes.iter().map(|axis| format!("{stem}{axis}")).collect();
    let is_real = |column: &&Column| matches!(column, Column::F32(_) | Column::F64(_));
    let columns: Option<Vec<&Column>> = names.iter().map(|name| frame.column(name).filter(is_real)).collect();
    (!stem.trim_end_matches('_').is_empty()).then_some((names, columns?))
}

/// The frame's columns but for its positions as arrays of points; words are whole numbers.
fn arrays(frame: &Frame, at: &[&Column; 3]) -> Vec<Array> {
    let array = |Group { name, columns }: Group<'_>| {
        let components = columns.len();
        let (kind, bytes): (&str, Vec<u8>) = match columns[0] {
            _ if components > 1 => {
                let rows = 0..columns[0].len();
                let row = |row: usize| columns.iter().flat_map(move |part| number(part, row).to_le_bytes());
                ("Float64", rows.flat_map(row).collect())
            }
            Column::F64(v) => ("Float64", v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Column::F32(v) => ("Float32", v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Column::I64(v) => ("Int64", v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Column::Category { codes, .. } => ("Int32", codes.iter().flat_map(|x| x.to_le_bytes()).collect()),
        };
        Array { name, kind, components, bytes }
    };
    groups(frame, at).into_iter().map(array).collect()
}

/// Text within an attribute of XML.
fn attribute(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c if c.is_control() => out.push('_'),
            c => out.push(c),
        }
    }
    out
}

/// A frame as a VTU file: each row is a point and a cell of it (VTK file formats, "XML file formats").
fn vtu(frame: &Frame) -> Result<Vec<u8>, String> {
    let at = positions(frame)?;
    let n = frame.rows();
    let points = (0..n).flat_map(|row| at.map(|column| number(column, row).to_le_bytes())).flatten().collect();
    let whole = |numbers: &mut dyn Iterator<Item = i64>| numbers.flat_map(i64::to_le_bytes).collect::<Vec<u8>>();
    let array = |name: &str, kind, components, bytes| Array { name: name.into(), kind, components, bytes };
    let mut body = vec![];
    let mut text = String::new();
    let mut write = |text: &mut String, own: &Array| {
        let (name, kind) = (attribute(&own.name), own.kind);
        let n = if own.components == 1 { String::new() } else { format!(" NumberOfComponents=\"{}\"", own.components) };
        let offset = body.len();
        let _ = writeln!(
            text,
            "        <DataArray type=\"{kind}\" Name=\"{name}\"{n} format=\"appended\" offset=\"{offset}\"/>"
        );
        body.extend((own.bytes.len() as u64).to_le_bytes());
        body.extend(&own.bytes);
    };
    let mut remarks = String::new();
    for (field, column) in &frame.columns {
        if let Column::Category { names, .. } = column {
            // As a remark: arrays of texts are known to VTK, but not to all that read its files.
            let words: Vec<String> = names.iter().enumerate().map(|(code, name)| format!("{code} {name}")).collect();
            let words = format!("{}: {}", field.name, words.join(", ")).replace("--", "- -");
            let _ = writeln!(remarks, "<!-- {} -->", attribute(&words));
        }
    }
    let _ = write!(text, "<?xml version=\"1.0\"?>\n{remarks}");
    text += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    let _ = writeln!(
        text,
        "  <UnstructuredGrid>\n    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>",
        frame.time
    );
    let _ =
        writeln!(text, "    </FieldData>\n    <Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{n}\">\n      <PointData>");
    arrays(frame, &at).iter().for_each(|own| write(&mut text, own));
    text += "      </PointData>\n      <Points>\n";
    write(&mut text, &array("Points", "Float64", 3, points));
    text += "      </Points>\n      <Cells>\n";
    let rows = n as i64;
    write(&mut text, &array("connectivity", "Int64", 1, whole(&mut (0..rows))));
    write(&mut text, &array("offsets", "Int64", 1, whole(&mut (1..=rows))));
    // VTK_VERTEX.
    write(&mut text, &array("types", "UInt8", 1, vec![1; n]));
    text += "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_";
    let mut bytes = text.into_bytes();
    bytes.extend(body);
    bytes.extend(b"\n  </AppendedData>\n</VTKFile>\n");
    Ok(bytes)
}

/// A collection of VTU files: their names and times, s.
pub fn collection(files: &[(String, f64)]) -> String {
    let mut text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  <Collection>\n"
            .to_string();
    for (file, time) in files {
        let _ = writeln!(text, "    <DataSet timestep=\"{time}\" group=\"\" part=\"0\" file=\"{}\"/>", attribute(file));
    }
    text + "  </Collection>\n</VTKFile>\n"
}

fn parquet(frame: &Frame) -> Result<Vec<u8>, String> {
    let batch = arrow::batch(frame);
    let options = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default())).build();
    let mut writer = ArrowWriter::try_new(vec![], batch.schema(), Some(options)).map_err(|e| e.to_string())?;
    writer.write(&batch).map_err(|e| e.to_string())?;
    writer.into_inner().map_err(|e| e.to_string())
}

/// A frame as extended XYZ, whose second line names the columns with their types and counts (OVITO manual, "XYZ file format"): names
/// that OVITO and ASE know are used for positions, velocities, sizes and orientations.
fn xyz(frame: &Frame) -> Result<Vec<u8>, String> {
    let at = positions(frame)?;
    let word =
        |text: &str| text.chars().map(|c| if c.is_whitespace() || c == ':' { '_' } else { c }).collect::<String>();
    let mut groups = groups(frame, &at);
    groups.insert(0, Group { name: "pos".into(), columns: at.to_vec() });
    if frame.column("radius").is_none()
        && let Some(column) = frame.column("half_x")
    {
        groups.insert(1, Group { name: "radius".into(), columns: vec![column] });
    }
    let mut properties: Vec<String> = vec![];
    for Group { name, columns } in &groups {
        let name = match (name.as_str(), columns.len()) {
            ("vel" | "v", 3) => "velo",
            ("quat", 4) => "orientation",
            ("half", 3) => "aspherical_shape",
            ("r", 1) => "radius",
            (name, _) => name,
        };
        let kind = match columns[0] {
            Column::F64(_) | Column::F32(_) => "R",
            Column::I64(_) => "I",
            Column::Category { .. } => "S",
        };
        properties.push(format!("{}:{kind}:{}", word(name), columns.len()));
    }
    let mut text = format!("{}\nProperties={} Time={}\n", frame.rows(), properties.join(":"), frame.time);
    for row in 0..frame.rows() {
        let columns = groups.iter().flat_map(|group| &group.columns);
        let cells = columns.map(|column| match column {
            Column::Category { .. } => Some(word(&column.text(row))).filter(|w| !w.is_empty()).unwrap_or("_".into()),
            Column::I64(v) => v[row].to_string(),
            Column::F32(v) => v[row].to_string(),
            Column::F64(v) => v[row].to_string(),
        });
        text += &cells.collect::<Vec<_>>().join(" ");
        text.push('\n');
    }
    Ok(text.into_bytes())
}

/// A frame as a PLY file: positions are `x`, `y`, `z`, other columns keep their names, words are whole numbers.
fn ply(frame: &Frame) -> Result<Vec<u8>, String> {
    let at = positions(frame)?;
    let is_position = |column: &Column| at.iter().any(|own| std::ptr::eq(*own, column));
    let others = || frame.columns.iter().filter(|(_, column)| !is_position(column));
    let mut text = format!(
        "ply\nformat binary_little_endian 1.0\ncomment frame {} time {}\nelement vertex {}\n",
        frame.number,
        frame.time,
        frame.rows()
    );
    text += "property double x\nproperty double y\nproperty double z\n";
    for (field, column) in others() {
        let kind = match column {
            Column::F64(_) => "double",
            Column::F32(_) => "float",
            Column::I64(_) | Column::Category { .. } => "int",
        };
        let name: String = field.name.chars().map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect();
        let _ = writeln!(text, "property {kind} {name}");
    }
    text += "end_header\n";
    let mut bytes = text.into_bytes();
    for row in 0..frame.rows() {
        at.iter().for_each(|column| bytes.extend(number(column, row).to_le_bytes()));
        for (field, column) in others() {
            match column {
                Column::F64(v) => bytes.extend(v[row].to_le_bytes()),
                Column::F32(v) => bytes.extend(v[row].to_le_bytes()),
                Column::I64(v) => {
                    let whole = i32::try_from(v[row]).map_err(|_| {
                        format!("`{}` has {}, and PLY has whole numbers of 32 bits", field.name, v[row])
                    })?;
                    bytes.extend(whole.to_le_bytes());
                }
                Column::Category { codes, .. } => bytes.extend(codes[row].to_le_bytes()),
            }
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table;

    fn frame() -> Frame {
        let mut frame = Frame::new(7, 0.5);
        frame.push("id", "", Column::I64(vec![3, 4]));
        frame.push("class", "", Column::Category { codes: vec![1, 0], names: vec!["a<b>".into(), "stone".into()] });
        for (k, name) in ["pos_x", "pos_y", "pos_z", "vel_x", "vel_y", "vel_z"].into_iter().enumerate() {
            frame.push(name, "m", Column::F64(vec![k as f64 + 0.25, -1.0 - k as f64]));
        }
        frame.push("half_x", "m", Column::F32(vec![0.5, 0.125]));
        frame
    }

    #[test]
    fn exports_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        for (format, x) in [(Format::Vtu, "x"), (Format::Ply, "x"), (Format::Parquet, "pos_x"), (Format::Csv, "pos_x")]
        {
            let path = folder.path().join(format!("f_7.{}", format.ending()));
            std::fs::write(&path, encode(&frame(), format).unwrap()).unwrap();
            let own = table::find(&path).unwrap()[&7].read(7, &Default::default()).unwrap();
            let numbers = |name: &str| [0, 1].map(|row| own.column(name).unwrap().number(row).unwrap());
            assert_eq!((own.rows(), numbers(x)), (2, [0.25, -1.0]), "{format:?}");
            assert_eq!((numbers("vel_y"), numbers("half_x"), numbers("id")), ([4.25, -5.0], [0.5, 0.125], [3.0, 4.0]));
            assert_eq!(own.time, if format == Format::Vtu { 0.5 } else { 0.0 });
        }
        std::fs::write(folder.path().join("f.pvd"), collection(&[("f_7.vtu".into(), 0.5)])).unwrap();
        let found = table::find(&folder.path().join("f.pvd")).unwrap();
        assert_eq!(found[&7].read(7, &Default::default()).unwrap().time, 0.5);
    }

    #[test]
    fn vectors_and_quaternions_stand_together() {
        let mut own = Frame::new(7, 0.5);
        let names = ["x", "y", "z", "vx", "vy", "vz", "quat_w", "quat_x", "quat_y", "quat_z", "max"];
        for (k, name) in names.into_iter().enumerate() {
            own.push(name, "", Column::F64(vec![k as f64]));
        }
        let at = positions(&own).unwrap();
        let found: Vec<(String, usize)> = groups(&own, &at).into_iter().map(|g| (g.name, g.columns.len())).collect();
        assert_eq!(found, [("v".to_string(), 3), ("quat".to_string(), 4), ("max".to_string(), 1)]);
        let text = String::from_utf8(encode(&own, Format::Xyz).unwrap()).unwrap();
        let head = "1\nProperties=pos:R:3:velo:R:3:orientation:R:4:max:R:1 Time=0.5\n";
        assert_eq!(text, format!("{head}0 1 2 3 4 5 7 8 9 6 10\n"));
    }

    #[test]
    fn what_lacks_positions_or_range_is_told() {
        let mut no_places = Frame::new(0, 0.0);
        no_places.push("speed", "", Column::F64(vec![1.0]));
        assert!(encode(&no_places, Format::Vtu).unwrap_err().contains("speed"));
        let mut large = frame();
        large.push("hash", "", Column::I64(vec![1, i64::MAX]));
        assert!(encode(&large, Format::Ply).unwrap_err().contains("`hash`"));
        assert!(encode(&Frame { columns: vec![], ..frame() }, Format::Csv).is_ok());
    }
}
