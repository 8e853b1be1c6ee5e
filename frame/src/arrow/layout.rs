//! The layout of an Arrow IPC file, checked before it is decoded: the decoder trusts lengths and offsets, and a file that lies about
//! them would take memory without end, or end the program.
//!
//! Only columns are accepted that a [`Frame`](crate::Frame) can hold. Names are those of the format's description
//! (Apache Arrow Columnar Format, "IPC File Format").

use arrow_ipc::{
    Block, CompressionType, DateUnit, DictionaryBatch, Endianness, Field, Footer, Message, Precision, RecordBatch,
    TimeUnit, Type, root_as_footer, root_as_message,
};
use std::fmt::Display;

/// What ends a file: the footer's length, and these bytes.
const MAGIC: &[u8] = b"ARROW1";

/// Check the layout of a file; an error says what is wrong.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    let width = |field: &Field<'_>| width(field).map(|width| vec![width]);
    check_all(bytes, &width, &|batch, body, widths| columns(batch, body, widths), &|batch, _, body| {
        dictionary(batch, body)
    })
}

/// Check the layout of a file of another program, which may have columns of more types, and be compressed.
pub(super) fn check_table(bytes: &[u8]) -> Result<(), String> {
    check_all(bytes, &shapes, &any_columns, &|batch, kind, body| {
        let batch = batch.data().ok_or("a dictionary has no words")?;
        // Their offsets are checked where they are decoded.
        let words = if kind == Some(Type::Utf8View) { Shape::views() } else { Shape::new(32, 3) };
        any_columns(&batch, body, &[words])
    })
}

