//! The RIB writer: an [`Ri`] that writes its calls as RIB, in indented ASCII or as the binary bytestream. Instance arrays become
//! standard calls.
//!
//! Its methods are generated from the table of requests: the request's name, then each argument.

use crate::binary::Encoder;
use crate::line::{InRow, Line};
use crate::params::Params;
use crate::requests::{Bracket, Request};
use crate::ri::{Fail, Knots, Ri, RiResult, Tags, TrimCurves};
use crate::table::requests;
use std::io::Write;

/// A RIB writer onto a byte stream. Every call returns an error if the stream cannot be written.
pub struct Writer<W: Write> {
    out: W,
    indent: usize,
    /// The line of the last call, kept for its memory.
    line: String,
    handles: Vec<String>,
    /// Makes the bytestream of ASCII.
    encoder: Option<Encoder>,
}

impl<W: Write> Writer<W> {
    /// A writer of ASCII RIB onto `out`; writes the structure comment and the version.
    pub fn new(out: W) -> Result<Writer<W>, Fail> {
        let mut writer = Writer::archive(out);
        writer.put("##RenderMan RIB-Structure 1.1")?;
        writer.put("version 3.04")?;
        Ok(writer)
    }

    /// A writer of an ASCII archive, which other RIB reads in place and which has no header.
    pub fn archive(out: W) -> Writer<W> {
        Writer { out, indent: 0, line: String::new(), handles: vec![], encoder: None }
    }

    /// A writer of the binary bytestream (RISpec appendix C) onto `out`; writes the version.
    pub fn binary(out: W) -> Result<Writer<W>, Fail> {
        let mut writer = Writer { encoder: Some(Encoder::default()), ..Writer::archive(out) };
        writer.put("version 3.04")?;
        Ok(writer)
    }

    /// The byte stream that was written.
    pub fn into_inner(self) -> W {
        self.out
    }

    /// Write bytes that are no RIB.
    pub(crate) fn raw(&mut self, bytes: &[u8]) -> RiResult {
        self.out.write_all(bytes).map_err(|e| Fail::new(format!("RIB cannot be written: {e}")))
    }

    fn put(&mut self, request: &str) -> RiResult {
        let fail = |e: std::io::Error| Fail::new(format!("RIB cannot be written: {e}"));
        if let Some(encoder) = &mut self.encoder {
            let bytes = encoder.encode(request)?;
            return self.out.write_all(&bytes).map_err(fail);
        }
        writeln!(self.out, "{:indent$}{request}", "", indent = self.indent).map_err(fail)
    }

    /// An empty line to write a request into.
    fn start(&mut self, request: Request) -> String {
        let mut line = std::mem::take(&mut self.line);
        line.clear();
        line.push_str(request.name());
        line
    }

    /// Write a request's line; what stands in a block is indented.
    fn finish(&mut self, request: Request, line: String) -> RiResult {
        let bracket = request.row().bracket;
        if bracket == Bracket::Closes {
            self.indent = self.indent.saturating_sub(2);
        }
        // A stream has its version at its head, from the writer itself.
        if request != Request::version {
            self.put(&line)?;
        }
        if bracket == Bracket::Opens {
            self.indent += 2;
        }
        self.line = line;
        Ok(())
    }

    /// A handle as a number: the specification's lights and objects have no names. Names get numbers as they come, from 1001,
    /// where the small numbers that people write do not reach.
    fn handle_number(&mut self, handle: &str) -> String {
        if handle.parse::<i32>().is_ok() {
            return handle.into();
        }
        let known = self.handles.iter().position(|h| h == handle).unwrap_or_else(|| {
            self.handles.push(handle.into());
            self.handles.len() - 1
        });
        (1001 + known).to_string()
    }
}

