//! The formats that scree reads, with sound samples of each, and the reader.

use bind::emit;
use frame::{Column, Frame};
use render::Context;
use render::ri::files::Files;
use render::ri::reader;
use sim::model_file;
use std::path::{Path, PathBuf};

use super::wounds::Random;

/// A format.
pub struct Format {
    /// Its name.
    pub name: &'static str,
    /// The ending of its files.
    pub ending: &'static str,
    /// Whether it is text.
    pub is_text: bool,
    /// Its part of all inputs.
    pub share: u64,
    /// Sound files, made with what the reader needs beside them in a folder.
    pub samples: fn(&Path) -> Vec<Vec<u8>>,
    /// Make a wound harder to see, as by a right hash.
    pub mend: Option<fn(&mut [u8], &mut Random)>,
    /// Read a file, given with its bytes; whether it is sound.
    pub read: fn(&Path, &[u8]) -> bool,
}

/// All formats. Reading a model or a metadata file resolves it, meshes and images are read as a model's terrain and as textures.
pub const FORMATS: [Format; 19] = [
    Format::text("rib", "rib", 240, |_| folder("tests/corpus/rib"), rib),
    Format::text("sl", "sl", 240, |_| folder("tests/corpus/shader"), sl),
    Format::text("model", "yaml", 60, models, |path, _| model(path)),
    Format::text("metadata", "yaml", 60, metadata, |path, _| read_metadata(path)),
    Format::text("job", "yml", 40, jobs, |path, _| read_metadata(path)),
    Format::text("csv", "csv", 120, |_| tables(), |path, _| frame::csv::read(path, 0, &Default::default()).is_ok()),
    Format::text("dump", "dump", 40, |_| dumps(), |path, _| dump(path)),
    Format::text("table", "tab", 60, |_| particles(), |path, _| dump(path)),
    Format::text("vtk", "vtk", 60, |_| vtk(), |path, _| dump(path)).binary(),
    Format::text("parquet", "parquet", 30, |_| sample(&["grains.parquet", "grains.feather"]), |path, _| dump(path))
        .binary(),
    Format::text("run_json", "json", 40, run_index, run_json),
    Format::text("obj", "obj", 30, obj, |path, _| model(&path.with_file_name("obj.yaml"))),
    Format::text("grid", "txt", 20, grid, |path, _| model(&path.with_file_name("grid.yaml"))),
    Format::text("problem", "dat", 20, |_| folder("tests/data/friction"), |path, _| sim::problem::read(path).is_ok()),
    Format::text("arrow", "arrow", 60, |_| vec![frame::arrow::encode(&table())], arrow).binary(),
    Format {
        mend: Some(hash),
        ..Format::text("checkpoint", "state", 30, checkpoint, |path, _| resumes(path)).binary()
    },
    Format::text("stl", "stl", 30, stl, |path, _| model(&path.with_file_name("stl.yaml"))).binary(),
    Format::text("png", "png", 5, |work| images(work, "png"), |path, _| image(path)).binary(),
    Format::text("exr", "exr", 5, |work| images(work, "exr"), |path, _| image(path)).binary(),
];

impl Format {
    /// A format of text, whose wounds show.
    const fn text(
        name: &'static str,
        ending: &'static str,
        share: u64,
        samples: fn(&Path) -> Vec<Vec<u8>>,
        read: fn(&Path, &[u8]) -> bool,
    ) -> Format {
        Format { name, ending, is_text: true, share, samples, mend: None, read }
    }

    /// The same of bytes that are no text.
    const fn binary(self) -> Format {
        Format { is_text: false, ..self }
    }
}

/// The files of a folder of the tree.
fn folder(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("a folder of the tree").map(|e| e.expect("a file").path()).collect();
    files.sort();
    files.iter().filter(|f| f.is_file()).map(|f| std::fs::read(f).expect("a file of the tree")).collect()
}

const SURFACE: (&str, &str) = ("shaders/surface/defaultsurface.sl", "surface defaultsurface() { Ci = Cs; }");

