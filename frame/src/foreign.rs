//! Formats of other programs that scree does not read as tables: found by their first bytes, and named with the way to a table.

use crate::{Fault, FaultKind};
use std::path::Path;

/// A format that is not read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Format {
    /// Its name, with an article.
    name: &'static str,
    /// How its files become tables.
    hint: &'static str,
    /// Endings of its files' names.
    endings: &'static [&'static str],
}

const PARAVIEW: &str =
    "in ParaView: File > Save Data, as CSV, with all time steps; then give the pattern of the CSV files, as 'p_*.csv'";
const MESH: &str =
    "a mesh is no table of rows: name it in a metadata file as `geometry: {archive: {file: …}}` (RIB or OBJ)";
const IMAGE: &str = "expected a table: a CSV file with a row for each particle";
const UNPACK: &str = "unpack it first; scree reads the CSV files themselves";
const SHEET: &str = "save the sheet as CSV (UTF-8) in the spreadsheet program";

const GRID: Format = Format { name: "a VTK file of a grid", hint: PARAVIEW, endings: &["vti", "vtr", "vts"] };
const HDF5: Format = Format {
    name: "an HDF5 file",
    hint: "write its tables as CSV, by Python: pandas.DataFrame(h5py.File(FILE)[NAME][:]).to_csv('p_0.csv', index=False)",
    endings: &["h5", "hdf5", "hdf"],
};
const NPY: Format = Format {
    name: "a NumPy array",
    hint: "write it as CSV, by Python: numpy.savetxt('p_0.csv', numpy.load(FILE), delimiter=',', header='x,y,z,radius')",
    endings: &["npy"],
};
const NPZ: Format = Format {
    name: "an archive of NumPy arrays",
    hint: "write one as CSV, by Python: numpy.savetxt('p_0.csv', numpy.load(FILE)[NAME], delimiter=',', header='x,y,z,radius')",
    endings: &["npz"],
};
const JSON: Format = Format {
    name: "JSON",
    hint: "write its rows as CSV, by Python: pandas.read_json(FILE).to_csv('p_0.csv', index=False)",
    endings: &["json", "jsonl"],
};
const STL: Format = Format { name: "an STL mesh", hint: MESH, endings: &["stl"] };
const OBJ: Format = Format { name: "a Wavefront OBJ mesh", hint: MESH, endings: &["obj"] };
const ARROW_STREAM: Format = Format {
    name: "an Arrow stream",
    hint: "write it as an Arrow file, by Python: pyarrow.feather.write_feather(pyarrow.ipc.open_stream(FILE).read_all(), 'p_0.feather')",
    endings: &["arrows"],
};
const LAMMPS_DATA: Format = Format {
    name: "a LAMMPS data file",
    hint: "write a dump, by LAMMPS: read_data FILE, then write_dump all custom p_0.dump id type x y z radius",
    endings: &[],
};
const YAML_DUMP: Format = Format {
    name: "YAML",
    hint: "of LAMMPS, `dump custom` without the ending .yaml writes a dump that is read",
    endings: &["yaml", "yml"],
};
const SERIES: Format = Format {
    name: "a ParaView series",
    hint: "give the pattern of the files that it lists, as 'p_*.vtk'",
    endings: &["series"],
};
const GLTF: Format = Format { name: "a glTF scene", hint: MESH, endings: &["glb", "gltf"] };
const TAR: Format = Format { name: "a tar archive", hint: UNPACK, endings: &["tar", "tgz"] };
const PACKED: Format = Format { name: "a compressed file", hint: UNPACK, endings: &["bz2", "xz", "zst", "7z"] };
const ZIP: Format = Format { name: "a zip archive", hint: UNPACK, endings: &["zip"] };
const XLSX: Format = Format { name: "an Excel workbook", hint: SHEET, endings: &["xlsx", "xlsm", "xls"] };
const ODS: Format = Format { name: "an OpenDocument file", hint: SHEET, endings: &["ods"] };
const MATLAB: Format =
    Format { name: "a MATLAB file", hint: "write its table in MATLAB by writetable(T, 'p_0.csv')", endings: &["mat"] };
