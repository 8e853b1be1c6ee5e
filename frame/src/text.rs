//! The bytes of a table → text: UTF-8, UTF-16 with or without its mark, else Windows-1252, which has Latin-1's letters.

/// The mark of its encoding that an editor of Windows begins a text with.
pub(crate) const MARK: &str = "\u{feff}";

/// What Windows-1252 has where Latin-1 has control characters, from 0x80 on; `\u{fffd}` is nothing.
const WINDOWS: &str = "€\u{fffd}‚ƒ„…†‡ˆ‰Š‹Œ\u{fffd}Ž\u{fffd}\u{fffd}‘’“”•–—˜™š›œ\u{fffd}žŸ";

/// Bytes as text; of what is not text, the first byte that shows it.
pub(crate) fn decode(bytes: Vec<u8>) -> Result<String, usize> {
    let utf16 = match bytes.as_slice() {
        [0xff, 0xfe, ..] => Some((2, u16::from_le_bytes as fn([u8; 2]) -> u16)),
        [0xfe, 0xff, ..] => Some((2, u16::from_be_bytes as fn([u8; 2]) -> u16)),
        _ if bytes.contains(&0) => plain_utf16(&bytes).map(|unit| (0, unit)),
        _ => None,
    };
    let text = match utf16 {
        Some((mark, unit)) => from_utf16(&bytes, mark, unit)?,
        None => from_bytes(bytes)?,
    };
    // Line ends of old Macintosh programs.
    Ok(if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text })
}

/// The order of bytes of UTF-16 without a mark, if nearly all characters have an empty upper byte.
fn plain_utf16(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    let pairs = || bytes.chunks_exact(2).take(2000);
    let zeros = |k: usize| pairs().filter(|pair| pair[k] == 0).count();
    match (zeros(0), zeros(1)) {
        (0, upper) if 10 * upper >= 9 * pairs().count() => Some(u16::from_le_bytes),
        (upper, 0) if 10 * upper >= 9 * pairs().count() => Some(u16::from_be_bytes),
        _ => None,
    }
}

fn from_utf16(bytes: &[u8], mark: usize, unit: fn([u8; 2]) -> u16) -> Result<String, usize> {
    let pairs = bytes[mark..].chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return Err(bytes.len() - 1);
    }
    let mut text = String::with_capacity(bytes.len() / 2);
    for c in char::decode_utf16(pairs.map(|pair| unit([pair[0], pair[1]]))) {
        match c {
            Ok(c) if c != '\0' => text.push(c),
            _ => return Err(mark + 2 * text.encode_utf16().count()),
        }
    }
    Ok(text)
}

fn from_bytes(bytes: Vec<u8>) -> Result<String, usize> {
    if bytes.contains(&0) {
        return Err(bytes.iter().position(|b| *b == 0).unwrap_or(0));
    }
    let bytes = match String::from_utf8(bytes) {
        Ok(text) => return Ok(text),
        Err(e) => e.into_bytes(),
    };
    let windows: Vec<char> = WINDOWS.chars().collect();
    let letter = |(at, b): (usize, &u8)| match b {
        0x20..=0x7e | b'\t' | b'\n' | b'\r' | 0x0c | 0x1a => Ok(*b as char),
        0x80..=0x9f => Some(windows[*b as usize - 0x80]).filter(|c| *c != '\u{fffd}').ok_or(at),
        0xa0.. => Ok(*b as char),
        _ => Err(at),
    };
    bytes.iter().enumerate().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_found_out() {
        let text = "angle [°],size [µm]\n1,2\n";
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let units = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        let (little, big) = (units(u16::to_le_bytes), units(u16::to_be_bytes));
        let marked = |mark: [u8; 2], bytes: &[u8]| [&mark[..], bytes].concat();
        for bytes in [
            text.as_bytes().to_vec(),
            latin,
            marked([0xff, 0xfe], &little),
            marked([0xfe, 0xff], &big),
            little.clone(),
            big,
        ] {
            assert_eq!(decode(bytes).as_deref(), Ok(text));
        }
        assert_eq!(decode(b"10 \x80".to_vec()).as_deref(), Ok("10 €"));
        assert_eq!(decode(b"x,y\r1,2\r".to_vec()).as_deref(), Ok("x,y\n1,2\n"));
    }

    #[test]
    fn binary_files_are_refused_where_they_show_it() {
        assert_eq!(decode(b"x,y\n1,2\n\0\0\0".to_vec()), Err(8));
        assert_eq!(decode(vec![b'a', 0xff, 3, 7]), Err(2));
        assert_eq!(decode(vec![0xff, 0xfe, b'1', 0, b'2']), Err(4));
    }
}
