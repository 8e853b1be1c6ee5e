//! Any bytes as RIB, up to the renderer's calls.
#![no_main]

use libfuzzer_sys::fuzz_target;
use render::ri::files::Files;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    // Streams that start programs are not for this.
    if bytes.windows(10).any(|w| w == b"RunProgram") {
        return;
    }
    let surface = ("shaders/surface/defaultsurface.sl", "surface defaultsurface() { Ci = Cs; }");
    let files = Files::default().with(&[surface]);
    let mut context = render::Context::new(files.clone()).expect("a context");
    context.dry = true;
    let _ = render::ri::reader::read(Path::new("fuzz.rib"), bytes, &files, &mut context, &mut |_, _| Ok(None));
});
