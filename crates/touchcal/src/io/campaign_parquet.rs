//! Rows of a campaign as Parquet, a part of it a file: columns of the names of [`CampaignRow`], counts INT64, measures DOUBLE; in the file's metadata under
//! `touchcal` what the rows depend on.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::RowAccessor;
use parquet::schema::parser::parse_message_type;

use super::bytes;
use super::error::{IoError, Place};
use crate::experiment::CampaignRow;

/// Key of what the rows depend on.
const KEY: &str = "touchcal";
/// Largest part read (bytes).
const MAX_BYTES: u64 = 256 << 20;

const COUNTS: [&str; 9] =
    ["trial", "seed", "contacts", "status", "parameters", "inside_50", "inside_90", "inside_95", "inside_99"];
const MEASURES: [&str; 7] =
    ["nees", "nees_of_bound", "strain_error", "offset_error_rad", "tool_distance_m", "tool_angle_rad", "noise_factor"];

fn counts(row: &CampaignRow) -> [u64; 9] {
    let [a, b, c, d] = row.inside;
    [row.trial, row.seed, row.contacts, row.status, row.parameters, a, b, c, d]
}

fn measures(row: &CampaignRow) -> [f64; 7] {
    [
        row.nees,
        row.nees_of_bound,
        row.strain_error,
        row.offset_error,
        row.tool_distance,
        row.tool_angle,
        row.noise_factor,
    ]
}

fn row(counts: [u64; 9], measures: [f64; 7]) -> CampaignRow {
    let [trial, seed, contacts, status, parameters, inside @ ..] = counts;
    let [nees, nees_of_bound, strain_error, offset_error, tool_distance, tool_angle, noise_factor] = measures;
    CampaignRow {
        trial,
        seed,
        contacts,
        status,
        parameters,
        inside,
        nees,
        nees_of_bound,
        strain_error,
        offset_error,
        tool_distance,
        tool_angle,
        noise_factor,
    }
}

/// The bytes of a part; `settings` is what its rows depend on.
///
/// # Errors
/// If the parquet crate cannot write them.
pub fn to_bytes(rows: &[CampaignRow], settings: &str) -> Result<Vec<u8>, IoError> {
    let failed = |error: ParquetError| IoError::syntax(Place::file("campaign"), error.to_string());
    write(rows, settings).map_err(failed)
}

fn write(rows: &[CampaignRow], settings: &str) -> Result<Vec<u8>, ParquetError> {
    let counted = COUNTS.map(|name| format!("required int64 {name};")).concat();
    let measured = MEASURES.map(|name| format!("required double {name};")).concat();
    let schema = Arc::new(parse_message_type(&format!("message trial {{ {counted} {measured} }}"))?);
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![KeyValue::new(KEY.to_owned(), settings.to_owned())]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut index = 0usize;
    while let Some(mut column) = group.next_column()? {
        match index.checked_sub(COUNTS.len()) {
            None => {
                // A seed keeps its bits.
                let values: Vec<i64> = rows.iter().map(|row| counts(row)[index].cast_signed()).collect();
                column.typed::<Int64Type>().write_batch(&values, None, None)?;
            }
            Some(k) => {
                let values: Vec<f64> = rows.iter().map(|row| measures(row)[k]).collect();
                column.typed::<DoubleType>().write_batch(&values, None, None)?;
            }
        }
        column.close()?;
        index += 1;
    }
    group.close()?;
    writer.into_inner()
}

/// The rows of a part and what they depend on.
///
/// # Errors
/// If the file cannot be read or is no part of a campaign.
pub fn read_file(path: &Path) -> Result<(Vec<CampaignRow>, String), IoError> {
    let content = bytes::open(path)?;
    let name = path.display().to_string();
    let size = content.metadata().map_err(|source| IoError::file(path, "read", source))?.len();
    bytes::check_size(size, MAX_BYTES, &name)?;
    let unfit = |found: String| IoError::unexpected(Place::file(name), "a part of a campaign", found);
    // The parquet crate panics on some damage, see `pose_parquet`.
    catch_unwind(AssertUnwindSafe(|| read(content)))
        .unwrap_or_else(|_| Err(ParquetError::General("damaged data".to_owned())))
        .map_err(|error| unfit(error.to_string()))
}

fn read(content: File) -> Result<(Vec<CampaignRow>, String), ParquetError> {
    let missing = |what: &str| ParquetError::General(what.to_owned());
    let reader = SerializedFileReader::new(content)?;
    let metadata = reader.metadata().file_metadata();
    let entries = metadata.key_value_metadata().map_or(&[][..], Vec::as_slice);
    let settings = entries.iter().find(|entry| entry.key == KEY).and_then(|entry| entry.value.clone());
    let settings = settings.ok_or_else(|| missing("no settings"))?;
    let names: Vec<&str> = metadata.schema_descr().columns().iter().map(|column| column.name()).collect();
    if names != [&COUNTS[..], &MEASURES[..]].concat() {
        return Err(missing("other columns"));
    }
    let mut rows = Vec::new();
    for each in reader.get_row_iter(None)? {
        let each = each?;
        let (mut counts, mut measures) = ([0; 9], [0.0; 7]);
        for (k, count) in counts.iter_mut().enumerate() {
            *count = each.get_long(k)?.cast_unsigned();
        }
        for (k, measure) in measures.iter_mut().enumerate() {
            *measure = each.get_double(COUNTS.len() + k)?;
        }
        rows.push(row(counts, measures));
    }
    Ok((rows, settings))
}
