//! `scree movie`: kinds of movies, their colors and sizes as ffmpeg decodes them, and what is refused.

use crate::cli::{scratch, scree, scree_with};
use image::{DynamicImage, Rgb, RgbImage};
use std::path::Path;
use std::process::{Command, Stdio};

/// Whether ffmpeg is there, to encode and to look at what was encoded.
fn has_ffmpeg() -> bool {
    let there = Command::new("ffprobe").arg("-version").output().is_ok_and(|o| o.status.success());
    if !there {
        eprintln!("skipped: ffmpeg is not on PATH");
    }
    there
}

/// Write images of these sizes and colors as frames 0, 1, 2, …
fn write_images(folder: &Path, images: &[([u32; 2], [u8; 3])]) {
    std::fs::create_dir_all(folder).unwrap();
    for (i, ([width, height], color)) in images.iter().enumerate() {
        let image = RgbImage::from_pixel(*width, *height, Rgb(*color));
        image.save(folder.join(format!("{i:06}.png"))).unwrap();
    }
}

const RED: ([u32; 2], [u8; 3]) = ([32, 18], [255, 0, 0]);
const GREY: ([u32; 2], [u8; 3]) = ([32, 18], [128, 128, 128]);

fn probe(movie: &Path, entries: &str) -> String {
    let args = ["-v", "error", "-count_frames", "-select_streams", "v", "-of", "csv=p=0", "-show_entries"];
    let output = Command::new("ffprobe").args(args).arg(entries).arg(movie).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().trim().trim_end_matches(',').to_string()
}

/// The pixels of all frames of a movie, red, green and blue.
fn decode(movie: &Path) -> Vec<[u8; 3]> {
    let args = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-sws_flags", "accurate_rnd+full_chroma_int", "-"];
    let output = Command::new("ffmpeg").args(["-v", "error", "-i"]).arg(movie).args(args).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.chunks(3).map(|p| [p[0], p[1], p[2]]).collect()
}

fn movie(folder: &Path, more: &[&str]) -> String {
    let args = [&["movie", folder.to_str().unwrap()], more].concat();
    scree(&args).ok().trim().to_string()
}

/// The greatest difference of any color of these pixels from `color`.
fn worst(pixels: &[[u8; 3]], color: [u8; 3]) -> u8 {
    pixels.iter().flat_map(|p| p.iter().zip(&color).map(|(a, b)| a.abs_diff(*b))).max().unwrap()
}

#[test]
fn the_ending_chooses_the_kind_of_movie() {
    if !has_ffmpeg() {
        return;
    }
    let work = scratch();
    let images = work.path().join("images");
    write_images(&images, &[RED, GREY, RED]);
    for (ending, expected) in [
        ("mp4", "h264,32,18"),
        ("mov", "h264,32,18"),
        ("mkv", "h264,32,18"),
        ("webm", "vp9,32,18"),
        ("gif", "gif,32,18"),
        ("GIF", "gif,32,18"),
        ("apng", "apng,32,18"),
    ] {
        let out = work.path().join(format!("out/m.{ending}"));
        assert_eq!(movie(&images, &["-o", out.to_str().unwrap()]), out.to_str().unwrap());
        let found = probe(&out, "stream=codec_name,width,height,nb_read_frames");
        assert_eq!(found, format!("{expected},3"), "{ending}");
    }
    let png = work.path().join("m.png");
    movie(&images, &["-o", png.to_str().unwrap()]);
    assert!(std::fs::read(&png).unwrap().windows(4).any(|w| w == b"acTL"), "an animated PNG");
    // What is no ending is kept.
    let plain = work.path().join("friction=0.3");
    assert_eq!(movie(&images, &["-o", plain.to_str().unwrap()]), format!("{}.mp4", plain.display()));
}

#[test]
fn movies_that_cannot_be_are_refused_before_any_work() {
    let work = scratch();
    let images = work.path().join("images");
    write_images(&images, &[RED, ([30, 18], [0, 0, 0])]);
    let images = images.to_str().unwrap();
    let refused = scree(&["movie", images, "-o", "x.avi"]).fails(2);
    assert!(refused.contains("`.avi` is no kind of movie") && refused.contains(".webm, .gif"), "{refused}");
    assert!(scree(&["movie", images, "-o", "x.gif", "--frame-rate", "60"]).fails(2).contains("at most 50"));
    assert!(scree(&["movie", images, "-o", "runs/"]).fails(2).contains("is a folder; name the movie's file"));
    let inside = format!("{images}/movie.png");
    assert!(scree(&["movie", images, "-o", &inside]).fails(2).contains("one of the images of its folder"));
}