fn rib(_: &Path, text: &[u8]) -> bool {
    let mut context = Context::new(Files::default().with(&[SURFACE])).expect("a context");
    context.dry = true;
    reader::read(Path::new("m.rib"), text, &Files::default(), &mut context, &mut |_, _| Ok(None)).is_ok()
}

fn sl(_: &Path, text: &[u8]) -> bool {
    render::sl::compile(Path::new("m.sl"), &String::from_utf8_lossy(text)).is_ok()
}

/// What every model here begins with.
const MODEL: &str = "step: 0.01\nduration: 0.1\nframe_rate: 50\nmaterials: {m: {density: 1000, friction: 0.5}}\n";

fn models(_: &Path) -> Vec<Vec<u8>> {
    let bodies = "bodies:\n  - {name: a, material: m, sphere: {radius: 0.1}, position: [0, 0, 1]}\n  - {name: b, material: m, box: {size: [0.1, 0.2, 0.3]}, position: [1, 0, 1], velocity: [1, 0, 0]}\n  - {name: g, material: m, plane: {normal: [0, 0, 1]}, fixed: true}\n";
    let more = "joints: [{name: j, kind: revolute, a: a, b: b, position: [0, 0, 1], axis: [0, 1, 0]}]\nfills: [{name: f, material: m, count: 20, radius: [0.04, 0.05], min: [0, 0, 2], max: [1, 1, 3]}]\nprobes: {interval: 0.01, bodies: [a], joints: [j]}\nsweep: {step: [0.01, 0.02]}\n";
    let mut all = vec![format!("{MODEL}{bodies}").into_bytes(), format!("{MODEL}{bodies}{more}").into_bytes()];
    all.extend(folder("tests/corpus/broken/model"));
    all.extend(folder("sim/models").into_iter().filter(|text| text.len() < 2500));
    all
}

/// Whether a model is sound. What it reads lies beside it.
fn model(path: &Path) -> bool {
    model_file::load(path, &[]).and_then(|(file, doc)| file.resolve(&doc)).is_ok()
}

fn metadata(work: &Path) -> Vec<Vec<u8>> {
    std::fs::write(work.join("p_0.csv"), "id,x,y,z,r,kind\n1,0,0,0,0.1,a\n2,1,0,2,0.2,b\n").expect("a table");
    let head =
        "data: {csv: 'p_*.csv', derive: [{column: d, formula: sqrt(x**2 + y**2)}], select: r > 0}\nscene: studio.rib\n";
    let sphere = "objects:\n  - name: a\n    select: kind == 'a' and x < 3\n    position: [x, y, \"z + 0.5\"]\n    geometry: {sphere: {radius: \"r * 2\"}}\n    surface: {name: plastic, Kd: 0.5}\n    color: {column: d, map: viridis, range: [0, 1]}\n";
    let rest =
        "camera: {eye: [0, -5, 0], look_at: [0, 0, 0]}\noutput: {resolution: [64, 48], frames: 0-9, format: png}\n";
    let mut all = vec![format!("{head}{rest}{sphere}").into_bytes()];
    all.extend(folder("tests/corpus/broken/metadata"));
    all
}

/// Whether a metadata file is sound, with its data.
fn read_metadata(path: &Path) -> bool {
    let Ok(binding) = bind::read(path) else { return false };
    let Ok(source) = binding.open_data() else { return false };
    let numbers = source.numbers();
    let Some(table) = numbers.first().and_then(|n| source.read(*n).ok()) else { return false };
    binding.check_columns(&table).is_ok() && emit::check(&binding, &bind::Moment::alone(&table)).is_ok()
}

fn jobs(work: &Path) -> Vec<Vec<u8>> {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/chronorender");
    std::fs::create_dir_all(work.join("data")).expect("a folder");
    for part in ["", "data"] {
        for file in std::fs::read_dir(from.join(part)).expect("a folder of the tree").flatten() {
            let goal = work.join(part).join(file.file_name());
            if file.path().is_file() {
                std::fs::copy(file.path(), goal).expect("a copy");
            }
        }
    }
    ["plain.yml", "passes.yml"].map(|name| std::fs::read(from.join(name)).expect("a job")).to_vec()
}

