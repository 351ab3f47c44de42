//! Poses from Parquet files: as from CSV, and damage refused.

use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, GzipLevel};
use parquet::data_type::{DoubleType, FloatType};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use proptest::prelude::*;
use touchcal::io::pose_file;
use touchcal::manifold::PoseSamples;

/// Row `i`: a place on a line, no turn.
const ROWS: usize = 500;

fn number(row: usize, column: &str) -> f64 {
    match column {
        "x" => 1e-3 * row as f64,
        "qw" => 1.0,
        _ => 0.0,
    }
}

/// A file of two row groups with these columns, of which those named `f…` are floats without that
/// letter, those `?…` may be empty.
fn file(columns: &[&str], compression: Compression, change: impl Fn(usize, &str, f64) -> f64) -> Vec<u8> {
    let field = |name: &&str| match name.split_at(1) {
        ("f", rest) => format!("required float {rest};"),
        ("?", rest) => format!("optional double {rest};"),
        _ => format!("required double {name};"),
    };
    let schema = format!("message poses {{ {} }}", columns.iter().map(field).collect::<String>());
    let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties).unwrap();
    for group in 0..2 {
        let mut group_writer = writer.next_row_group().unwrap();
        for name in columns {
            let bare = name.trim_start_matches(['f', '?']);
            let rows = group * ROWS / 2..(group + 1) * ROWS / 2;
            let values: Vec<f64> = rows.map(|row| change(row, bare, number(row, bare))).collect();
            let mut column = group_writer.next_column().unwrap().unwrap();
            if name.starts_with('f') {
                let values: Vec<f32> = values.iter().map(|value| *value as f32).collect();
                column.typed::<FloatType>().write_batch(&values, None, None).unwrap();
            } else if name.starts_with('?') {
                let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_finite())).collect();
                let values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
                column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
            } else {
                column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
            }
            column.close().unwrap();
        }
        group_writer.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

