//! Rows of trials with false declarations as Parquet: one row a trial, its columns as the fields of
//! [`FalsifiedRow`], lengths in mm. Texts are UTF-8, the warnings' kinds with a blank between them;
//! a number that a row does not have is NaN.

use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::parser::parse_message_type;

use crate::experiment::falsified::FalsifiedRow;
use crate::io::base::error::{IoError, Place};

/// What a column holds of a row.
enum Values {
    Text(fn(&FalsifiedRow) -> String),
    Count(fn(&FalsifiedRow) -> u64),
    Flag(fn(&FalsifiedRow) -> bool),
    Measure(fn(&FalsifiedRow) -> f64),
}

use Values::{Count, Flag, Measure, Text};

const COLUMNS: [(&str, Values); 12] = [
    ("kind", Text(|row| row.kind.clone())),
    ("excitation", Text(|row| row.excitation.clone())),
    ("seed", Count(|row| row.seed)),
    ("contacts", Count(|row| row.contacts)),
    ("status", Text(|row| row.status.clone())),
    ("nees", Measure(|row| row.nees.unwrap_or(f64::NAN))),
    ("degrees_of_freedom", Count(|row| row.degrees_of_freedom)),
    ("honest", Flag(|row| row.honest)),
    ("useful", Flag(|row| row.useful)),
    ("tool_error_mm", Measure(|row| 1e3 * row.tool_error)),
    ("tool_sigma_mm", Measure(|row| 1e3 * row.tool_sigma.unwrap_or(f64::NAN))),
    ("warnings", Text(|row| row.warnings.join(" "))),
];

/// The Parquet file of `rows`, in their order, as bytes; a seed above 2⁶³ keeps its bits.
///
/// # Errors
/// [`IoError::Syntax`] if the parquet crate cannot write them.
pub fn to_bytes(rows: &[FalsifiedRow]) -> Result<Vec<u8>, IoError> {
    encoded(rows).map_err(|error| IoError::syntax(Place::file("falsified.parquet"), error.to_string()))
}

fn encoded(rows: &[FalsifiedRow]) -> Result<Vec<u8>, ParquetError> {
    let fields = COLUMNS.map(|(name, values)| match values {
        Text(_) => format!("required binary {name} (UTF8);"),
        Count(_) => format!("required int64 {name};"),
        Flag(_) => format!("required boolean {name};"),
        Measure(_) => format!("required double {name};"),
    });
    let schema = Arc::new(parse_message_type(&format!("message trial {{ {} }}", fields.concat()))?);
    let properties = Arc::new(WriterProperties::builder().set_compression(Compression::SNAPPY).build());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties)?;
    let mut group = writer.next_row_group()?;
    let mut columns = COLUMNS.iter();
    while let Some(mut column) = group.next_column()? {
        if let Some((_, values)) = columns.next() {
            write_column(&mut column, values, rows)?;
        }
        column.close()?;
    }
    group.close()?;
    writer.into_inner()
}

fn write_column(
    column: &mut SerializedColumnWriter<'_>,
    values: &Values,
    rows: &[FalsifiedRow],
) -> Result<(), ParquetError> {
    match values {
        Text(of) => {
            let texts: Vec<ByteArray> = rows.iter().map(|row| ByteArray::from(of(row).into_bytes())).collect();
            column.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
        }
        Count(of) => {
            let counts: Vec<i64> = rows.iter().map(|row| of(row).cast_signed()).collect();
            column.typed::<Int64Type>().write_batch(&counts, None, None)?;
        }
        Flag(of) => {
            let flags: Vec<bool> = rows.iter().map(of).collect();
            column.typed::<BoolType>().write_batch(&flags, None, None)?;
        }
        Measure(of) => {
            let measures: Vec<f64> = rows.iter().map(of).collect();
            column.typed::<DoubleType>().write_batch(&measures, None, None)?;
        }
    }
    Ok(())
}
