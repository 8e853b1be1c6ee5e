//! Wounded RIB and shaders for the readers: none may panic, hang or take the memory of the machine.
//!
//! `cargo bench -p render --bench mutate [-- N]`, N inputs (a million); the same ones every time.

use render::ri::files::Files;
use render::ri::reader;
use std::path::Path;
use std::time::Instant;

fn main() {
    let n = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    mutate(n.map_or(1_000_000, |n| n.parse().expect("a number of inputs")));
}

/// Feed wounded texts to the readers.
fn mutate(n: u64) {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/corpus");
    let all = |room: &str| -> Vec<Vec<u8>> {
        let files = std::fs::read_dir(corpus.join(room)).expect("the corpus").map(|e| e.expect("a file").path());
        let mut files: Vec<_> = files.filter(|f| !f.to_string_lossy().contains("run_program")).collect();
        files.sort();
        files.iter().map(|f| std::fs::read(f).expect("a file of the corpus")).collect()
    };
    let (ribs, shaders) = (all("rib"), all("shader"));
    let mut state = 7u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below.max(1)
    };
    let (mut sound, mut most, start) = (0u64, peak(), Instant::now());
    for i in 0..n {
        let texts = if i % 2 == 0 { &ribs } else { &shaders };
        let mut text = texts[random(texts.len())].clone();
        for _ in 0..1 + random(4) {
            let at = random(text.len());
            match random(6) {
                0 => text[at] = random(256) as u8,
                1 => text.truncate(at),
                2 => {
                    let other = &texts[random(texts.len())];
                    let (a, b) = (random(other.len()), random(other.len()));
                    let part = other[a.min(b)..a.max(b)].to_vec();
                    text.splice(at..at, part);
                }
                3 => {
                    let end = (at + random(20)).min(text.len());
                    text.drain(at..end);
                }
                4 => text.insert(at, b"0123456789[](){}\";,.-+*/#"[random(25)]),
                _ => {
                    let end = (at + random(40)).min(text.len());
                    let part = text[at..end].to_vec();
                    text.splice(at..at, part);
                }
            }
            if text.is_empty() {
                text.push(b'\n');
            }
        }
        // A wounded stream must not start programs.
        if text.windows(10).any(|w| w == b"RunProgram") {
            continue;
        }
        sound += if i % 2 == 0 {
            let mut context = render::Context::new(
                Files::default()
                    .with(&[("shaders/surface/defaultsurface.sl", "surface defaultsurface() { Ci = Cs; }")]),
            )
            .expect("a context");
            context.dry = true;
            reader::read(Path::new("m.rib"), &text, &Files::default(), &mut context, &mut |_, _| Ok(())).is_ok() as u64
        } else {
            let text = String::from_utf8_lossy(&text);
            render::sl::compile(Path::new("m.sl"), &text).is_ok() as u64
        };
        let now = peak();
        if now > most + 200_000 {
            println!(
                "input {i} took the peak to {} MB:\n{}",
                now / 1000,
                String::from_utf8_lossy(&text[..text.len().min(3000)])
            );
        }
        most = most.max(now);
        if start.elapsed().as_secs() > 0 && i % 100_000 == 99_999 {
            println!("{} inputs, {sound} sound, {:.0} s", i + 1, start.elapsed().as_secs_f64());
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{n} inputs, {sound} sound, {seconds:.0} s, at most {} MB: no panic", most / 1000);
}

/// The most memory that this process has had, kB; 0 where nobody says.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
