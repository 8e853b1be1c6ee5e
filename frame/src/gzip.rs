//! Files as bytes, unpacked where they are packed by gzip (RFC 1952), in one or several members.

use crate::{Fault, FaultKind, read_bytes};
use flate2::read::MultiGzDecoder;
use guard::memory::{self, Bytes};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

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

    /// Go on from a byte of what is unpacked.
    fn seek(&mut self, offset: u64) -> io::Result<()> {
        match self {
            Source::Plain(file) => file.seek(SeekFrom::Start(offset)).map(|_| ()),
            Source::Packed(file) => io::copy(&mut file.take(offset), &mut io::sink()).map(|_| ()),
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
    let mut source = Source::open(path)?;
    let read = move || -> io::Result<Vec<u8>> {
        source.seek(offset)?;
        let mut bytes = Vec::with_capacity(length as usize);
        source.reader().take(length).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|e| fault(path, &e))
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
        assert_eq!(read_part(two.path(), 6, 4).unwrap(), b"2\n3,");
        assert_eq!(start(two.path(), 10), whole[..10]);
        for plain in [&whole[..], b"", b"\x1f"] {
            let plain_file = file(plain);
            assert_eq!(read(plain_file.path()).unwrap(), plain);
            assert_eq!(start(plain_file.path(), 100), plain);
        }
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