fn tables() -> Vec<Vec<u8>> {
    let own = [
        "id,x [m],y [m],z [m],name\n1,0.5,1e-3,-2,\"a, b\"\n2,1,,3,\"c\"\"d\"\n",
        "# id x y z\n1 0 0 0\n2 1.5 2 3\n",
        "a;b\n1,5;2,5\n3,25;4\n",
        "\u{feff}X\tY\tZ\n1D+3\t2\t3\n",
        "1,2,3\n4,5,6\n",
    ];
    let mut all: Vec<Vec<u8>> = own.iter().map(|text| text.as_bytes().to_vec()).collect();
    all.extend(folder("tests/data/foreign").into_iter().filter(|file| file.len() < 20_000));
    all
}

/// Files of other programs that the tree has.
fn sample(names: &[&str]) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/foreign");
    names.iter().map(|name| std::fs::read(folder.join(name)).expect("a table of the tree")).collect()
}

/// XYZ, PLY, MercuryDPM, Chrono and YADE.
fn particles() -> Vec<Vec<u8>> {
    let texts = [
        "2\nAtoms. Timestep: 5\n1 0.1 0.2 0.3\n2 0.4 0.5 0.6\n1\nAtoms. Timestep: 6\n1 0.1 0.2 0.3\n",
        "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:radius:R:1 Time=0.5\nH 0.1 0.2 0.3 0.05\n",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0.5\n3 0 1 0\n",
        "1 0.25 0 0 0 1 1 1\n0.5 0.5 0.5 0 0 -1 0.1 0 0 0 0 0 0 0\n",
    ];
    texts.iter().map(|text| text.as_bytes().to_vec()).chain(sample(&["yade_000.txt"])).collect()
}

/// VTK: legacy as text and binary, XML as text, in base64 and appended.
fn vtk() -> Vec<Vec<u8>> {
    let head = "# vtk DataFile Version 3.0\np\nBINARY\nDATASET POLYDATA\nPOINTS 2 float\n";
    let numbers = |n: usize| (0..n).flat_map(|k| (k as f32 * 0.5).to_be_bytes()).collect::<Vec<u8>>();
    let binary = [head.as_bytes(), &numbers(6), b"\nPOINT_DATA 2\nVECTORS v float\n", &numbers(6), b"\n"].concat();
    let xml = |points: &str, after: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt32\"><UnstructuredGrid><Piece NumberOfPoints=\"2\" NumberOfCells=\"0\"><PointData>\
             <DataArray type=\"Float32\" Name=\"radius\" format=\"ascii\">0.1 0.2</DataArray></PointData><Points>{points}\
             </Points></Piece></UnstructuredGrid>{after}</VTKFile>\n"
        )
        .into_bytes()
    };
    let array = |format: &str, text: &str| {
        format!("<DataArray type=\"Float32\" NumberOfComponents=\"3\" {format}>{text}</DataArray>")
    };
    let appended = [24u32.to_le_bytes().to_vec(), vec![0; 24]].concat();
    let mut raw =
        xml(&array("format=\"appended\" offset=\"0\"", ""), "<AppendedData encoding=\"raw\">_@</AppendedData>");
    let at = raw.iter().position(|b| *b == b'@').expect("the mark");
    raw.splice(at..=at, appended);
    let base64 = "GAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA==";
    let mut all = sample(&["part100.vtk"]);
    all.extend([
        binary,
        xml(&array("format=\"ascii\"", "0 0 0 1 0 0"), ""),
        xml(&array("format=\"binary\"", base64), ""),
        raw,
    ]);
    all
}

fn dumps() -> Vec<Vec<u8>> {
    let own = sample(&["dump100.fill"]).remove(0);
    let tilted = "ITEM: TIMESTEP\n7\nITEM: TIME\n0.5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp pp\n-1 3 2\n0 5 0\n2 3 1\nITEM: ATOMS id xs ys zs\n1 0 0.5 1\n2 1 0.25 0\n";
    vec![[&own[..], tilted.as_bytes()].concat(), own]
}