/// What checks a dictionary: its batch, the type of the words that it is for, and its body.
type CheckDictionary<'a> = &'a dyn Fn(&DictionaryBatch<'_>, Option<Type>, &[u8]) -> Result<(), String>;

/// Check the layout of a file, its columns and its dictionaries; `of` tells what is to be known of a column and of those within it.
fn check_all<T>(
    bytes: &[u8],
    of: &dyn Fn(&Field<'_>) -> Result<Vec<T>, String>,
    columns: &dyn Fn(&RecordBatch<'_>, &[u8], &[T]) -> Result<(), String>,
    dictionary: CheckDictionary<'_>,
) -> Result<(), String> {
    let footer = footer(bytes)?;
    let schema = footer.schema().ok_or("it has no schema")?;
    if schema.endianness() != Endianness::Little {
        return Err("its numbers are big-endian".into());
    }
    let notes = [schema.custom_metadata(), footer.custom_metadata()];
    let mut notes = notes.into_iter().flatten().flatten();
    if notes.any(|note| note.key().is_none() || note.value().is_none()) {
        return Err("its metadata has a key without value".into());
    }
    let fields = schema.fields().ok_or("it has no columns")?;
    let widths = fields.iter().map(|field| of(&field)).collect::<Result<Vec<_>, _>>()?;
    let widths: Vec<T> = widths.into_iter().flatten().collect();
    for block in footer.dictionaries().into_iter().flatten() {
        let (message, body) = message(bytes, block)?;
        let batch = message.header_as_dictionary_batch().ok_or("a dictionary is none")?;
        let is_its = |field: &Field<'_>| field.dictionary().is_some_and(|own| own.id() == batch.id());
        dictionary(&batch, fields.iter().find(is_its).map(|field| field.type_type()), body)?;
    }
    for block in footer.recordBatches().ok_or("it has no rows")? {
        let (message, body) = message(bytes, block)?;
        let batch = message.header_as_record_batch().ok_or("rows are none")?;
        columns(&batch, body, &widths)?;
    }
    Ok(())
}

fn footer(bytes: &[u8]) -> Result<Footer<'_>, String> {
    let rest = bytes.strip_suffix(MAGIC).ok_or("it does not end as one")?;
    let (rest, length) = rest.split_last_chunk().ok_or("it has no footer")?;
    let length = usize::try_from(i32::from_le_bytes(*length)).map_err(|_| "its footer has a negative length")?;
    let start = rest.len().checked_sub(length).ok_or("its footer is longer than the file")?;
    root_as_footer(&rest[start..]).map_err(|e| format!("its footer cannot be read: {e}"))
}

/// Why a column of this type is none that a frame can hold.
pub(super) fn refused(name: &str, kind: &dyn Display) -> String {
    format!("column `{name}` has type {kind}, which is not a number or a dictionary of words")
}

/// Bytes of a value of a column, of the codes if it has words.
fn width(field: &Field<'_>) -> Result<usize, String> {
    let refuse = || refused(field.name().unwrap_or_default(), &field.type_type().variant_name().unwrap_or("unknown"));
    if field.custom_metadata().into_iter().flatten().any(|note| note.key().is_none() || note.value().is_none()) {
        return Err(refuse());
    }
    let code = field.dictionary().map(|d| d.indexType());
    match (field.type_type(), code) {
        (Type::Utf8, Some(Some(code))) if code.bitWidth() == 32 && !code.is_signed() => Ok(4),
        (Type::Int, None) => {
            let int = field.type_as_int().filter(|int| int.bitWidth() == 64 && int.is_signed());
            int.map(|_| 8).ok_or_else(refuse)
        }
        (Type::FloatingPoint, None) => match field.type_as_floating_point().map(|x| x.precision()) {
            Some(Precision::DOUBLE) => Ok(8),
            Some(Precision::SINGLE) => Ok(4),
            _ => Err(refuse()),
        },
        _ => Err(refuse()),
    }
}

/// The message of a block, and its body.
fn message<'a>(bytes: &'a [u8], block: &Block) -> Result<(Message<'a>, &'a [u8]), String> {
    let outside = "a part of it is outside of the file";
    let of = |x: i64| usize::try_from(x).map_err(|_| outside.to_string());
    let (start, head, body) = (of(block.offset())?, of(block.metaDataLength().into())?, of(block.bodyLength())?);
    let rest = bytes.get(start..).ok_or(outside)?;
    let (head, rest) = rest.split_at_checked(head).ok_or(outside)?;
    let body = rest.get(..body).ok_or(outside)?;
    // A mark and the length of what follows; older files have the length alone.
    let skip = if head.starts_with(&[0xff; 4]) { 8 } else { 4 };
    let message = root_as_message(head.get(skip..).ok_or(outside)?);
    Ok((message.map_err(|e| format!("a part of it cannot be read: {e}"))?, body))
}

/// The buffers of a batch in its body, with the count of values of each column.
fn buffers<'a>(batch: &RecordBatch<'_>, body: &'a [u8], each: usize) -> Result<Vec<(usize, Vec<&'a [u8]>)>, String> {
    if batch.compression().is_some() {
        return Err("it is compressed: write it without compression".into());
    }
    let (Some(nodes), Some(buffers)) = (batch.nodes(), batch.buffers()) else {
        return Err("rows have no values".into());
    };
    if batch.variadicBufferCounts().is_some_and(|n| !n.is_empty()) || buffers.len() != each * nodes.len() {
        return Err("it has not the buffers that its columns need".into());
    }
    let buffer = |k: usize| {
        let buffer = buffers.get(k);
        let (start, length) = (usize::try_from(buffer.offset()).ok()?, usize::try_from(buffer.length()).ok()?);
        body.get(start..start.checked_add(length)?)
    };
    let column = |k: usize| {
        let n = usize::try_from(nodes.get(k).length()).ok()?;
        let own = (0..each).map(|b| buffer(each * k + b)).collect::<Option<Vec<_>>>()?;
        // A bit for each value, unless all are there.
        let has_marks = own[0].len() >= n.div_ceil(8) || own[0].is_empty() && nodes.get(k).null_count() == 0;
        has_marks.then_some((n, own))
    };
    let all = (0..nodes.len()).map(column).collect::<Option<Vec<_>>>();
    all.ok_or_else(|| "a column is longer than its values".into())
}

/// Check the columns of a batch, given with the bytes of a value of each.
fn columns(batch: &RecordBatch<'_>, body: &[u8], widths: &[usize]) -> Result<(), String> {
    let columns = buffers(batch, body, 2)?;
    let rows = usize::try_from(batch.length()).unwrap_or(usize::MAX);
    let fits = |((n, own), width): (&(usize, Vec<&[u8]>), &usize)| {
        let is_whole = own[1].len().is_multiple_of(*width);
        *n == rows && is_whole && n.checked_mul(*width).is_some_and(|bytes| own[1].len() >= bytes)
    };
    if columns.len() == widths.len() && columns.iter().zip(widths).all(fits) {
        return Ok(());
    }
    Err("its columns are not of one length".into())
}