#[test]
fn folders_without_images_are_named() {
    let work = scratch();
    let said = |folder: &Path| scree(&["movie", folder.to_str().unwrap()]).fails(4);
    assert!(said(&work.path().join("nowhere")).contains("does not exist"));
    let file = work.path().join("file.png");
    std::fs::write(&file, "").unwrap();
    assert!(said(&file).contains("is a file; expected the folder"));
    let empty = work.path().join("run");
    std::fs::create_dir(&empty).unwrap();
    assert!(said(&empty).contains("has no PNG images"));
    write_images(&empty.join("images"), &[RED]);
    assert!(said(&empty).contains("`scree movie ") && said(&empty).contains("run/images`"));
    let exr = work.path().join("exr");
    std::fs::create_dir(&exr).unwrap();
    std::fs::write(exr.join("000000.exr"), "").unwrap();
    let message = said(&exr);
    assert!(message.contains("1 EXR images") && message.contains("format: png"), "{message}");
    let mixed = work.path().join("mixed");
    write_images(&mixed, &[RED, ([30, 18], [0, 0, 0])]);
    assert!(said(&mixed).contains("000001.png: is 30×18 pixels, the first image, 000000.png, is 32×18"));
}

#[test]
fn every_folder_has_a_default_movie_of_its_own() {
    let work = scratch();
    let run = work.path().join("a");
    for (folder, expected) in [("images", "a"), ("wide", "wide"), ("images/depth", "images/depth")] {
        write_images(&run.join(folder), &[RED]);
        let made = movie(&run.join(folder), &[]);
        assert_eq!(Path::new(&made).with_extension(""), run.join(expected));
    }
}

#[test]
fn colors_are_those_of_the_images_and_tagged() {
    if !has_ffmpeg() {
        return;
    }
    let work = scratch();
    for (i, color) in [[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128], [40, 90, 200]].into_iter().enumerate() {
        let images = work.path().join(format!("{i}"));
        write_images(&images, &[([64, 48], color); 2]);
        for ending in ["mp4", "webm", "gif", "apng"] {
            let out = work.path().join(format!("{i}.{ending}"));
            movie(&images, &["-o", out.to_str().unwrap()]);
            let off = worst(&decode(&out), color);
            assert!(off <= 3, "{ending}: {color:?} is off by {off}");
        }
    }
    for ending in ["mp4", "webm"] {
        let tags = probe(
            &work.path().join(format!("0.{ending}")),
            "stream=pix_fmt,color_range,color_space,color_transfer,color_primaries",
        );
        assert_eq!(tags, "yuv420p,tv,bt709,bt709,bt709", "{ending}");
    }
}

#[test]
fn odd_sizes_repeat_their_own_edge() {
    if !has_ffmpeg() {
        return;
    }
    let work = scratch();
    let images = work.path().join("images");
    write_images(&images, &[([33, 17], [210, 60, 40]); 2]);
    for (ending, size) in [("mp4", "34,18"), ("webm", "34,18"), ("gif", "33,17"), ("apng", "33,17")] {
        let out = work.path().join(format!("m.{ending}"));
        movie(&images, &["-o", out.to_str().unwrap()]);
        assert_eq!(probe(&out, "stream=width,height"), size, "{ending}");
        let off = worst(&decode(&out), [210, 60, 40]);
        assert!(off <= 3, "{ending}: a line at the edge, off by {off}");
    }
}

#[test]
fn gaps_are_named_or_kept() {
    let work = scratch();
    let images = work.path().join("images");
    write_images(&images, &[RED, RED, RED, RED, RED, RED]);
    for frame in [2, 3] {
        std::fs::remove_file(images.join(format!("{frame:06}.png"))).unwrap();
    }
    let out = work.path().join("m.apng");
    let args = ["movie", images.to_str().unwrap(), "-o", out.to_str().unwrap()];
    let refused = scree(&args).fails(4);
    assert!(refused.contains("2 images are missing between the others: frames 2-3"), "{refused}");
    assert!(refused.contains("scree render") && refused.contains("--keep-gaps"), "{refused}");
    let kept = scree(&[&args[..], &["--keep-gaps"]].concat());
    kept.ok();
    assert!(kept.errors().contains("2 images are missing and skipped"), "{}", kept.errors());
    assert!(kept.errors().contains("encoding: 0 of 4 images"), "{}", kept.errors());
}

#[test]
fn images_of_any_channels_and_bits_go_into_one_movie() {
    if !has_ffmpeg() {
        return;
    }
    let work = scratch();
    let images = work.path().join("images");
    std::fs::create_dir(&images).unwrap();
    let grey = |v: u16| image::ImageBuffer::from_pixel(32, 18, image::Luma([v]));
    DynamicImage::ImageLuma16(grey(128 * 257)).save(images.join("000000.png")).unwrap();
    let deep = image::ImageBuffer::from_pixel(32, 18, image::Rgb([128u16 * 257; 3]));
    DynamicImage::ImageRgb16(deep).save(images.join("000001.png")).unwrap();
    let half = image::ImageBuffer::from_pixel(32, 18, image::Rgba([128u8, 128, 128, 140]));
    DynamicImage::ImageRgba8(half).save(images.join("000002.png")).unwrap();
    for ending in ["mp4", "apng"] {
        let out = work.path().join(format!("m.{ending}"));
        movie(&images, &["-o", out.to_str().unwrap()]);
        let pixels = decode(&out);
        assert_eq!(pixels.len(), 3 * 32 * 18);
        assert!(worst(&pixels, [128; 3]) <= 3, "{ending}: {}", worst(&pixels, [128; 3]));
    }
}

