//! Columns from arrays of Arrow of any flat type: numbers, true and false as 1 and 0, words. What is missing is not-a-number, or an
//! empty word.

use crate::{Column, Field, Frame};
use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type,
    UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, Schema};
use std::collections::{HashMap, HashSet};

/// The frame of some batches of rows, at time 0. An error says which column cannot be read.
pub(crate) fn frame(number: u64, schema: &Schema, batches: &[RecordBatch]) -> Result<Frame, String> {
    let mut frame = Frame::new(number, 0.0);
    let mut seen = HashSet::new();
    for (k, field) in schema.fields().iter().enumerate() {
        let arrays: Vec<&ArrayRef> = batches.iter().filter_map(|batch| batch.columns().get(k)).collect();
        let column = column(field.data_type(), &arrays).ok_or_else(|| refused(field.name(), field.data_type()))?;
        let mut name = field.name().clone();
        let mut k = 2;
        while !seen.insert(name.clone()) {
            name = format!("{}_{k}", field.name());
            k += 1;
        }
        let unit = field.metadata().get("unit").cloned().unwrap_or_default();
        frame.columns.push((Field::new(name, unit), column));
        guard::memory::check().map_err(|e| format!("it is too large: {e}"))?;
    }
    Ok(frame)
}

/// Why a column of this type is none that a frame can hold.
pub(super) fn refused(name: &str, kind: &dyn std::fmt::Display) -> String {
    format!("column `{name}` has type {kind}, which is not a number, true or false, or a word")
}

/// Whether columns of a type are read.
pub(crate) fn is_read(kind: &DataType) -> bool {
    column(kind, &[]).is_some()
}

fn column(kind: &DataType, arrays: &[&ArrayRef]) -> Option<Column> {
    Some(match kind {
        DataType::Float64 => Column::F64(floats::<Float64Type, _>(arrays, f64::NAN, |x| x)?),
        DataType::Float32 => Column::F32(floats::<Float32Type, _>(arrays, f32::NAN, |x| x)?),
        DataType::Float16 => Column::F32(floats::<Float16Type, _>(arrays, f32::NAN, |x| x.to_f32())?),
        DataType::Int8 => whole::<Int8Type>(arrays, |x| Some(x.into()), f64::from)?,
        DataType::Int16 => whole::<Int16Type>(arrays, |x| Some(x.into()), f64::from)?,
        DataType::Int32 => whole::<Int32Type>(arrays, |x| Some(x.into()), f64::from)?,
        DataType::Int64 => whole::<Int64Type>(arrays, Some, |x| x as f64)?,
        DataType::UInt8 => whole::<UInt8Type>(arrays, |x| Some(x.into()), f64::from)?,
        DataType::UInt16 => whole::<UInt16Type>(arrays, |x| Some(x.into()), f64::from)?,
        DataType::UInt32 => whole::<UInt32Type>(arrays, |x| Some(x.into()), f64::from)?,
        DataType::UInt64 => whole::<UInt64Type>(arrays, |x| i64::try_from(x).ok(), |x| x as f64)?,
        DataType::Boolean => truths(arrays)?,
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => words(arrays)?,
        DataType::Dictionary(_, values) if is_words(values) => words(arrays)?,
        _ => return None,
    })
}

fn is_words(kind: &DataType) -> bool {
    matches!(kind, DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View)
}

/// The words of an array that is no dictionary; none where one is missing.
fn texts(array: &ArrayRef) -> Option<Box<dyn Iterator<Item = Option<&str>> + '_>> {
    if let Some(own) = array.as_string_opt::<i32>() {
        return Some(Box::new(own.iter()));
    }
    if let Some(own) = array.as_string_opt::<i64>() {
        return Some(Box::new(own.iter()));
    }
    array.as_string_view_opt().map(|own| Box::new(own.iter()) as _)
}

fn floats<T: ArrowPrimitiveType, X: Copy>(arrays: &[&ArrayRef], nan: X, to: impl Fn(T::Native) -> X) -> Option<Vec<X>> {
    let mut all = Vec::with_capacity(arrays.iter().map(|array| array.len()).sum());
    for array in arrays {
        let own = array.as_primitive_opt::<T>()?;
        match own.nulls() {
            None => all.extend(own.values().iter().map(|x| to(*x))),
            Some(_) => all.extend(own.iter().map(|x| x.map_or(nan, &to))),
        }
    }
    Some(all)
}