/// Read all tables of a file.
fn dump(path: &Path) -> bool {
    let read = |(number, table): (u64, frame::table::Stored)| table.read(number, &Default::default()).is_ok();
    frame::table::find(path).is_ok_and(|found| found.into_iter().map(read).fold(true, |all, one| all & one))
}

/// A frame as a run has it.
fn table() -> Frame {
    let mut frame = Frame::new(3, 0.25);
    let words = |words: [&str; 2]| Column::Category { codes: vec![0, 1, 0], names: words.map(String::from).to_vec() };
    frame.push("id", "1", Column::I64(vec![1, 2, 3]));
    frame.push("class", "", words(["stone", "wheel"]));
    frame.push("pos_x", "m", Column::F64(vec![0.0, 1.0, 2.0]));
    frame.push("speed", "m/s", Column::F32(vec![0.5, 1.0, 2.0]));
    frame
}

fn arrow(path: &Path, bytes: &[u8]) -> bool {
    frame::arrow::decode(path, bytes.to_vec(), 0).is_ok()
}

fn run_index(work: &Path) -> Vec<Vec<u8>> {
    let run = work.join("run");
    simulate(work, &run);
    vec![std::fs::read(run.join("run.json")).expect("the run's index")]
}

fn run_json(path: &Path, bytes: &[u8]) -> bool {
    let run = path.with_file_name("run");
    std::fs::write(run.join("run.json"), bytes).expect("an index");
    let Ok(run) = frame::run::RunReader::open(&run) else { return false };
    run.numbers().first().is_some_and(|n| run.read_frame(*n).is_ok())
}

/// Simulate a ball into a run directory.
fn simulate(work: &Path, run: &Path) {
    struct Quiet;
    impl sim::run::Observer for Quiet {}
    let path = work.join("ball.yaml");
    let text = "checkpoint_interval: 0.05\nbodies: [{name: a, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.1]}, {name: g, material: m, plane: {normal: [0, 0, 1]}}]\n";
    std::fs::write(&path, format!("{MODEL}{text}")).expect("a model");
    let (file, resolved) = model_file::read(&path).expect("the model is sound");
    let span = sim::run::Span { until: None, resume: false };
    assert!(
        sim::run::simulate(&file, resolved, run, (&span, &Default::default()), &mut Quiet).is_ok(),
        "the model runs"
    );
}

fn checkpoint(work: &Path) -> Vec<Vec<u8>> {
    let run = work.join("checkpoints_of");
    simulate(work, &run);
    let path = sim::checkpoint::latest(&run).expect("a run").expect("a checkpoint");
    vec![std::fs::read(path).expect("a checkpoint")]
}

/// Go on from a checkpoint for a few steps, as a run that is resumed does.
fn resumes(path: &Path) -> bool {
    let (_, resolved) = model_file::read(&path.with_file_name("ball.yaml")).expect("the model is sound");
    let Ok((state, _)) = sim::checkpoint::read(path) else { return false };
    if state.fit(&resolved.model).is_err() {
        return false;
    }
    let mut sim = sim::Simulation::new(resolved.model, state);
    (0..3).all(|_| sim.step().broken.is_none())
}

/// Give most checkpoints the hash of what they hold.
fn hash(bytes: &mut [u8], random: &mut Random) {
    let Some(head) = bytes.iter().position(|b| *b == b'\n').map(|k| k + 1) else { return };
    if random.below(8) > 0 && bytes.len() > head + 32 {
        let hash = *blake3::hash(&bytes[head + 32..]).as_bytes();
        bytes[head..head + 32].copy_from_slice(&hash);
    }
}

/// Write the model `name`.yaml with a body of this shape.
fn body(work: &Path, name: &str, shape: &str) {
    let text = format!("{MODEL}bodies: [{{name: a, material: m, fixed: true, {shape}}}]\n");
    std::fs::write(work.join(format!("{name}.yaml")), text).expect("a model");
}