/// Check the words of a dictionary.
fn dictionary(batch: &DictionaryBatch<'_>, body: &[u8]) -> Result<(), String> {
    let batch = batch.data().ok_or("a dictionary has no words")?;
    let columns = buffers(&batch, body, 3)?;
    let [(n, own)] = columns.as_slice() else { return Err("a dictionary has several columns".into()) };
    let bad = "the words of a dictionary are not in order";
    if usize::try_from(batch.length()) != Ok(*n) {
        return Err(bad.into());
    }
    if *n == 0 {
        return Ok(());
    }
    let ends = own[1].chunks_exact(4).map(|b| i32::from_le_bytes(b.try_into().unwrap_or_default()));
    let ends: Vec<i32> = ends.take(n + 1).collect();
    let is_in_order = own[1].len().is_multiple_of(4) && ends.len() == n + 1 && ends[0] >= 0 && ends.is_sorted();
    let words =
        ends.last().and_then(|end| own[2].get(..usize::try_from(*end).ok()?)).filter(|_| is_in_order).ok_or(bad)?;
    // Each word is text of its own.
    let is_text = |w: &[i32]| std::str::from_utf8(&words[w[0] as usize..w[1] as usize]).is_ok();
    if ends.windows(2).all(is_text) { Ok(()) } else { Err("the words of a dictionary are not UTF-8 text".into()) }
}

/// What the values of a column look like.
#[derive(Clone, Copy)]
struct Shape {
    /// Bits of a value, of an offset if it has words, or of the codes of a dictionary.
    bits: usize,
    /// Count of buffers: marks of what is there, values, and the letters of words.
    buffers: usize,
    /// Whether there are further buffers with letters, which each batch counts: words by views.
    has_views: bool,
    /// Whether there is a value more than rows: where each ends, and the first begins.
    has_offsets: bool,
    /// Whether it is within another column, and has a number of rows of its own.
    is_within: bool,
}

impl Shape {
    fn new(bits: usize, buffers: usize) -> Shape {
        Shape { bits, buffers, has_views: false, has_offsets: buffers == 3, is_within: false }
    }

    /// Words by views.
    fn views() -> Shape {
        Shape { has_views: true, ..Shape::new(128, 2) }
    }
}

/// The shapes of a column and of those within it, which are left out with it.
fn shapes(field: &Field<'_>) -> Result<Vec<Shape>, String> {
    /// Columns within each other.
    const DEEPEST: usize = 8;
    fn add(field: &Field<'_>, depth: usize, all: &mut Vec<Shape>) -> Result<(), String> {
        let own = shape(field)?;
        if depth > DEEPEST {
            return Err("it has columns too deep within each other".into());
        }
        all.push(Shape { is_within: depth > 0, ..own });
        field.children().into_iter().flatten().try_for_each(|child| add(&child, depth + 1, all))
    }
    let mut all = vec![];
    add(field, 0, &mut all)?;
    Ok(all)
}

/// The shape of a column.
fn shape(field: &Field<'_>) -> Result<Shape, String> {
    let refuse = || refused(field.name().unwrap_or_default(), &field.type_type().variant_name().unwrap_or("unknown"));
    if field.custom_metadata().into_iter().flatten().any(|note| note.key().is_none() || note.value().is_none()) {
        return Err(refuse());
    }
    if field.name().is_none() {
        return Err(refuse());
    }
    // The decoder takes the type of the codes for granted.
    let code = match field.dictionary() {
        None => None,
        Some(own) => Some(own.indexType().ok_or_else(refuse)?.bitWidth()),
    };
    let n_children = field.children().map_or(0, |children| children.len());
    match (field.type_type(), n_children) {
        (_, 1..) if code.is_some() => return Err(refuse()),
        (Type::List, 1) => return Ok(Shape { has_offsets: true, ..Shape::new(32, 2) }),
        (Type::LargeList, 1) => return Ok(Shape { has_offsets: true, ..Shape::new(64, 2) }),
        (Type::FixedSizeList, 1) if field.type_as_fixed_size_list().is_some() => return Ok(Shape::new(0, 1)),
        (Type::Struct_, 1..) => return Ok(Shape::new(0, 1)),
        (_, 0) => {}
        _ => return Err(refuse()),
    }
    let bits = |bits: i32| usize::try_from(bits).ok().filter(|bits| [8, 16, 32, 64].contains(bits)).ok_or_else(refuse);
    Ok(match (field.type_type(), code) {
        (Type::Utf8 | Type::LargeUtf8 | Type::Utf8View, Some(code)) => Shape::new(bits(code)?, 2),
        (Type::Utf8, None) => Shape::new(32, 3),
        (Type::LargeUtf8, None) => Shape::new(64, 3),
        (Type::Utf8View, None) => Shape::views(),
        (Type::Bool, None) => Shape::new(1, 2),
        (Type::Int, None) => Shape::new(bits(field.type_as_int().ok_or_else(refuse)?.bitWidth())?, 2),
        (Type::FloatingPoint, None) => match field.type_as_floating_point().map(|x| x.precision()) {
            Some(Precision::DOUBLE) => Shape::new(64, 2),
            Some(Precision::SINGLE) => Shape::new(32, 2),
            Some(Precision::HALF) => Shape::new(16, 2),
            _ => return Err(refuse()),
        },
        // Those that are left out.
        (Type::Timestamp | Type::Duration | Type::Date | Type::Time, None) => {
            Shape::new(time_bits(field).ok_or_else(refuse)?, 2)
        }
        _ => return Err(refuse()),
    })
}