/// Append arguments of one kind.
macro_rules! append {
    ($to:ident, $line:ident, numbers $what:literal ($($arg:ident),+)) => {
        $($arg.append($line.0);)+
    };
    ($to:ident, $line:ident, list $what:literal ($($arg:ident),+)) => {
        $line.bracketed(|line| { $($arg.append(line);)+ });
    };
    ($to:ident, $line:ident, lens ($($arg:ident),+)) => {
        $line.lens([$($arg),+]);
    };
    ($to:ident, $line:ident, declaration ($($arg:ident),+)) => {
        $($line.text($arg);)+
    };
    ($to:ident, $line:ident, colour ($arg:ident)) => {
        $line.bracketed(|line| $arg.append(line));
    };
    ($to:ident, $line:ident, colour_samples ($($arg:ident),+)) => {
        $($line.floats($arg);)+
    };
    ($to:ident, $line:ident, handle ($arg:ident)) => {
        $line.word(&$to.handle_number($arg));
    };
    ($to:ident, $line:ident, $kind:ident ($name:ident, $params:ident)) => {
        $line.text($name);
        $line.params($params);
    };
    ($to:ident, $line:ident, $kind:ident ($arg:ident)) => {
        $line.$kind($arg);
    };
}

macro_rules! methods {
    ($(#[doc = $doc:literal] $name:ident [$($where:ident)+]
       $(=> $method:ident($($kind:ident $($what:literal)? ($($arg:ident: $ty:ty),+))*))?;)*) => {
        impl<W: Write> Ri for Writer<W> {
            $($(
                fn $method(&mut self, $($($arg: $ty),+),*) -> RiResult {
                    let mut text = self.start(Request::$name);
                    #[allow(unused_mut, unused_variables)]
                    let (to, mut line) = (&mut *self, Line(&mut text));
                    $(append!(to, line, $kind $($what)? ($($arg),+));)*
                    self.finish(Request::$name, text)
                }
            )?)*

            fn archive_record(&mut self, kind: &str, text: &str) -> RiResult {
                self.put(&format!("{}{text}", if kind == "structure" { "##" } else { "#" }))
            }
        }
    };
}
requests!(methods);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Files;
    use crate::reader::read;
    use std::path::Path;

    /// Keeps the warnings.
    #[derive(Default)]
    struct Heard(Vec<String>);

    impl Ri for Heard {
        fn world_begin(&mut self) -> RiResult {
            Ok(())
        }
        fn world_end(&mut self) -> RiResult {
            Ok(())
        }
        fn surface(&mut self, _: &str, _: Params) -> RiResult {
            Ok(())
        }
        fn warn(&mut self, message: String) {
            self.0.push(message);
        }
    }

    fn rewrite(text: &str) -> String {
        let mut writer = Writer::new(Vec::new()).unwrap();
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut writer, &mut |_, _| Ok(None)).unwrap();
        String::from_utf8(writer.into_inner()).unwrap()
    }

    #[test]
    fn writing_what_was_read_is_a_fixed_point() {
        let text = "Format 640 480 1 Projection \"perspective\" \"fov\" [30]
            Declare \"tint\" \"uniform color\"
            WorldBegin LightSource \"distantlight\" 1 \"intensity\" [.5] AttributeBegin # a remark
            Color 1 .5 0 Surface \"plastic\" \"tint\" [1 0 0] Translate 1 2 3 Sphere 1 -1 1 360 \"varying float x\" [1 2 3 4]
            Basis \"bezier\" 3 \"b-spline\" 1 Patch \"bilinear\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]
            AttributeEnd WorldEnd";
        let once = rewrite(text);
        assert_eq!(rewrite(&once), once);
        assert!(once.contains("    Color [1 0.5 0]\n"), "{once}");
    }

    #[test]
    fn faults_have_their_places() {
        let fault = |text: &str| {
            let mut writer = Writer::new(Vec::new()).unwrap();
            let e = read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut writer, &mut |_, _| Ok(None))
                .unwrap_err();
            (e.place.line, e.place.column, e.message)
        };
        // What is not known is read over, and said.
        let mut heard = Heard::default();
        let text = "WorldBegin\n  Shpere 1 [-1 1] \"a\" 360 Surface \"matte\" \"Kq\" [1] Shpere 2 WorldEnd";
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut heard, &mut |_, _| Ok(None)).unwrap();
        let expected = [
            "t.rib:2:3: unknown request `Shpere`, did you mean `Sphere`?; it is passed over",
            "t.rib:2:27: parameter `Kq` is not declared: write \"uniform float Kq\" or `Declare` it before; did you mean `Ka`?",
        ];
        assert_eq!(heard.0, expected);
        assert_eq!(fault("Color [1 2").2, "expected a number or `]`, found the end of the file");
        assert_eq!(fault("IfBegin \"1\" WorldBegin").2, "`IfBegin` without `IfEnd`");
        assert_eq!(fault("\n \"matte").2, "a string is not closed before the file ends");
    }
    #[test]
    fn a_request_that_lacks_something_is_at_fault_itself() {
        let fault = |text: &str| {
            let mut writer = Writer::new(Vec::new()).unwrap();
            let e = read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut writer, &mut |_, _| Ok(None))
                .unwrap_err();
            (e.place.line, e.place.column, e.text)
        };
        let at = |text: &str| (fault(text).0, fault(text).1);
        // What the next request or the end cuts short; a word of no request stands where it is.
        assert_eq!(at("Translate 1 2\nWorldEnd"), (1, 1));
        assert_eq!(at("Identity Translate 1 2 # of two numbers\n\nDisk 0 1 360"), (1, 10));
        assert_eq!(at("Identity\n Surface \"matte\" \"Ka\"\nDisk 0 1 360"), (2, 2));
        assert_eq!(at("Identity\n Surface \"matte\" \"Ka\""), (2, 2));
        assert_eq!(at("Polygon \"P\" [0 0 0\nDisk 0 1 360"), (1, 1));
        assert_eq!(at("Translate 1 2\nDsik 0 1 360"), (1, 1));
        assert_eq!(at("Translate 1 nan 3\nDisk 0 1 360"), (1, 13));
        assert_eq!(at("Translate 1 2 \"3\"\nDisk 0 1 360"), (1, 15));
        assert_eq!(at("Translate 1 2..5 3\nDisk 0 1 360"), (1, 13));
        assert_eq!(at("Polygon \"P\" [0 0 0 1..5]\nDisk 0 1 360"), (1, 20));
        assert_eq!(at("Disk 0 1 360 \"matte\nDisk\n"), (1, 14));
        // A parameter that is wrong, rather than the first of the request.
        assert_eq!(at("Disk 0 1 360 \"Os\" [1 1 1] \"Cs\" [1 0]\nDisk 0 1 360"), (1, 27));
        assert_eq!(at("Disk 0 1 360 \"uniform flot x\" [1]\nDisk 0 1 360"), (1, 14));
        // Archives within the stream are read where they stand.
        let line = "Identity ArchiveBegin \"a\" Sphere 1";
        let text = format!("{line}\nDisk 0 1 ArchiveEnd\nReadArchive \"a\"");
        assert_eq!(fault(&text), (1, 27, line.into()));
        let text = "ArchiveBegin \"a\" Sphere 1 -1 1 360\n Disk 0 1 ArchiveEnd ReadArchive \"a\"";
        assert_eq!(fault(text), (2, 2, " Disk 0 1 ".into()));
        let inner = "Identity ArchiveBegin \"a\" Identity ArchiveBegin \"b\" Sphere 1 ";
        let text = format!("{inner}ArchiveEnd ReadArchive \"b\" ArchiveEnd ReadArchive \"a\"");
        assert_eq!(fault(&text), (1, 53, inner.into()));
        let long = format!("{}Identity ArchiveBegin \"a\" Sphere 1 ArchiveEnd ReadArchive \"a\"", " ".repeat(700));
        assert_eq!(fault(&long), (1, 727, " ".repeat(500)));
        // A directive that comes first in one is in it.
        let text = "ArchiveBegin \"a\"\n#scree said\nIdentity ArchiveEnd ReadArchive \"a\" ReadArchive \"a\"";
        let (mut writer, mut said) = (Writer::new(Vec::new()).unwrap(), vec![]);
        let mut hear = |_: &mut dyn Ri, text: &str| {
            said.push(text.to_string());
            Ok(None)
        };
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut writer, &mut hear).unwrap();
        assert_eq!(said, ["said", "said"]);
    }
}
