//! Contact logs as Parquet: the columns of [`contact_csv`](crate::io::log::contact_csv) with a
//! header, of numbers (the contact flag may be BOOLEAN), uncompressed, snappy, gzip or zstd. A few
//! thousand rows are in memory at a time.

use std::fs::File;
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::numbers::NumberRows;
use super::options::Options;
use super::rows::RowSink;
use crate::io::base::bounded_pages::BoundedPages;
use crate::io::base::error::{IoError, Place, caught};
use crate::io::base::number_columns::{NumberColumns, damaged};
use crate::robot::Robot;

/// Passes the rows of a file's content to `sink`; `file` is its name for messages and provenance.
pub(super) fn read(
    content: impl ChunkReader + 'static,
    file: &str,
    robot: &Robot,
    options: &Options,
    sink: &mut dyn RowSink,
) -> Result<(), IoError> {
    caught(file, "Parquet", || read_groups(content, file, robot, options, sink))
}

fn read_groups(
    content: impl ChunkReader + 'static,
    file: &str,
    robot: &Robot,
    options: &Options,
    sink: &mut dyn RowSink,
) -> Result<(), IoError> {
    let reader = SerializedFileReader::new(BoundedPages(content)).map_err(|error| damaged(file, &error))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let names: Vec<&[u8]> = schema.columns().iter().map(|column| column.name().as_bytes()).collect();
    let at = |file: &str, row| Place::file(file).field(format!("row {row}"));
    let mut rows = NumberRows::new(&names, (file, at), (robot, options), sink)?;
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(|error| damaged(file, &error))?;
        let mut numbers = NumberColumns::new(group.as_ref(), rows.used(), file)?;
        loop {
            let count = numbers.advance()?;
            if count == 0 {
                break;
            }
            for row in 0..count {
                rows.take(|k| numbers.value(k, row))?;
            }
        }
    }
    rows.finish()
}

/// Rows of a group that is written.
const GROUP: usize = 1 << 16;

/// Writes rows of these columns: DOUBLE, the contact flag BOOLEAN.
pub(super) fn write<'r>(
    file: &mut File,
    columns: &[&str],
    mut rows: impl Iterator<Item = &'r [f64]>,
) -> Result<(), ParquetError> {
    let is_flag = |name: &str| name == "contact";
    let field = |name: &&str| {
        let kind = if is_flag(name) { PhysicalType::BOOLEAN } else { PhysicalType::DOUBLE };
        Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("log").with_fields(fields).build()?);
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
    loop {
        let batch: Vec<&[f64]> = rows.by_ref().take(GROUP).collect();
        if batch.is_empty() {
            break;
        }
        let mut group = writer.next_row_group()?;
        for (k, name) in columns.iter().enumerate() {
            let Some(mut column) = group.next_column()? else { break };
            if is_flag(name) {
                let values: Vec<bool> = batch.iter().map(|row| row[k] == 1.0).collect();
                column.typed::<BoolType>().write_batch(&values, None, None)?;
            } else {
                let values: Vec<f64> = batch.iter().map(|row| row[k]).collect();
                column.typed::<DoubleType>().write_batch(&values, None, None)?;
            }
            column.close()?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}
