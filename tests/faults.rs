//! Any text at all is answered, never with a panic or a hang: sound files with pieces cut out, doubled, swapped and overwritten.

use proptest::prelude::*;
use render::ri::files::Files;
use std::path::{Path, PathBuf};

/// A sound text with a few wounds: (where, how long, what happens).
fn wounded(text: &str, wounds: &[(usize, usize, u8)]) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for (at, length, what) in wounds {
        if chars.is_empty() {
            break;
        }
        let start = at % chars.len();
        let end = (start + length % 40).min(chars.len());
        match what % 5 {
            0 => drop(chars.drain(start..end)),
            1 => {
                let piece: Vec<char> = chars[start..end].to_vec();
                chars.splice(start..start, piece);
            }
            2 => chars.truncate(start),
            3 => chars[start..end].reverse(),
            _ => {
                let strange = ['"', '[', ']', '{', '}', '-', '9', 'e', '\0', 'é', '(', '#', '\n', ':'];
                chars[start] = strange[length % strange.len()];
            }
        }
    }
    chars.into_iter().collect()
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap()
}

fn wounds() -> impl Strategy<Value = Vec<(usize, usize, u8)>> {
    prop::collection::vec((any::<usize>(), any::<usize>(), any::<u8>()), 1..6)
}

const RIB: &str = r#"##RenderMan RIB
Format 32 24 1 PixelFilter "gaussian" 2 2 Projection "perspective" "fov" [30]
Declare "tint" "uniform color"
WorldBegin
LightSource "distantlight" 1 "intensity" [1] "to" [0 0 1]
AttributeBegin Surface "plastic" "Kd" [0.5] Color [1 0 0] Translate 0 0 5 Sphere 1 -1 1 360 AttributeEnd
Polygon "P" [0 0 1 1 0 1 1 1 1] PointsPolygons [3 3] [0 1 2 0 2 3] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
Basis "bezier" 3 "bezier" 3 Patch "bilinear" "P" [0 0 1 1 0 1 0 1 1 1 1 1]
ObjectBegin 1 Sphere 1 -1 0.5 270 ObjectEnd ObjectInstance 1
WorldEnd
"#;

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rib(w in wounds()) {
        let files = Files { folders: vec![root()], ..Files::default() };
        let mut context = render::Context::new(files.clone()).unwrap();
        context.dry = true;
        let _ = render::ri::reader::read(Path::new("t.rib"), wounded(RIB, &w).as_bytes(), &files, &mut context, &mut |_, _| Ok(None));
    }

    #[test]
    fn shaders(w in wounds(), which in 0usize..4) {
        let name = ["surface/gravel", "surface/ground", "displacement/rock", "light/distantlight"][which];
        let _ = render::sl::compile(Path::new("t.sl"), &wounded(&text(&format!("shaders/{name}.sl")), &w));
    }

    #[test]
    fn models(w in wounds()) {
        let source = wounded(&text("sim/models/pour.yaml"), &w);
        if let Ok((file, doc)) = frame::yaml::parse::<sim::model_file::ModelFile>(Path::new("t.yaml"), source) {
            // A count that a wound has made astronomic must be refused, not filled.
            let _ = file.resolve(&doc);
        }
    }

    #[test]
    fn metadata(w in wounds()) {
        let source = wounded(&text("metadata/quickstart.yaml"), &w);
        if let Ok((metadata, doc)) = frame::yaml::parse::<bind::Metadata>(Path::new("t.yaml"), source) {
            let _ = bind::metadata::check(metadata, doc);
        }
    }

    #[test]
    fn tables(w in wounds()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, wounded("x;y;z [m];kind\n1;2;3;stone\n4;5.5;-6e-3;wall\n7;8;9;stone\n", &w)).unwrap();
        let _ = frame::csv::read(&path, 0, &frame::csv::Layout::default());
    }
}