/// A folder with a program `ffmpeg` that answers which encoders it has, and else does what `body` says.
#[cfg(unix)]
fn fake_ffmpeg(folder: &Path, encoders: &str, body: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    std::fs::create_dir_all(folder).unwrap();
    let program = folder.join("ffmpeg");
    let text = format!(
        "#!/bin/sh\ncase \"$*\" in *-encoders*) echo ' V....D {encoders} x'; exit;; *-version*) echo fake; exit;; esac\n{body}\n"
    );
    std::fs::write(&program, text).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    format!("{}:/usr/bin:/bin", folder.display())
}

#[test]
#[cfg(unix)]
fn without_ffmpeg_or_an_encoder_only_animated_pngs_are_made() {
    let work = scratch();
    let images = work.path().join("images");
    write_images(&images, &[RED, GREY]);
    let out = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let call = |path: &str, out: &str| scree_with(&[("PATH", path)], &["movie", images.to_str().unwrap(), "-o", out]);
    for ending in ["mp4", "gif", "webm"] {
        let refused = call("/nowhere", &out(&format!("m.{ending}"))).fails(1);
        assert!(refused.contains("apt-get install ffmpeg") && refused.contains("m.apng"), "{refused}");
    }
    call("/nowhere", &out("m.apng")).ok();
    assert_eq!(call("/nowhere", &out("plain")).ok().trim(), out("plain.apng"));
    let path = fake_ffmpeg(&work.path().join("few"), "libx264", "exit 1");
    let refused = call(&path, &out("m.webm")).fails(1);
    assert!(refused.contains("no encoder for VP9 or AV1 (libvpx-vp9"), "{refused}");
    let full = "echo 'av_interleaved_write_frame(): No space left on device' >&2; exit 1";
    let path = fake_ffmpeg(&work.path().join("full"), "libx264", full);
    let refused = call(&path, &out("m.mp4")).fails(1);
    assert!(refused.contains("m.mp4: cannot be written: the disk is full"), "{refused}");
    let path = fake_ffmpeg(&work.path().join("broken"), "libx264", "echo 'what went wrong' >&2; exit 3");
    assert!(call(&path, &out("m.mp4")).fails(1).contains("what went wrong"));
    assert!(!Path::new(&out("m.mp4")).exists());
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupted_movie_leaves_nothing() {
    let work = scratch();
    let images = work.path().join("images");
    write_images(&images, &[RED, GREY]);
    let mark = work.path().join("began");
    let body = format!("echo part > /dev/stdout; touch {}; exec sleep 3", mark.display());
    let path = fake_ffmpeg(&work.path().join("slow"), "libx264", &body);
    let folder = work.path().join("out");
    let mut child = Command::new(env!("CARGO_BIN_EXE_scree"))
        .env("PATH", path)
        .args(["movie", images.to_str().unwrap(), "-o", folder.join("m.mp4").to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !mark.exists() {
        assert!(child.try_wait().unwrap().is_none(), "the command ended before it was interrupted");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let left: Vec<_> = std::fs::read_dir(&folder).unwrap().flatten().map(|e| e.path()).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// A part of a film's images does not take the place of its movie.
#[test]
fn the_movie_of_all_images_is_not_replaced_by_that_of_a_part() {
    let work = scratch();
    let (model, home) = (work.path().join("m.yaml"), work.path().join("run"));
    let ball = "bodies: [{name: ball, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.1]}]\n";
    let text = format!(
        "step: 0.01\nduration: 0.2\nframe_rate: 20\nmaterials: {{m: {{density: 1000, friction: 0.5}}}}\n{ball}"
    );
    std::fs::write(&model, text).unwrap();
    let run = |more: &[&str]| {
        let words = ["run", model.to_str().unwrap(), "-o", home.to_str().unwrap(), "--res", "16x16", "--samples", "1"];
        scree(&[&words, more].concat())
    };
    let movie = || ["m.mp4", "m.apng"].iter().find_map(|name| std::fs::read(home.join(name)).ok()).unwrap();
    run(&["-f", "0"]).ok();
    let of_one = movie();
    // What it was made of is in what it is made of now.
    run(&["-f", "0-1"]).ok();
    let of_two = movie();
    assert_ne!(of_one, of_two);
    run(&[]).ok();
    let whole = movie();
    assert_ne!(whole, of_two);
    let said = run(&["-f", "3", "--redraw"]);
    assert!(said.ok().contains("images: 1") && !said.said().contains("movie:"), "{}", said.said());
    assert!(said.errors().contains("stays as it is: there are images of other frames"), "{}", said.errors());
    assert_eq!(movie(), whole);
    assert!(run(&["-f", "0-3"]).ok().contains("movie:"));
}
