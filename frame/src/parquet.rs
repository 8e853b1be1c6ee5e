//! Parquet files as frames: columns of numbers, true and false as 1 and 0, and words (Apache Parquet, file format). Values that are
//! missing are not-a-numbers, or empty words.

mod pages;

use crate::arrow::columns;
use crate::{Fault, FaultKind, Frame};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

/// What every Parquet file begins with.
pub const MAGIC: &[u8] = b"PAR1";

const DAMAGED: &str = "the file is cut off, damaged, or still being written";
const PACKED: &str = "compressions that are read are snappy, gzip, lz4 and zstd; write it so, as by: table.to_parquet(FILE, compression='snappy')";

/// Read a file as the frame `number`, at time 0.
pub fn read(path: &Path, number: u64) -> Result<Frame, Fault> {
    // The decoder takes what a file says of itself for true in places.
    let own = catch_unwind(AssertUnwindSafe(|| decode(path, number)));
    own.unwrap_or_else(|_| Err(fault(path, "is not a whole Parquet file").hint(DAMAGED)))
}

fn fault(path: &Path, message: impl Into<String>) -> Fault {
    Fault::whole(FaultKind::Data, path, message)
}

fn decode(path: &Path, number: u64) -> Result<Frame, Fault> {
    let damaged = |e: &dyn std::fmt::Display| {
        let said = guard::text::line(&e.to_string());
        let hint = if said.contains("Disabled feature") { PACKED } else { DAMAGED };
        fault(path, format!("is not a Parquet file that can be read: {said}")).hint(hint)
    };
    let mut file = guard::open(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let own = file.try_clone().map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    // The schema of Arrow that some writers add is not needed, and its decoder trusts it.
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let builder = ParquetRecordBatchReaderBuilder::try_new_with_options(own, options).map_err(|e| damaged(&e))?;
    // Columns of other types, as dates and lists, are left out.
    let fields = builder.schema().fields();
    let read: Vec<usize> = (0..fields.len()).filter(|k| columns::is_read(fields[*k].data_type())).collect();
    if read.is_empty() {
        let types: Vec<String> =
            fields.iter().map(|f| format!("`{}` has the type {}", f.name(), f.data_type())).collect();
        let hint = "columns that are read are of numbers, of true and false, or of words";
        return Err(fault(path, format!("has no column that can be read: {}", types.join(", "))).hint(hint));
    }
    let mask = ProjectionMask::roots(builder.parquet_schema(), read.iter().copied());
    let schema = Arc::new(builder.schema().project(&read).map_err(|e| damaged(&e))?);
    let too_large = || fault(path, format!("is too large: {}", guard::memory::Full));
    let (mut rows, mut bytes) = (0u64, 0u64);
    for group in builder.metadata().row_groups() {
        rows = rows.saturating_add(u64::try_from(group.num_rows()).unwrap_or(u64::MAX));
        for column in group.columns() {
            let page = column.dictionary_page_offset().unwrap_or(0).min(column.data_page_offset());
            if page.min(column.compressed_size()).min(column.uncompressed_size()) < 0 {
                return Err(damaged(&"a part of it has a negative place or length"));
            }
            bytes = bytes.saturating_add(u64::try_from(column.uncompressed_size()).unwrap_or(u64::MAX));
            if !pages::fit(&mut file, column, guard::memory::room()).map_err(|e| damaged(&e))? {
                return Err(too_large());
            }
        }
    }
    // Values are there as they are read, and as columns.
    let values = rows.saturating_mul(builder.schema().fields().len() as u64).saturating_mul(16);
    if values.max(bytes) > guard::memory::room() {
        return Err(too_large());
    }
    let reader = builder.with_projection(mask).with_batch_size(1 << 16).build().map_err(|e| damaged(&e))?;
    let mut batches = vec![];
    for batch in reader {
        batches.push(batch.map_err(|e| damaged(&e))?);
        guard::memory::check().map_err(|e| fault(path, format!("is too large: {e}")))?;
    }
    columns::frame(number, &schema, &batches).map_err(|e| fault(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, table};
    use arrow_array::types::Int32Type;
    use arrow_array::{
        ArrayRef, BooleanArray, DictionaryArray, Float32Array, Float64Array, Int32Array, RecordBatch, StringArray,
        UInt64Array,
    };
    use arrow_ipc::CompressionType;
    use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
    use parquet::arrow::ArrowWriter;
    use parquet::basic::{Compression, GzipLevel, ZstdLevel};
    use parquet::file::properties::WriterProperties;

    /// A table with columns of all kinds, some of whose values are missing.
    fn batch() -> RecordBatch {
        let kinds: DictionaryArray<Int32Type> = [Some("stone"), None, Some("stone")].into_iter().collect();
        let columns: [(&str, ArrayRef); 8] = [
            ("x", Arc::new(Float64Array::from(vec![0.5, 1.5, 2.5]))),
            ("r", Arc::new(Float32Array::from(vec![Some(1.0), None, Some(0.25)]))),
            ("id", Arc::new(Int32Array::from(vec![3, -2, 1]))),
            ("part", Arc::new(Int32Array::from(vec![Some(3), None, Some(1)]))),
            ("hash", Arc::new(UInt64Array::from(vec![u64::MAX, 1, 2]))),
            ("fixed", Arc::new(BooleanArray::from(vec![true, false, true]))),
            ("name", Arc::new(StringArray::from(vec![Some("a"), Some("b"), None]))),
            ("kind", Arc::new(kinds)),
        ];
        RecordBatch::try_from_iter_with_nullable(columns.map(|(name, column)| (name, column, true))).unwrap()
    }

    fn parquet(compression: Compression) -> Vec<u8> {
        let options = WriterProperties::builder().set_compression(compression).build();
        let mut writer = ArrowWriter::try_new(vec![], batch().schema(), Some(options)).unwrap();
        writer.write(&batch()).unwrap();
        writer.into_inner().unwrap()
    }

    fn feather(compression: Option<CompressionType>) -> Vec<u8> {
        let options = IpcWriteOptions::default().try_with_compression(compression).unwrap();
        let mut writer = FileWriter::try_new_with_options(vec![], &batch().schema(), options).unwrap();
        writer.write(&batch()).unwrap();
        writer.into_inner().unwrap()
    }

    /// Read bytes as the table that they are.
    fn frame(bytes: &[u8]) -> Result<Frame, Fault> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t_4.bin");
        std::fs::write(&path, bytes).unwrap();
        table::find(&path)?[&4].read(4, &Default::default())
    }

    fn all() -> Vec<Vec<u8>> {
        let compressions = [
            Compression::UNCOMPRESSED,
            Compression::SNAPPY,
            Compression::GZIP(GzipLevel::default()),
            Compression::LZ4_RAW,
            Compression::ZSTD(ZstdLevel::default()),
        ];
        let mut all: Vec<Vec<u8>> = compressions.into_iter().map(parquet).collect();
        all.extend([None, Some(CompressionType::LZ4_FRAME), Some(CompressionType::ZSTD)].map(feather));
        all
    }

    #[test]
    fn columns_of_all_kinds_are_read() {
        for bytes in all() {
            let own = frame(&bytes).unwrap();
            assert_eq!(own.names(), ["x", "r", "id", "part", "hash", "fixed", "name", "kind"]);
            let column = |name: &str| own.column(name).unwrap();
            assert_eq!(column("x"), &Column::F64(vec![0.5, 1.5, 2.5]));
            assert_eq!(column("id"), &Column::I64(vec![3, -2, 1]));
            assert_eq!(column("fixed"), &Column::I64(vec![1, 0, 1]));
            assert_eq!(column("hash"), &Column::F64(vec![u64::MAX as f64, 1.0, 2.0]));
            for name in ["r", "part"] {
                let missing = [0, 1, 2].map(|row| column(name).number(row).unwrap().is_nan());
                assert_eq!(missing, [false, true, false], "{name}");
            }
            assert_eq!([0, 1, 2].map(|row| column("name").text(row)), ["a", "b", ""]);
            assert_eq!([0, 1, 2].map(|row| column("kind").text(row)), ["stone", "", "stone"]);
            assert_eq!((own.number, own.time), (4, 0.0));
        }
    }

    #[test]
    fn damaged_files_are_faults() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut state = 7u64;
        let mut random = |n: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % n.max(1)
        };
        let files = all();
        let mut n_bad = 0;
        for k in 0..600 {
            let mut file = files[k % files.len()].clone();
            for _ in 0..1 + random(2) {
                let at = random(file.len() - 1);
                match random(8) {
                    0 => file.truncate(at + 1),
                    1 => file[at] = random(256) as u8,
                    _ => file[at] ^= 1 << random(8),
                }
            }
            std::fs::write(&path, &file).unwrap();
            let own = if k % files.len() < 5 { read(&path, 0) } else { crate::arrow::read_table(&path, 0) };
            n_bad += usize::from(own.is_err());
        }
        assert!(n_bad > 100, "{n_bad}");
    }

    #[test]
    fn pages_that_unpack_without_end_are_refused() {
        let zeros = RecordBatch::try_from_iter([("x", Arc::new(Float64Array::from(vec![0.0; 1 << 21])) as ArrayRef)]);
        let zeros = zeros.unwrap();
        for compression in [Compression::GZIP(GzipLevel::default()), Compression::ZSTD(ZstdLevel::default())] {
            let options = WriterProperties::builder()
                .set_compression(compression)
                .set_dictionary_enabled(false)
                .set_data_page_size_limit(1 << 30)
                .set_data_page_row_count_limit(1 << 21)
                .set_write_batch_size(1 << 21)
                .build();
            let mut writer = ArrowWriter::try_new(vec![], zeros.schema(), Some(options)).unwrap();
            writer.write(&zeros).unwrap();
            let bytes = writer.into_inner().unwrap();
            let mut file = tempfile::tempfile().unwrap();
            std::io::Write::write_all(&mut file, &bytes).unwrap();
            let own = ParquetRecordBatchReaderBuilder::try_new(file.try_clone().unwrap()).unwrap();
            let column = own.metadata().row_group(0).column(0);
            let fits = |room: u64| pages::fit(&mut file.try_clone().unwrap(), column, room).unwrap();
            assert!(fits(1 << 26) && !fits(1 << 22), "{compression}");
            assert_eq!(frame(&bytes).unwrap().rows(), 1 << 21);
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        let dates = arrow_array::Date32Array::from(vec![1, 2]);
        let written = |columns: Vec<(&str, ArrayRef)>| {
            let batch = RecordBatch::try_from_iter(columns).unwrap();
            let mut writer = ArrowWriter::try_new(vec![], batch.schema(), None).unwrap();
            writer.write(&batch).unwrap();
            writer.into_inner().unwrap()
        };
        let dates: ArrayRef = Arc::new(dates);
        let fault = frame(&written(vec![("day", dates.clone())])).unwrap_err();
        assert!(fault.message.contains("`day` has the type Date32"), "{fault}");
        let numbers: ArrayRef = Arc::new(Float64Array::from(vec![1.0, 2.0]));
        let own = frame(&written(vec![("day", dates.clone()), ("x", numbers), ("end", dates)])).unwrap();
        assert_eq!((own.names(), own.column("x")), (vec!["x"], Some(&Column::F64(vec![1.0, 2.0]))));
        let whole = parquet(Compression::SNAPPY);
        assert!(frame(&whole[..whole.len() - 9]).unwrap_err().hint.unwrap().contains("cut off"));
    }
}
