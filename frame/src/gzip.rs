//! Files as bytes, unpacked where they are packed by gzip (RFC 1952), in one or several members.

use crate::{Fault, FaultKind, read_bytes};
use flate2::read::MultiGzDecoder;
use guard::memory::{self, Bytes};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::SystemTime;

/// What every file that is packed by gzip begins with.
const MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Bytes that are read at once.
const PART: usize = 1 << 20;

/// An open file.
enum Source {
    /// As it is.
    Plain(BufReader<File>),
    /// Unpacked.
    Packed(Box<BufReader<MultiGzDecoder<BufReader<File>>>>),
}

impl Source {
    fn open(path: &Path) -> Result<Source, Fault> {
        let file = guard::open(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
        let mut file = BufReader::with_capacity(PART, file);
        Ok(if file.fill_buf().map_err(|e| fault(path, &e))?.starts_with(&MAGIC) {
            Source::Packed(Box::new(BufReader::with_capacity(PART, MultiGzDecoder::new(file))))
        } else {
            Source::Plain(file)
        })
    }

    /// Pass from a byte of what is unpacked to a later one.
    fn pass(&mut self, at: u64, offset: u64) -> io::Result<()> {
        match self {
            Source::Plain(file) => file.seek(SeekFrom::Start(offset)).map(|_| ()),
            Source::Packed(file) => io::copy(&mut file.take(offset - at), &mut io::sink()).map(|_| ()),
        }
    }

    fn buffer(&mut self) -> &mut dyn BufRead {
        match self {
            Source::Plain(file) => file,
            Source::Packed(file) => file,
        }
    }

    fn reader(self) -> Box<dyn BufRead> {
        match self {
            Source::Plain(file) => Box::new(file),
            Source::Packed(file) => file,
        }
    }
}

/// The fault of a file that was opened, and could not be read on, or not be unpacked.
pub(crate) fn fault(path: &Path, error: &io::Error) -> Fault {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => Fault::whole(FaultKind::Data, path, "is packed by gzip, and truncated")
            .hint("the program that wrote it was interrupted, or is still writing it"),
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
            Fault::whole(FaultKind::Data, path, format!("is packed by gzip, and damaged: {error}"))
        }
        _ => Fault::unreadable(FaultKind::Data, path, error),
    }
}

/// Open a file, to read what is unpacked from its beginning.
pub(crate) fn open(path: &Path) -> Result<Box<dyn BufRead>, Fault> {
    Source::open(path).map(Source::reader)
}

/// The first bytes of a file, unpacked; fewer if it has no more, or cannot be read.
pub(crate) fn start(path: &Path, count: u64) -> Vec<u8> {
    let mut bytes = vec![];
    if let Ok(source) = Source::open(path) {
        // What is wrong behind these bytes is told when all is read.
        let _ = source.reader().take(count).read_to_end(&mut bytes);
    }
    bytes
}

/// Read a whole file, unpacked; `-` is the standard input.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Fault> {
    if path == Path::new("-") {
        let bytes = read_bytes(FaultKind::Data, path)?;
        return if bytes.starts_with(&MAGIC) { unpack(path, MultiGzDecoder::new(&bytes[..])) } else { Ok(bytes) };
    }
    let mut file = guard::open(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let mut head = [0; 2];
    let n = file.read(&mut head).map_err(|e| fault(path, &e))?;
    if head[..n] != MAGIC {
        return read_bytes(FaultKind::Data, path);
    }
    file.seek(SeekFrom::Start(0)).map_err(|e| fault(path, &e))?;
    unpack(path, MultiGzDecoder::new(BufReader::with_capacity(PART, file)))
}

/// Read a part of a file, in bytes of what is unpacked; less if it ends before.
pub(crate) fn read_part(path: &Path, offset: u64, length: u64) -> Result<Vec<u8>, Fault> {
    if length > memory::room() {
        return Err(Fault::whole(FaultKind::Data, path, format!("a table of it is too large: {}", memory::Full)));
    }
    let (mut source, at) = Left::take(path, offset).map_or_else(|| Source::open(path).map(|s| (s, 0)), Ok)?;
    let mut bytes = Vec::with_capacity(length as usize);
    let mut read = || -> io::Result<usize> {
        source.pass(at, offset)?;
        source.buffer().take(length).read_to_end(&mut bytes)
    };
    read().map_err(|e| fault(path, &e))?;
    Left::put(path, source, offset + bytes.len() as u64);
    Ok(bytes)
}

