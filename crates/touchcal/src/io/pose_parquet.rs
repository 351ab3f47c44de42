//! Poses of a tool in contact as Parquet: the columns of [`pose_file`](super::pose_file), of type DOUBLE or FLOAT, uncompressed, snappy or gzip.

use std::panic::{AssertUnwindSafe, catch_unwind};

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader, RowGroupReader, SerializedFileReader};

use super::error::{IoError, Place};
use super::pose_file::{COLUMNS, MAX_POSES, columns, pose};
use crate::se3::Pose;

/// Values read at a time.
const BATCH: usize = 8192;

/// Reads the poses of a file's content; `file` is its name for messages.
///
/// Some damage makes the parquet crate panic (60.1: a negative offset, a page whose dictionary is missing). That is caught here and is an error
/// as any other, though the panic hook has its say.
pub(super) fn read(content: impl ChunkReader + 'static, file: &str) -> Result<Vec<Pose>, IoError> {
    catch_unwind(AssertUnwindSafe(|| read_groups(content, file)))
        .unwrap_or_else(|_| Err(IoError::unexpected(Place::file(file), "a whole Parquet file", "damaged data")))
}

fn read_groups(content: impl ChunkReader + 'static, file: &str) -> Result<Vec<Pose>, IoError> {
    let damaged =
        |error: ParquetError| IoError::unexpected(Place::file(file), "a whole Parquet file", error.to_string());
    let reader = SerializedFileReader::new(content).map_err(damaged)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let names: Vec<&[u8]> = schema.columns().iter().map(|column| column.name().as_bytes()).collect();
    let used = columns(&names, Place::file(file))?;
    let mut poses = Vec::new();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(damaged)?;
        let mut values: [Vec<f64>; 7] = Default::default();
        for (k, values) in values.iter_mut().enumerate() {
            let place = Place::file(file).field(format!("column {}", COLUMNS[k]));
            let limit = MAX_POSES - poses.len();
            *values = column(group.as_ref(), used[k], limit, place).map_err(|error| error.or_else_io(damaged))?;
            if values.len() > limit {
                return Err(IoError::unexpected(Place::file(file), format!("at most {MAX_POSES} poses"), "more"));
            }
        }
        let rows = values[0].len();
        if let Some(other) = values.iter().find(|values| values.len() != rows) {
            let found = format!("{rows} and {}", other.len());
            return Err(IoError::unexpected(Place::file(file), "as many values in each column", found));
        }
        for row in 0..rows {
            let place = Place::file(file).field(format!("row {}", poses.len() + 1));
            let values: [f64; 7] = std::array::from_fn(|k| values[k][row]);
            if let Some(k) = values.iter().position(|value| !value.is_finite()) {
                let found = format!("{} in column {}", values[k], COLUMNS[k]);
                return Err(IoError::unexpected(place, "finite numbers", found));
            }
            poses.push(pose(&values, place)?);
        }
    }
    Ok(poses)
}

/// Why a column cannot be read.
enum ColumnError {
    Damaged(ParquetError),
    Unfit(IoError),
}

impl ColumnError {
    fn or_else_io(self, damaged: impl FnOnce(ParquetError) -> IoError) -> IoError {
        match self {
            ColumnError::Damaged(error) => damaged(error),
            ColumnError::Unfit(error) => error,
        }
    }
}

/// The numbers of column `index`; a few more than `limit` where there are more.
fn column(group: &dyn RowGroupReader, index: usize, limit: usize, place: Place) -> Result<Vec<f64>, ColumnError> {
    let descriptor = group.metadata().column(index).column_descr_ptr();
    let unfit = |found: String| {
        let expected = "numbers of type DOUBLE or FLOAT, one in each row";
        ColumnError::Unfit(IoError::unexpected(place.clone(), expected, found))
    };
    if descriptor.max_rep_level() > 0 {
        return Err(unfit("lists".to_owned()));
    }
    let (values, missing) = match group.get_column_reader(index).map_err(ColumnError::Damaged)? {
        ColumnReader::DoubleColumnReader(reader) => numbers(reader, limit),
        ColumnReader::FloatColumnReader(reader) => numbers(reader, limit),
        _ => return Err(unfit(format!("{}", descriptor.physical_type()))),
    }
    .map_err(ColumnError::Damaged)?;
    if missing { Err(unfit("an empty cell".to_owned())) } else { Ok(values) }
}

/// Values, and whether some are missing.
fn numbers<T: DataType>(mut reader: ColumnReaderImpl<T>, limit: usize) -> Result<(Vec<f64>, bool), ParquetError>
where
    f64: From<T::T>,
{
    let (mut all, mut batch, mut levels) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        batch.clear();
        levels.clear();
        let (records, values, _) = reader.read_records(BATCH, Some(&mut levels), None, &mut batch)?;
        all.extend(batch.drain(..).map(f64::from));
        if values < records {
            return Ok((all, true));
        }
        if records == 0 || all.len() > limit {
            return Ok((all, false));
        }
    }
}