const IMAGE_FILE: Format =
    Format { name: "an image", hint: IMAGE, endings: &["png", "jpg", "jpeg", "tif", "tiff", "exr", "bmp", "gif"] };
const PDF: Format = Format { name: "a PDF document", hint: IMAGE, endings: &["pdf"] };

/// All formats, for their endings.
const ALL: [Format; 19] = [
    ARROW_STREAM,
    SERIES,
    GLTF,
    GRID,
    HDF5,
    NPY,
    NPZ,
    JSON,
    STL,
    OBJ,
    TAR,
    PACKED,
    ZIP,
    XLSX,
    ODS,
    MATLAB,
    IMAGE_FILE,
    PDF,
    RIB,
];
const RIB: Format =
    Format { name: "a RIB scene", hint: "a scene is rendered as it is: scree render FILE", endings: &["rib", "ribz"] };

/// Formats by the bytes that all their files begin with.
const MAGIC: [(&[u8], Format); 20] = [
    (b"\xff\xff\xff\xff", ARROW_STREAM),
    (b"glTF", GLTF),
    (b"---\ncreator: LAMMPS", YAML_DUMP),
    (b"\x89HDF\r\n\x1a\n", HDF5),
    (b"\x93NUMPY", NPY),
    // What is packed by gzip once is unpacked before.
    (b"\x1f\x8b", PACKED),
    (b"BZh", PACKED),
    (b"\xfd7zXZ", PACKED),
    (b"\x28\xb5\x2f\xfd", PACKED),
    (b"7z\xbc\xaf", PACKED),
    (b"\xd0\xcf\x11\xe0", XLSX),
    (b"MATLAB ", MATLAB),
    (b"\x89PNG", IMAGE_FILE),
    (b"\xff\xd8\xff", IMAGE_FILE),
    (b"II*\0", IMAGE_FILE),
    (b"MM\0*", IMAGE_FILE),
    (b"\x76\x2f\x31\x01", IMAGE_FILE),
    (b"GIF8", IMAGE_FILE),
    (b"%PDF", PDF),
    (b"##RenderMan", RIB),
];

impl Format {
    /// The fault of a file of this format where a table was expected.
    pub fn fault(&self, path: &Path) -> Fault {
        Fault::whole(FaultKind::Data, path, format!("is {}, which scree does not read as a table", self.name))
            .hint(self.hint)
    }
}

/// The format of a file that is not a table, by its content.
pub fn by_content(bytes: &[u8]) -> Option<Format> {
    if let Some((_, format)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(*format);
    }
    let head = &bytes[..bytes.len().min(1 << 12)];
    let has = |what: &[u8]| head.windows(what.len()).any(|part| part == what);
    if bytes.starts_with(b"PK\x03\x04") {
        let names = [(&b"xl/"[..], XLSX), (b"[Content_Types].xml", XLSX), (b".npy", NPZ), (b"opendocument", ODS)];
        return Some(names.into_iter().find(|(name, _)| has(name)).map_or(ZIP, |(_, format)| format));
    }
    if bytes.get(257..262) == Some(b"ustar") {
        return Some(TAR);
    }
    if bytes.len() > 84 && is_binary_stl(bytes) {
        return Some(STL);
    }
    let text =
        std::str::from_utf8(head).unwrap_or_else(|e| std::str::from_utf8(&head[..e.valid_up_to()]).unwrap_or(""));
    let text = text.trim_start_matches(crate::text::MARK).trim_start();
    match text.as_bytes() {
        [b'{', ..] if text.contains("\"file-series-version\"") => Some(SERIES),
        [b'{', ..] => Some(JSON),
        [b'[', ..]
            if text[1..]
                .trim_start()
                .starts_with(['{', '[', '"', '-', '0', '1', '2', '3', '4', '5', '6', '7', '8', '9']) =>
        {
            Some(JSON)
        }
        _ if text.starts_with("solid") && text.contains("facet normal") => Some(STL),
        _ if is_obj(text) => Some(OBJ),
        _ if is_lammps_data(text) => Some(LAMMPS_DATA),
        _ => None,
    }
}

