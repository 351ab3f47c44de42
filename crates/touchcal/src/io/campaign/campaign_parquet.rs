//! Rows of a campaign as Parquet: columns named as the fields of [`CampaignRow`] (angles with
//! `_rad`, lengths with `_m`), counts INT64, measures DOUBLE; in the file's metadata what the rows
//! depend on (`touchcal`), the number of trials of the campaign (`trials`) and the computing time
//! (`core_seconds`).

use std::fs::File;
use std::io::Write;
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

use crate::experiment::CampaignRow;
use crate::io::base::atomic;
use crate::io::base::bounded_pages::BoundedPages;
use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place};

/// Keys of what is said of the rows: settings, trials of the campaign, seconds.
const KEYS: [&str; 3] = ["touchcal", "trials", "core_seconds"];
/// Rows of a group, where many parts are written.
const GROUP: usize = 1 << 16;
/// Largest part read (bytes).
const MAX_BYTES: u64 = 256 << 20;

/// A column's name, and the field that it holds.
type Field<T> = (&'static str, fn(&mut CampaignRow) -> &mut T);

const COUNTS: [Field<u64>; 9] = [
    ("trial", |row| &mut row.trial),
    ("seed", |row| &mut row.seed),
    ("contacts", |row| &mut row.contacts),
    ("status", |row| &mut row.status),
    ("parameters", |row| &mut row.parameters),
    ("inside_50", |row| &mut row.inside[0]),
    ("inside_90", |row| &mut row.inside[1]),
    ("inside_95", |row| &mut row.inside[2]),
    ("inside_99", |row| &mut row.inside[3]),
];
const MEASURES: [Field<f64>; 9] = [
    ("nees", |row| &mut row.nees),
    ("nees_of_bound", |row| &mut row.nees_of_bound),
    ("strain_error", |row| &mut row.strain_error),
    ("offset_error_rad", |row| &mut row.offset_error),
    ("strain_bound", |row| &mut row.strain_bound),
    ("offset_bound_rad", |row| &mut row.offset_bound),
    ("tool_distance_m", |row| &mut row.tool_distance),
    ("tool_angle_rad", |row| &mut row.tool_angle),
    ("noise_factor", |row| &mut row.noise_factor),
];

fn counts(row: &CampaignRow) -> [u64; 9] {
    let mut row = *row;
    COUNTS.map(|(_, field)| *field(&mut row))
}

fn measures(row: &CampaignRow) -> [f64; 9] {
    let mut row = *row;
    MEASURES.map(|(_, field)| *field(&mut row))
}

/// Whether two rows are equal bit by bit, also where they are NaN.
pub fn identical(one: &CampaignRow, other: &CampaignRow) -> bool {
    counts(one) == counts(other) && measures(one).map(f64::to_bits) == measures(other).map(f64::to_bits)
}

/// Rows of a part of a campaign, and the settings they were computed with.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// All that the rows depend on, as text: version, first seed and scenario.
    pub settings: String,
    /// Number of trials of the whole campaign, not of this part.
    pub trials: u64,
    /// Computing time of the rows (s, on one core).
    pub core_seconds: f64,
    /// One row per trial, in the order of trials.
    pub rows: Vec<CampaignRow>,
}

/// The Parquet file of a part, as bytes.
///
/// # Errors
/// [`IoError::Syntax`] if the parquet crate cannot write them.
pub fn to_bytes(part: &Part) -> Result<Vec<u8>, IoError> {
    let mut writer = writer(Vec::new(), part).map_err(unwritten)?;
    add(&mut writer, &part.rows).map_err(unwritten)?;
    writer.into_inner().map_err(unwritten)
}

/// Writes the rows of many parts, in their order, to one Parquet file with the settings, number of
/// trials and computing time of `about`, whose own rows are ignored; only some are in memory at a
/// time.
///
/// # Errors
/// [`IoError`] if a part cannot be read (its own error), or the file not written; `path` is then as
/// it was.
pub fn write_file(
    path: &Path,
    about: &Part,
    parts: impl Iterator<Item = Result<Vec<CampaignRow>, IoError>>,
) -> Result<(), IoError> {
    atomic::write_by(path, |file| {
        let mut writer = writer(file, about).map_err(unwritten)?;
        let mut rows = Vec::new();
        for part in parts {
            rows.extend(part?);
            if rows.len() >= GROUP {
                add(&mut writer, &rows).map_err(unwritten)?;
                rows.clear();
            }
        }
        add(&mut writer, &rows).map_err(unwritten)?;
        writer.close().map_err(unwritten)?;
        Ok(())
    })
}

