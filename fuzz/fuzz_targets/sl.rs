//! Any text as a shader, up to validated IR.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    let _ = render::sl::compile(Path::new("fuzz.sl"), text);
});
