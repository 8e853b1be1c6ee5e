//! A frame as one Arrow IPC file (Feather v2), which pandas, polars, R and Julia read directly.
//!
//! The schema's metadata holds the frame's number and time (key `scree`, text `frame=NUMBER time=SECONDS`), each field's metadata
//! the column's unit (key `unit`). Columns are float64, float32, int64, or dictionaries of words with uint32 keys.

pub(crate) mod columns;
mod layout;

use crate::{Column, Fault, FaultKind, Field, Frame};
use arrow_array::types::UInt32Type;
use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float32Array, Float64Array, Int64Array, RecordBatch, StringArray, UInt32Array,
};
use arrow_ipc::reader::FileReader;
use arrow_ipc::writer::FileWriter;
use arrow_schema::{DataType, Field as ArrowField, Schema};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// Encode a frame as the bytes of an Arrow IPC file; equal frames give equal bytes.
pub fn encode(frame: &Frame) -> Vec<u8> {
    let batch = batch(frame);
    let mut writer = FileWriter::try_new(Vec::new(), &batch.schema()).expect("writing to memory");
    writer.write(&batch).expect("writing to memory");
    writer.into_inner().expect("writing to memory")
}

/// The columns of a frame, with their units.
pub(crate) fn batch(frame: &Frame) -> RecordBatch {
    let mut fields = Vec::new();
    let mut arrays: Vec<ArrayRef> = Vec::new();
    for (field, column) in &frame.columns {
        let array: ArrayRef = match column {
            Column::F64(v) => Arc::new(Float64Array::from(v.clone())),
            Column::F32(v) => Arc::new(Float32Array::from(v.clone())),
            Column::I64(v) => Arc::new(Int64Array::from(v.clone())),
            Column::Category { codes, names } => Arc::new(
                DictionaryArray::<UInt32Type>::try_new(
                    UInt32Array::from(codes.clone()),
                    Arc::new(StringArray::from(names.clone())),
                )
                .expect("a category's codes index its names"),
            ),
        };
        let unit = HashMap::from([("unit".to_string(), field.unit.clone())]);
        fields.push(ArrowField::new(&field.name, array.data_type().clone(), false).with_metadata(unit));
        arrays.push(array);
    }
    // One key only, so that the metadata's order, and with it the bytes, cannot vary.
    let head = HashMap::from([("scree".to_string(), format!("frame={} time={}", frame.number, frame.time))]);
    let schema = Arc::new(Schema::new_with_metadata(fields, head));
    let options = arrow_array::RecordBatchOptions::new().with_row_count(Some(frame.rows()));
    RecordBatch::try_new_with_options(schema, arrays, &options).expect("equal columns")
}

/// Read a frame from an Arrow IPC file. A file that scree wrote holds the frame's number and time (s); of any other file they are
/// `number` and 0. An error if the file cannot be read, is no Arrow file or has columns of other types than those above.
pub fn read(path: &Path, number: u64) -> Result<Frame, Fault> {
    let bytes = guard::read(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    decode(path, bytes, number)
}

/// Decode a frame from the bytes of an Arrow IPC file, which came from `path`; as [`read`] in all else.
pub fn decode(path: &Path, bytes: Vec<u8>, number: u64) -> Result<Frame, Fault> {
    let damaged = |e: &dyn std::fmt::Display| {
        Fault::whole(FaultKind::Data, path, format!("is not a whole Arrow IPC file: {e}"))
            .hint("it is not as a run writes its frames: simulate again with --fresh")
    };
    layout::check(&bytes).map_err(|e| damaged(&e))?;
    let reader = FileReader::try_new(Cursor::new(bytes), None).map_err(|e| damaged(&e))?;
    let schema = reader.schema();
    let mut frame = Frame::new(number, 0.0);
    for word in schema.metadata().get("scree").map_or("", String::as_str).split(' ') {
        match word.split_once('=') {
            Some(("frame", n)) => frame.number = n.parse().map_err(|e| damaged(&e))?,
            Some(("time", t)) => frame.time = t.parse().map_err(|e| damaged(&e))?,
            _ => {}
        }
    }
    for field in schema.fields() {
        let unit = field.metadata().get("unit").cloned().unwrap_or_default();
        let empty = empty_column(field.data_type())
            .ok_or_else(|| damaged(&layout::refused(field.name(), field.data_type())))?;
        frame.columns.push((Field::new(field.name(), unit), empty));
    }
    for batch in reader {
        let batch = batch.map_err(|e| damaged(&e))?;
        for (i, (field, column)) in frame.columns.iter_mut().enumerate() {
            append(column, batch.column(i))
                .ok_or_else(|| damaged(&format!("column `{}` cannot be read", field.name)))?;
        }
    }
    Ok(frame)
}

/// What every Arrow IPC file begins with.
pub const MAGIC: &[u8] = b"ARROW1";

/// Read an Arrow IPC file of another program (Feather, version 2) as a table: columns of numbers of any type, of true and false, and of
/// words, compressed by LZ4 or not. In all else as [`read`].
pub fn read_table(path: &Path, number: u64) -> Result<Frame, Fault> {
    let bytes = guard::read(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let damaged = |e: &dyn std::fmt::Display| {
        let message = format!("is not an Arrow IPC file that can be read: {}", guard::text::line(&e.to_string()));
        Fault::whole(FaultKind::Data, path, message)
            .hint("the file is cut off or damaged, or has columns of other types")
    };
    layout::check_table(&bytes).map_err(|e| damaged(&e))?;
    let open = |read| FileReader::try_new(Cursor::new(&bytes[..]), read).map_err(|e| damaged(&e));
    let schema = open(None)?.schema();
    // Dates, lists and their like are left out.
    let read: Vec<usize> =
        (0..schema.fields().len()).filter(|k| columns::is_read(schema.field(*k).data_type())).collect();
    let schema = schema.project(&read).map_err(|e| damaged(&e))?;
    let reader = open(Some(read))?;
    let mut batches = vec![];
    for batch in reader {
        batches.push(batch.map_err(|e| damaged(&e))?);
        guard::memory::check().map_err(|e| damaged(&e))?;
    }
    columns::frame(number, &schema, &batches).map_err(|e| damaged(&e))
}

fn empty_column(data_type: &DataType) -> Option<Column> {
    Some(match data_type {
        DataType::Float64 => Column::F64(vec![]),
        DataType::Float32 => Column::F32(vec![]),
        DataType::Int64 => Column::I64(vec![]),
        DataType::Dictionary(key, value) if **key == DataType::UInt32 && **value == DataType::Utf8 => {
            Column::Category { codes: vec![], names: vec![] }
        }
        _ => return None,
    })
}

fn append(column: &mut Column, array: &ArrayRef) -> Option<()> {
    let any = array.as_any();
    match column {
        Column::F64(v) => v.extend_from_slice(any.downcast_ref::<Float64Array>()?.values()),
        Column::F32(v) => v.extend_from_slice(any.downcast_ref::<Float32Array>()?.values()),
        Column::I64(v) => v.extend_from_slice(any.downcast_ref::<Int64Array>()?.values()),
        Column::Category { codes, names } => {
            let words = any.downcast_ref::<DictionaryArray<UInt32Type>>()?;
            let values = words.values().as_any().downcast_ref::<StringArray>()?;
            let base = names.len() as u32;
            names.extend((0..values.len()).map(|i| values.value(i).to_string()));
            codes.extend(words.keys().values().iter().map(|c| c + base));
        }
    }
    Some(())
}