/// Bits of a time or a date, of the units that the format has; none of any other.
fn time_bits(field: &Field<'_>) -> Option<usize> {
    let is_known = |unit: TimeUnit| unit.variant_name().is_some();
    if let Some(date) = field.type_as_date() {
        return match date.unit() {
            DateUnit::DAY => Some(32),
            DateUnit::MILLISECOND => Some(64),
            _ => None,
        };
    }
    if let Some(time) = field.type_as_time() {
        let is_short = matches!(time.unit(), TimeUnit::SECOND | TimeUnit::MILLISECOND);
        let bits = if is_short { 32 } else { 64 };
        return (is_known(time.unit()) && time.bitWidth() == bits).then_some(bits as usize);
    }
    let unit = field.type_as_timestamp().map(|own| own.unit()).or(field.type_as_duration().map(|own| own.unit()));
    unit.filter(|unit| is_known(*unit)).map(|_| 64)
}

/// Check the columns of a batch, which may be compressed.
fn any_columns(batch: &RecordBatch<'_>, body: &[u8], shapes: &[Shape]) -> Result<(), String> {
    let (Some(nodes), Some(buffers)) = (batch.nodes(), batch.buffers()) else {
        return Err("rows have no values".into());
    };
    let bad = "it has not the buffers that its columns need";
    let counts: Vec<i64> = batch.variadicBufferCounts().map_or(vec![], |counts| counts.iter().collect());
    if counts.len() != shapes.iter().filter(|shape| shape.has_views).count() {
        return Err(bad.into());
    }
    let mut counts = counts.into_iter().map(|n| usize::try_from(n).ok().filter(|n| *n <= buffers.len()));
    let further = shapes.iter().map(|shape| if shape.has_views { counts.next().flatten() } else { Some(0) });
    let further: Vec<usize> = further.collect::<Option<_>>().ok_or(bad)?;
    let n_buffers: usize = shapes.iter().zip(&further).map(|(shape, n)| shape.buffers + n).sum();
    if buffers.len() != n_buffers || nodes.len() != shapes.len() {
        return Err(bad.into());
    }
    // What a compression makes of a byte at most.
    let most = match batch.compression().map(|own| own.codec()) {
        None => None,
        Some(CompressionType::LZ4_FRAME) => Some(255),
        Some(CompressionType::ZSTD) => Some(1 << 16),
        Some(_) => return Err("it is compressed neither by LZ4 nor by zstd".into()),
    };
    let mut room = guard::memory::room();
    let mut length = |k: usize| -> Option<usize> {
        let own = buffers.get(k);
        let (start, length) = (usize::try_from(own.offset()).ok()?, usize::try_from(own.length()).ok()?);
        let bytes = body.get(start..start.checked_add(length)?)?;
        if most.is_none() || bytes.is_empty() {
            return Some(length);
        }
        // The count of bytes stands before them, or -1 if they are not compressed.
        let count = i64::from_le_bytes(*bytes.first_chunk()?);
        let length = if count == -1 { length - 8 } else { usize::try_from(count).ok()? };
        room = room.checked_sub(length as u64)?;
        (length <= bytes.len().saturating_mul(most.unwrap_or(1))).then_some(length)
    };
    let of_batch = usize::try_from(batch.length()).unwrap_or(usize::MAX);
    let mut first = 0;
    for (k, shape) in shapes.iter().enumerate() {
        let own = usize::try_from(nodes.get(k).length()).unwrap_or(usize::MAX);
        let rows = if shape.is_within { own } else { of_batch };
        let n_own = shape.buffers + further[k];
        let lengths = (first..first + n_own).map(&mut length).collect::<Option<Vec<_>>>();
        let lengths = lengths.ok_or("a part of it is outside of the file, or larger than it can be")?;
        first += n_own;
        let n_offsets = usize::from(shape.has_offsets && rows > 0);
        let needed = rows.checked_add(n_offsets).and_then(|n| n.checked_mul(shape.bits)).map(|bits| bits.div_ceil(8));
        let has_marks = lengths[0] >= rows.div_ceil(8) || lengths[0] == 0 && nodes.get(k).null_count() == 0;
        let values = lengths.get(1).copied().unwrap_or(0);
        let is_whole = shape.bits < 8 || values.is_multiple_of(shape.bits / 8);
        if own != rows || !has_marks || !is_whole || needed.is_none_or(|needed| values < needed) {
            return Err("its columns are not of one length".into());
        }
    }
    Ok(())
}
