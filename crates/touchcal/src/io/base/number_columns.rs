//! Numbers of a Parquet file's columns, side by side, a batch of rows at a time.

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::RowGroupReader;

use crate::io::base::error::{IoError, Place};

/// Rows read at a time.
const BATCH: usize = 8192;

/// Columns of a row group. Of each, no more is in memory than a page and a batch.
pub(crate) struct NumberColumns<'a> {
    file: &'a str,
    columns: Vec<Column>,
}

struct Column {
    name: String,
    reader: ColumnReader,
    values: Vec<f64>,
}

impl<'a> NumberColumns<'a> {
    /// The columns of these indices and names.
    pub(crate) fn new<'n>(
        group: &dyn RowGroupReader,
        used: impl Iterator<Item = (usize, &'n str)>,
        file: &'a str,
    ) -> Result<Self, IoError> {
        let column = |(index, name): (usize, &str)| {
            if group.metadata().column(index).column_descr().max_rep_level() > 0 {
                return Err(unfit(file, name, "lists".to_owned()));
            }
            let reader = group.get_column_reader(index).map_err(|error| damaged(file, &error))?;
            Ok(Column { name: name.to_owned(), reader, values: Vec::new() })
        };
        Ok(NumberColumns { file, columns: used.map(column).collect::<Result<_, _>>()? })
    }

    /// Goes on to the next rows; says how many, none at the end.
    pub(crate) fn advance(&mut self) -> Result<usize, IoError> {
        let file = self.file;
        for Column { name, reader, values } in &mut self.columns {
            values.clear();
            let whole = match reader {
                ColumnReader::DoubleColumnReader(reader) => batch(reader, values, |&value| value),
                ColumnReader::FloatColumnReader(reader) => batch(reader, values, |&value| f64::from(value)),
                ColumnReader::Int32ColumnReader(reader) => batch(reader, values, |&value| f64::from(value)),
                ColumnReader::Int64ColumnReader(reader) => batch(reader, values, |&value| value as f64),
                ColumnReader::BoolColumnReader(reader) => batch(reader, values, |&value| f64::from(u8::from(value))),
                _ => return Err(unfit(file, name, "other values".to_owned())),
            };
            if !whole.map_err(|error| damaged(file, &error))? {
                return Err(unfit(file, name, "an empty cell".to_owned()));
            }
        }
        let rows = self.columns.first().map_or(0, |column| column.values.len());
        if let Some(other) = self.columns.iter().find(|column| column.values.len() != rows) {
            let found = format!("{rows} and {}", other.values.len());
            return Err(IoError::unexpected(Place::file(file), "as many values in each column", found));
        }
        Ok(rows)
    }

    /// The value of column `k`, as it was counted in [`NumberColumns::new`], in row `row` of those
    /// present.
    pub(crate) fn value(&self, k: usize, row: usize) -> f64 {
        self.columns[k].values[row]
    }
}

/// Values of a batch; whether no row lacks one.
fn batch<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    values: &mut Vec<f64>,
    number: impl Fn(&T::T) -> f64,
) -> Result<bool, ParquetError> {
    let (mut raw, mut levels) = (Vec::new(), Vec::new());
    let (records, present, _) = reader.read_records(BATCH, Some(&mut levels), None, &mut raw)?;
    values.extend(raw.iter().map(number));
    Ok(present == records)
}

fn unfit(file: &str, name: &str, found: String) -> IoError {
    let place = Place::file(file).field(format!("column {name}"));
    IoError::unexpected(place, "numbers, one in each row", found)
}

/// A file that the parquet crate cannot read.
pub(crate) fn damaged(file: &str, error: &ParquetError) -> IoError {
    IoError::unexpected(Place::file(file), "a whole Parquet file", error.to_string())
}