/// A packed file as its last part has left it: nobody can begin in its middle, and parts are mostly read one behind the other.
struct Left {
    path: PathBuf,
    stamp: Stamp,
    source: Source,
    /// Bytes of what is unpacked that have been read.
    at: u64,
}

/// What tells a file from any other that has come in its place.
type Stamp = (u64, Option<SystemTime>);

static LEFT: Mutex<Option<Left>> = Mutex::new(None);

impl Left {
    fn stamp(path: &Path) -> Option<Stamp> {
        path.metadata().ok().map(|m| (m.len(), m.modified().ok()))
    }

    /// The file, if it was left before a byte, and where.
    fn take(path: &Path, offset: u64) -> Option<(Source, u64)> {
        let left = LEFT.lock().unwrap_or_else(|e| e.into_inner()).take()?;
        let is_it = left.path == path && left.at <= offset && Some(left.stamp) == Left::stamp(path);
        is_it.then_some((left.source, left.at))
    }

    /// Leave a file, if it is packed, behind a byte.
    fn put(path: &Path, source: Source, at: u64) {
        if let (Source::Packed(_), Some(stamp)) = (&source, Left::stamp(path)) {
            let left = Left { path: path.into(), stamp, source, at };
            *LEFT.lock().unwrap_or_else(|e| e.into_inner()) = Some(left);
        }
    }
}

/// Unpack a stream whole, as far as there is memory for it.
fn unpack(path: &Path, mut packed: impl Read) -> Result<Vec<u8>, Fault> {
    let mut bytes = vec![];
    loop {
        // A vector that grows is there twice for a moment.
        if memory::room() < (2 * bytes.len() + PART) as u64 {
            let message = format!("unpacked, it has more than {}: {}", Bytes(bytes.len() as u64), memory::Full);
            return Err(Fault::whole(FaultKind::Data, path, message));
        }
        match packed.by_ref().take(PART as u64).read_to_end(&mut bytes) {
            Ok(0) => return Ok(bytes),
            Ok(_) => {}
            Err(e) => return Err(fault(path, &e)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut out = GzEncoder::new(vec![], Compression::default());
        out.write_all(bytes).unwrap();
        out.finish().unwrap()
    }

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        file
    }

    #[test]
    fn several_members_are_read_as_one() {
        let two = file(&[packed(b"x,y\n1,2\n"), packed(b"3,4\n")].concat());
        let whole = b"x,y\n1,2\n3,4\n";
        assert_eq!(read(two.path()).unwrap(), whole);
        for (offset, length, part) in [(6, 4, "2\n3,"), (10, 1, "4"), (4, 2, "1,"), (10, 9, "4\n"), (12, 3, "")] {
            assert_eq!(read_part(two.path(), offset, length).unwrap(), part.as_bytes());
        }
        assert_eq!(start(two.path(), 10), whole[..10]);
        for plain in [&whole[..], b"", b"\x1f"] {
            let plain_file = file(plain);
            assert_eq!(read(plain_file.path()).unwrap(), plain);
            assert_eq!(start(plain_file.path(), 100), plain);
        }
        // Another file in its place is read from its beginning.
        std::fs::write(two.path(), packed(b"another file")).unwrap();
        assert_eq!(read_part(two.path(), 8, 4).unwrap(), b"file");
    }

    #[test]
    fn truncated_and_damaged_files_are_faults() {
        let text: Vec<u8> = (0..5000).flat_map(|k| format!("{}\n", k * k).into_bytes()).collect();
        let good = packed(&text);
        for end in 2..good.len() {
            if end % 97 == 0 || end < 40 || end > good.len() - 12 {
                let fault = read(file(&good[..end]).path()).unwrap_err();
                assert!(fault.message.contains("truncated"), "{end}: {fault}");
            }
        }
        let mut wrong = good.clone();
        let middle = wrong.len() / 2;
        wrong[middle] ^= 0x40;
        let fault = read(file(&wrong).path()).unwrap_err();
        assert!(fault.message.contains("gzip"), "{fault}");
    }
}