/// Whole numbers; as such of double precision if some are missing or too large.
fn whole<T: ArrowPrimitiveType>(
    arrays: &[&ArrayRef],
    to: impl Fn(T::Native) -> Option<i64>,
    float: impl Fn(T::Native) -> f64,
) -> Option<Column> {
    if arrays.iter().all(|array| array.null_count() == 0) {
        let own = arrays.iter().map(|array| array.as_primitive_opt::<T>()).collect::<Option<Vec<_>>>()?;
        let all: Option<Vec<i64>> = own.iter().flat_map(|own| own.values().iter().map(|x| to(*x))).collect();
        if let Some(all) = all {
            return Some(Column::I64(all));
        }
    }
    Some(Column::F64(floats::<T, f64>(arrays, f64::NAN, float)?))
}

fn truths(arrays: &[&ArrayRef]) -> Option<Column> {
    let own = arrays.iter().map(|array| array.as_boolean_opt()).collect::<Option<Vec<_>>>()?;
    let all = || own.iter().flat_map(|own| own.iter());
    if all().all(|value| value.is_some()) {
        return Some(Column::I64(all().map(|value| i64::from(value == Some(true))).collect()));
    }
    let number = |value: Option<bool>| value.map_or(f64::NAN, |value| f64::from(u8::from(value)));
    Some(Column::F64(all().map(number).collect()))
}

/// Words, of dictionaries or by themselves.
fn words(arrays: &[&ArrayRef]) -> Option<Column> {
    let mut names: Vec<String> = vec![];
    let mut seen: HashMap<String, u32> = HashMap::new();
    let mut code_of = |word: &str| match seen.get(word) {
        Some(code) => *code,
        None => {
            let code = names.len() as u32;
            seen.insert(word.into(), code);
            names.push(word.into());
            code
        }
    };
    let mut codes = Vec::with_capacity(arrays.iter().map(|array| array.len()).sum());
    for array in arrays {
        let Some(dictionary) = array.as_any_dictionary_opt() else {
            codes.extend(texts(array)?.map(|word| code_of(word.unwrap_or(""))));
            continue;
        };
        let own: Vec<u32> = texts(dictionary.values())?.map(|word| code_of(word.unwrap_or(""))).collect();
        let keys = if own.is_empty() { vec![0; array.len()] } else { dictionary.normalized_keys() };
        for (row, key) in keys.into_iter().enumerate() {
            codes.push(if array.is_null(row) { code_of("") } else { *own.get(key)? });
        }
    }
    Some(Column::Category { codes, names })
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::builder::{Float64Builder, ListBuilder};
    use arrow_array::{DictionaryArray, Float64Array, StringViewArray, TimestampMicrosecondArray, UInt32Array};
    use arrow_ipc::writer::FileWriter;
    use std::sync::Arc;

    /// A file with words by views, as polars writes them, and with columns that are left out.
    fn file() -> Vec<u8> {
        let words = || StringViewArray::from(vec!["stone", "a word of more than twelve letters", ""]);
        let mut lists = ListBuilder::new(Float64Builder::new());
        [vec![1.0], vec![], vec![2.0, 3.0]].into_iter().for_each(|own| {
            lists.values().append_slice(&own);
            lists.append(true);
        });
        let kinds = DictionaryArray::new(UInt32Array::from(vec![1, 0, 1]), Arc::new(words()));
        let columns: Vec<(&str, ArrayRef)> = vec![
            ("when", Arc::new(TimestampMicrosecondArray::from(vec![1, 2, 3]))),
            ("name", Arc::new(words())),
            ("all", Arc::new(lists.finish())),
            ("kind", Arc::new(kinds)),
            ("x", Arc::new(Float64Array::from(vec![0.5, 1.5, 2.5]))),
        ];
        let batch = RecordBatch::try_from_iter(columns).unwrap();
        let mut writer = FileWriter::try_new(vec![], &batch.schema()).unwrap();
        writer.write(&batch).unwrap();
        writer.into_inner().unwrap()
    }

    #[test]
    fn words_by_views_are_read_and_lists_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.arrow");
        let whole = file();
        std::fs::write(&path, &whole).unwrap();
        let own = crate::arrow::read_table(&path, 0).unwrap();
        assert_eq!(own.names(), ["name", "kind", "x"]);
        let texts = |name: &str| [0, 1, 2].map(|row| own.column(name).unwrap().text(row));
        assert_eq!(texts("name"), ["stone", "a word of more than twelve letters", ""]);
        assert_eq!(
            texts("kind"),
            ["a word of more than twelve letters", "stone", "a word of more than twelve letters"]
        );
        assert_eq!(own.column("x"), Some(&Column::F64(vec![0.5, 1.5, 2.5])));
        // Any byte may be another.
        for at in 0..whole.len() {
            for wrong in [0, 0xff, whole[at] ^ 1, whole[at] ^ 0x40] {
                let mut bytes = whole.clone();
                bytes[at] = wrong;
                std::fs::write(&path, &bytes).unwrap();
                let _ = crate::arrow::read_table(&path, 0);
            }
        }
    }
}