fn obj(work: &Path) -> Vec<Vec<u8>> {
    body(work, "obj", "mesh: {file: wounded.obj}");
    let text = "mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvt 0 0\nusemtl x\nf 1/1/1 3/1/1 2/1/1\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf -4 -3 -2 -1\n";
    vec![text.into()]
}

fn grid(work: &Path) -> Vec<Vec<u8>> {
    body(work, "grid", "height_field: {grid: wounded.txt, size: [2, 2], height: [0, 1]}");
    vec![b"# heights\n0 0.1 0.2\n0.1 0.2 0.3\n0.5 0.4 0.3\n".to_vec(), b"0,1\n2,3\n".to_vec()]
}

fn stl(work: &Path) -> Vec<Vec<u8>> {
    body(work, "stl", "mesh: {file: wounded.stl}");
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut binary = vec![b' '; 80];
    binary.extend(4u32.to_le_bytes());
    let mut ascii = "solid a\n".to_string();
    for face in faces {
        binary.extend([0; 12]);
        ascii += "facet normal 0 0 0\nouter loop\n";
        for corner in face.map(|k: usize| corners[k]) {
            corner.iter().for_each(|x| binary.extend(x.to_le_bytes()));
            ascii += &format!("vertex {} {} {}\n", corner[0], corner[1], corner[2]);
        }
        binary.extend([0; 2]);
        ascii += "endloop\nendfacet\n";
    }
    vec![binary, format!("{ascii}endsolid a\n").into()]
}

/// Images of a kind, and of TIFF beside PNG: a reader looks at what a file holds rather than at its name.
fn images(work: &Path, ending: &str) -> Vec<Vec<u8>> {
    body(
        work,
        &format!("image_{ending}"),
        &format!("height_field: {{image: wounded.{ending}, size: [2, 2], height: [0, 1]}}"),
    );
    let rib = format!(
        "Format 4 4 1\nDisplay \"a.png\" \"file\" \"rgb\"\nWorldBegin\nSurface \"paint\" \"string name\" [\"wounded.{ending}\"]\nSphere 1 -1 1 360\nWorldEnd\n"
    );
    std::fs::write(work.join(format!("image_{ending}.rib")), rib).expect("a scene");
    let pixel = |x: u32, y: u32| image::Rgb([x as f32 / 9.0, y as f32 / 7.0, 0.5]);
    let floats = image::DynamicImage::ImageRgb32F(image::ImageBuffer::from_fn(9, 7, pixel));
    let formats = match ending {
        "exr" => vec![image::ImageFormat::OpenExr],
        _ => vec![image::ImageFormat::Png, image::ImageFormat::Tiff],
    };
    let encode = |format: image::ImageFormat| {
        let mut bytes = std::io::Cursor::new(vec![]);
        let whole = if ending == "exr" { floats.clone() } else { image::DynamicImage::ImageRgb8(floats.to_rgb8()) };
        whole.write_to(&mut bytes, format).expect("an image");
        bytes.into_inner()
    };
    formats.into_iter().map(encode).collect()
}

/// Read an image as a terrain, and as a texture of a scene.
fn image(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let is_terrain = model(&path.with_file_name(format!("image_{ending}.yaml")));
    const PAINT: (&str, &str) =
        ("shaders/surface/paint.sl", "surface paint(string name = \"\") { Ci = color texture(name); Oi = 1; }");
    let folder = path.parent().expect("a folder").to_path_buf();
    let files = Files { folders: vec![folder], ..Files::default() }.with(&[SURFACE, PAINT]);
    let scene = path.with_file_name(format!("image_{ending}.rib"));
    let rib = std::fs::read(&scene).expect("the scene");
    let mut context = Context::new(files.clone()).expect("a context");
    let is_read = reader::read(&scene, &rib, &files, &mut context, &mut |_, _| Ok(None)).is_ok();
    let warned = context.results.iter().any(|image| !image.warnings.is_empty());
    is_terrain && is_read && !warned
}