fn unwritten(error: ParquetError) -> IoError {
    IoError::syntax(Place::file("campaign"), error.to_string())
}

fn writer<W: Write + Send>(into: W, about: &Part) -> Result<SerializedFileWriter<W>, ParquetError> {
    let counted = COUNTS.map(|(name, _)| format!("required int64 {name};")).concat();
    let measured = MEASURES.map(|(name, _)| format!("required double {name};")).concat();
    let schema = Arc::new(parse_message_type(&format!("message trial {{ {counted} {measured} }}"))?);
    let said = [about.settings.clone(), about.trials.to_string(), about.core_seconds.to_string()];
    let entries = KEYS.into_iter().zip(said).map(|(key, value)| KeyValue::new(key.to_owned(), value));
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(entries.collect()))
        .build();
    SerializedFileWriter::new(into, schema, Arc::new(properties))
}

/// Writes rows as a group of their own.
fn add<W: Write + Send>(writer: &mut SerializedFileWriter<W>, rows: &[CampaignRow]) -> Result<(), ParquetError> {
    if rows.is_empty() {
        return Ok(());
    }
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
    Ok(())
}

/// Reads a part from its Parquet file.
///
/// # Errors
/// [`IoError`] if the file cannot be read, is larger than 256 MiB, is damaged, or is no part of a
/// campaign: its columns or metadata are others.
pub fn read_file(path: &Path) -> Result<Part, IoError> {
    read_open(bytes::open(path)?, path)
}

/// The part in an open file, which messages call `path`.
pub(crate) fn read_open(content: File, path: &Path) -> Result<Part, IoError> {
    let name = path.display().to_string();
    let size = content.metadata().map_err(|source| IoError::file(path, "read", source))?.len();
    bytes::check_size(size, MAX_BYTES, &name)?;
    let unfit = |found: String| IoError::unexpected(Place::file(name), "a part of a campaign", found);
    // The parquet crate panics on some damage, see `number_columns`.
    catch_unwind(AssertUnwindSafe(|| read(content)))
        .unwrap_or_else(|_| Err(ParquetError::General("damaged data".to_owned())))
        .map_err(|error| unfit(error.to_string()))
}

fn read(content: File) -> Result<Part, ParquetError> {
    let missing = |what: &str| ParquetError::General(what.to_owned());
    let reader = SerializedFileReader::new(BoundedPages(content))?;
    let metadata = reader.metadata().file_metadata();
    let entries = metadata.key_value_metadata().map_or(&[][..], Vec::as_slice);
    let said = KEYS.map(|key| entries.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.as_deref()));
    let [Some(settings), Some(trials), Some(core_seconds)] = said else { return Err(missing("no settings")) };
    let trials = trials.parse().map_err(|_| missing("no number of trials"))?;
    let core_seconds = core_seconds.parse().map_err(|_| missing("no seconds"))?;
    let names: Vec<&str> = metadata.schema_descr().columns().iter().map(|column| column.name()).collect();
    if names != [COUNTS.map(|(name, _)| name), MEASURES.map(|(name, _)| name)].concat() {
        return Err(missing("other columns"));
    }
    let mut rows = Vec::new();
    for each in reader.get_row_iter(None)? {
        let each = each?;
        let mut row = CampaignRow::default();
        for (k, (_, field)) in COUNTS.iter().enumerate() {
            *field(&mut row) = each.get_long(k)?.cast_unsigned();
        }
        for (k, (_, field)) in MEASURES.iter().enumerate() {
            *field(&mut row) = each.get_double(COUNTS.len() + k)?;
        }
        rows.push(row);
    }
    Ok(Part { settings: settings.to_owned(), trials, core_seconds, rows })
}