/// The format that the ending of a file's name stands for, if it is not one of tables.
pub fn by_ending(path: &Path) -> Option<Format> {
    let ending = path.extension()?.to_str()?.to_lowercase();
    ALL.into_iter().find(|format| format.endings.contains(&ending.as_str()))
}

/// The fault of a file that is not text from a byte on.
pub fn binary(path: &Path, at: usize) -> Fault {
    match by_ending(path) {
        Some(format) => format.fault(path),
        None => Fault::whole(FaultKind::Data, path, format!("is not text: byte {at} is of a binary file"))
            .hint("expected a table as text: CSV, in UTF-8, UTF-16 or Latin-1"),
    }
}

/// Whether the length is that of as many triangles as the file says.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let n = u32::from_le_bytes([bytes[80], bytes[81], bytes[82], bytes[83]]) as usize;
    bytes.len() == 84 + 50 * n && bytes[..84].contains(&0)
}

/// Whether the first line that places something is a vertex, `v 0.1 0.2 0.3`.
/// Whether a text begins as LAMMPS data files do: a line of any words, then counts of atoms (LAMMPS manual, `read_data`).
fn is_lammps_data(text: &str) -> bool {
    let mut lines = text.lines().skip(1).map(|line| line.split('#').next().unwrap_or("").trim());
    let first = lines.find(|line| !line.is_empty()).unwrap_or("");
    matches!(first.split_whitespace().collect::<Vec<_>>()[..], [count, "atoms"] if count.parse::<u64>().is_ok())
}

fn is_obj(text: &str) -> bool {
    let heads = ["#", "mtllib ", "o ", "g ", "usemtl ", "s "];
    let vertex = text.lines().map(str::trim).find(|l| !l.is_empty() && !heads.iter().any(|head| l.starts_with(head)));
    let mut words = vertex.unwrap_or("").split_whitespace();
    words.next() == Some("v") && words.next().is_some_and(|word| word.parse::<f64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_their_content() {
        for (bytes, expected) in [
            (&b"PK\x03\x04....xl/workbook.xml"[..], Some("an Excel workbook")),
            (b"PK\x03\x04....x.npy", Some("an archive of NumPy arrays")),
            (b"PK\x03\x04....x.txt", Some("a zip archive")),
            (b"\n[{\"x\": 1}]", Some("JSON")),
            (b"solid a\nfacet normal 0 0 1\n", Some("an STL mesh")),
            (b"# Blender\no Cube\nv 1 1 -1\n", Some("a Wavefront OBJ mesh")),
            (b"LAMMPS data file\n\n200 atoms\n1 atom types\n", Some("a LAMMPS data file")),
            (b"---\ncreator: LAMMPS\ntimestep: 0\n", Some("YAML")),
            (b"{\n  \"file-series-version\" : \"1.0\",", Some("a ParaView series")),
            (b"\xff\xff\xff\xff\x10\x01", Some("an Arrow stream")),
            (b"x,y\n1,2\n", None),
            (b"v x y z\n1 2 3 4\n", None),
            (b"2\n3\n4\n", None),
            (b"[m],x\n1,2\n", None),
        ] {
            assert_eq!(by_content(bytes).map(|f| f.name), expected, "{}", String::from_utf8_lossy(bytes));
        }
        assert_eq!(by_ending(Path::new("a.H5")), Some(HDF5));
        assert!(by_ending(Path::new("a.csv")).is_none() && binary(Path::new("a.dat"), 3).message.contains("byte 3"));
    }
}