fn read(folder: &Path, bytes: &[u8]) -> Result<PoseSamples, String> {
    let path = folder.join("p.parquet");
    std::fs::write(&path, bytes).unwrap();
    let (samples, input) = pose_file::read_file(&path).map_err(|error| error.to_string())?;
    assert_eq!(input.sha256.len(), 64);
    assert_ne!(input.sha256, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855", "of nothing");
    Ok(samples)
}

const NAMES: [&str; 8] = ["gap", "qz", "qy", "?x", "qx", "y", "fz", "qw"];

#[test]
fn columns_are_found_whatever_their_order_type_and_compression() {
    let folder = tempfile::tempdir().unwrap();
    for compression in [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::GZIP(GzipLevel::default())] {
        let samples = read(folder.path(), &file(&NAMES, compression, |_, _, value| value)).unwrap();
        let expected: Vec<[f64; 6]> = (0..ROWS).map(|row| [number(row, "x"), 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
        assert_eq!(samples.coordinates(), expected);
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |bytes: &[u8], part: &str| {
        let message = read(folder.path(), bytes).unwrap_err();
        assert!(message.contains("p.parquet") && message.contains(part), "expected `{part}` in: {message}");
    };
    let changed = |row: usize, column: &'static str, to: f64| {
        let change = move |at: usize, name: &str, value| if at == row && name == column { to } else { value };
        file(&NAMES, Compression::UNCOMPRESSED, change)
    };
    refused(&changed(300, "y", f64::NAN), "row 301: expected finite numbers, found NaN in column y");
    refused(&changed(3, "x", f64::NAN), "column x: expected numbers, one in each row, found an empty");
    refused(&changed(3, "y", 25.0), "column y: expected metres within ±10, found 25: in millimetres?");
    refused(&changed(499, "qw", 2.0), "row 500: expected a quaternion qw,qx,qy,qz of norm 1, found norm 2");
    refused(&file(&NAMES[1..7], Compression::SNAPPY, |_, _, value| value), "`qw` is missing");
    let whole = changed(0, "none", 0.0);
    for end in [4, 12, whole.len() / 2, whole.len() - 1] {
        refused(&whole[..end], "a whole Parquet file");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn damaged_files_are_answered(at in any::<prop::sample::Index>(), with in any::<u8>(), near_end in any::<bool>()) {
        let folder = tempfile::tempdir().unwrap();
        let mut bytes = file(&NAMES, Compression::SNAPPY, |_, _, value| value);
        let size = bytes.len();
        // The footer, where lengths and places are, is at the end.
        let at = if near_end { size - 1 - at.index(size.min(1500)) } else { at.index(size) };
        bytes[at] = with;
        let _ = read(folder.path(), &bytes);
    }
}

/// More rows than a group has come back as they were, bit by bit, from a file that parts were
/// written to one after the other.
#[test]
fn rows_of_many_parts_make_one_file() {
    use touchcal::experiment::CampaignRow;
    use touchcal::io::campaign_parquet::{self, Part};
    let row = |trial: u64| CampaignRow {
        trial,
        seed: u64::MAX - trial,
        inside: [1, 2, 3, 4],
        nees: (trial as f64).sqrt(),
        tool_angle: if trial == 7 { f64::NAN } else { -0.0 },
        ..CampaignRow::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.parquet");
    let about = Part { settings: "of these".to_owned(), trials: 70_000, core_seconds: 0.1, rows: Vec::new() };
    let parts = (0..1400u64).map(|part| Ok((50 * part..50 * (part + 1)).map(row).collect()));
    campaign_parquet::write_file(&path, &about, parts).unwrap();
    let read = campaign_parquet::read_file(&path).unwrap();
    assert_eq!((read.settings.as_str(), read.trials, read.core_seconds), ("of these", 70_000, 0.1));
    assert_eq!(read.rows.len(), 70_000);
    assert!(read.rows.iter().zip(0..).all(|(read, trial)| campaign_parquet::identical(read, &row(trial))));
    assert!(!campaign_parquet::identical(&row(1), &row(2)) && campaign_parquet::identical(&row(7), &row(7)));

    // A part that cannot be read leaves no file.
    let gone = campaign_parquet::read_file(&folder.path().join("none")).map(|part| part.rows);
    let other = folder.path().join("other.parquet");
    assert!(campaign_parquet::write_file(&other, &about, [Ok(vec![row(0)]), gone].into_iter()).is_err());
    assert!(!other.exists());
}

/// Only what is whole and of the campaign gets the name of its part, and what has it stays.
#[test]
fn parts_are_kept_whole_or_not_at_all() {
    use touchcal::experiment::CampaignRow;
    use touchcal::io::campaign_folder::CampaignFolder;
    use touchcal::io::campaign_parquet::{read_file, to_bytes};
    use touchcal::io::scenario_file::{preset, scenario_text};

    let folder = tempfile::tempdir().unwrap();
    let files = scenario_text(&preset("mukca").unwrap());
    let campaign = |name: &str, seed| CampaignFolder::new(&files, folder.path().join(name), 70, seed).unwrap();
    let (one, other) = (campaign("one", 1), campaign("other", 2));
    let rows =
        |trials: std::ops::Range<u64>| trials.map(|trial| CampaignRow { trial, ..CampaignRow::default() }).collect();
    let bytes = |rows| to_bytes(&one.part(rows, 2.0)).unwrap();
    assert_eq!((one.count(), one.range(1)), (2, 50..70));

    let good = bytes(rows(50..70));
    one.keep(1, &good).unwrap();
    let bad = [
        (&one, 0, good.clone()),
        (&other, 1, good.clone()),
        (&one, 1, bytes(rows(50..69))),
        (&one, 1, good[..80].to_vec()),
    ];
    for (campaign, part, bytes) in bad {
        let said = campaign.keep(part, &bytes).unwrap_err().to_string();
        assert!(said.contains(&format!("part-00000{part}.parquet: expected a part of ")), "{said}");
    }
    assert_eq!(one.kept(1).map(|part| part.rows), Some(rows(50..70)));
    assert!(one.kept(0).is_none() && other.kept(1).is_none());

    let path = folder.path().join("rows.parquet");
    let said = one.write_rows(&path).unwrap_err().to_string();
    assert!(said.contains("part-000000.parquet: expected a part of this campaign, found none") && !path.exists());
    assert_eq!(one.check().unwrap_err().to_string(), said);
    one.keep(0, &bytes(rows(0..50))).unwrap();
    one.check().unwrap();
    one.write_rows(&path).unwrap();
    let written = read_file(&path).unwrap();
    assert_eq!((written.rows, written.core_seconds), (rows(0..70), 4.0));

    // Another run with another seed, in the same folder.
    let other = campaign("one", 2);
    other.keep(0, &to_bytes(&other.part(rows(0..50), 2.0)).unwrap()).unwrap();
    let said = one.check().unwrap_err().to_string();
    assert!(said.contains("part-000000.parquet") && said.contains("another run with other settings"), "{said}");
}
