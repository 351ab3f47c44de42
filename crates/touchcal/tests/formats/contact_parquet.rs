//! Contact logs as Parquet: the same contacts as from CSV, and damage refused.

use std::path::Path;
use std::sync::Arc;

use crate::support::small_arm::arm;
use parquet::basic::Compression;
use parquet::data_type::{BoolType, DoubleType, FloatType, Int32Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use proptest::prelude::*;
use touchcal::contact::{AngleUnit, ContactLog, Detection, KnownRows};
use touchcal::io::contact_log::{self, Options};

/// A value of a table, which says its column's type.
#[derive(Clone, Copy)]
enum Cell {
    Double(f64),
    Float(f32),
    Int(i32),
    Bool(bool),
}

/// A file of groups of `rows_per_group` rows.
fn file(columns: &[(&str, Vec<Cell>)], rows_per_group: usize) -> Vec<u8> {
    let field = |(name, cells): &(&str, Vec<Cell>)| match cells[0] {
        Cell::Double(_) => format!("required double {name};"),
        Cell::Float(_) => format!("required float {name};"),
        Cell::Int(_) => format!("required int32 {name};"),
        Cell::Bool(_) => format!("required boolean {name};"),
    };
    let schema = format!("message log {{ {} }}", columns.iter().map(field).collect::<String>());
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut bytes = Vec::new();
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
    let rows = columns[0].1.len();
    for start in (0..rows).step_by(rows_per_group) {
        let mut group = writer.next_row_group().unwrap();
        for (_, cells) in columns {
            let cells = &cells[start..(start + rows_per_group).min(rows)];
            let mut column = group.next_column().unwrap().unwrap();
            macro_rules! write {
                ($cell:ident, $type:ty) => {{
                    let values = cells.iter().map(|cell| if let Cell::$cell(v) = cell { *v } else { panic!("mixed") });
                    column.typed::<$type>().write_batch(&values.collect::<Vec<_>>(), None, None).unwrap();
                }};
            }
            match cells[0] {
                Cell::Double(_) => write!(Double, DoubleType),
                Cell::Float(_) => write!(Float, FloatType),
                Cell::Int(_) => write!(Int, Int32Type),
                Cell::Bool(_) => write!(Bool, BoolType),
            }
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

fn read(folder: &Path, bytes: &[u8], options: &Options) -> Result<ContactLog, String> {
    let path = folder.join("c.parquet");
    std::fs::write(&path, bytes).unwrap();
    let mut log = ContactLog::new(2);
    let input = contact_log::read_file(&path, &arm(), options, &mut log).map_err(|error| error.to_string())?;
    let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
    assert!(input.sha256.len() == 64 && input.sha256 != empty);
    Ok(log)
}

fn doubles(values: impl IntoIterator<Item = f64>) -> Vec<Cell> {
    values.into_iter().map(Cell::Double).collect()
}

/// 20,000 rows, more than are read at a time, in groups that end in between.
fn long() -> Vec<(&'static str, Vec<Cell>)> {
    let rows = 0..20_000;
    vec![
        ("time", rows.clone().map(Cell::Int).collect()),
        ("SL", rows.clone().map(|i| Cell::Float((i % 7) as f32 / 8.0)).collect()),
        ("q1", doubles(rows.clone().map(|i| f64::from(i) * 1e-4 - 1.0))),
        ("fx", doubles(rows.clone().map(|i| f64::from(i % 10)))),
        ("fy", doubles(rows.clone().map(|_| 0.0))),
        ("fz", doubles(rows.clone().map(|_| 0.0))),
        ("contact", rows.map(|i| Cell::Bool(i % 3 == 0)).collect()),
    ]
}

#[test]
fn contacts_are_those_of_the_same_table_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    let mut csv = "time,SL,q1,fx,fy,fz,contact\n".to_owned();
    for i in 0..20_000 {
        let (q1, sl) = (f64::from(i) * 1e-4 - 1.0, f64::from(i % 7) / 8.0);
        csv += &format!("{i},{sl},{q1},{},0,0,{}\n", i % 10, u8::from(i % 3 == 0));
    }
    let path = folder.path().join("c.csv");
    std::fs::write(&path, csv).unwrap();
    let force = Some(Detection { threshold: 5.0, release: 3.0, debounce: 2 });
    for detection in [None, force] {
        let options = Options { detection, fixture: 4, ..Options::default() };
        let mut expected = ContactLog::new(2);
        contact_log::read_file(&path, &arm(), &options, &mut expected).unwrap();
        for rows_per_group in [20_000, 8192, 999] {
            let log = read(folder.path(), &file(&long(), rows_per_group), &options).unwrap();
            assert_eq!((log.len(), log.rows_read()), (expected.len(), 20_000));
            for i in 0..log.len() {
                // A CSV has a line for its header.
                assert_eq!(log.source(i).line + 1, expected.source(i).line);
                assert_eq!((log.q(i), log.fixture(i)), (expected.q(i), 4));
            }
        }
    }
}

/// Of a row only the columns that are used are read: rows of one file that are equal in these stay,
/// those of a copy do not.
#[test]
fn a_copied_file_counts_once() {
    let bytes = file(&[("q1", doubles([0.1, 0.1, 0.2])), ("q2", doubles([0.3; 3]))], 2);
    let changed = file(&[("q1", doubles([0.1, 0.1, 0.2])), ("q2", doubles([0.3, 0.3, 0.4]))], 2);
    let folder = tempfile::tempdir().unwrap();
    let (mut log, mut known) = (ContactLog::new(2), KnownRows::default());
    for (bytes, contacts) in [(&bytes, 3), (&bytes, 3), (&changed, 4)] {
        let path = folder.path().join("log");
        std::fs::write(&path, bytes).unwrap();
        contact_log::read_new(&path, &arm(), &Options::default(), (&mut log, &mut known)).unwrap();
        assert_eq!(log.len(), contacts);
    }
}

#[test]
fn units_order_and_names_are_applied() {
    let folder = tempfile::tempdir().unwrap();
    let table = [("axis", doubles([90.0, -45.0])), ("rail", doubles([0.1, 0.2]))];
    let columns = [("q1", "rail"), ("q2", "axis")].map(|(a, b)| (a.to_owned(), b.to_owned())).into();
    let joints = Some(vec!["sl".to_owned(), "sh".to_owned()]);
    let options = Options { columns, joints, unit: AngleUnit::Degree, ..Options::default() };
    let log = read(folder.path(), &file(&table, 9), &options).unwrap();
    let turn = std::f64::consts::FRAC_PI_2;
    assert_eq!([log.q(0), log.q(1)], [[turn, 0.1], [-turn / 2.0, 0.2]]);
}

#[test]
fn bad_content_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |table: &[(&str, Vec<Cell>)], options: &Options, part: &str| {
        let message = read(folder.path(), &file(table, 9), options).unwrap_err();
        assert!(message.contains("c.parquet") && message.contains(part), "expected `{part}` in: {message}");
    };
    let plain = Options::default();
    let joints = |q1: [f64; 2]| vec![("q1", doubles(q1)), ("q2", doubles([0.0, 0.0]))];
    refused(&joints([0.0, f64::NAN]), &plain, "row 2, column q1: expected a number in radians, found NaN");
    refused(&joints([0.0, 1e9]), &plain, "row 2, column q1: expected a joint position");
    refused(&joints([0.0, 45.0]), &plain, "row 2, joint `sh`: expected radians within the joint limits");
    refused(
        &joints([0.0, 45.0])[..1],
        &plain,
        "a column for every joint: `sl` or `q2`, or its name in `columns`, found columns \"q1\"",
    );
    let force = Options { detection: Some(Detection { threshold: 1.0, release: 1.0, debounce: 1 }), ..plain.clone() };
    refused(&joints([0.0, 0.0]), &force, "columns fx, fy and fz");
    let flags = [joints([0.0, 0.0]), vec![("contact", vec![Cell::Int(1), Cell::Int(2)])]].concat();
    refused(&flags, &plain, "row 2, column contact: expected 0, 1, true or false, found 2");
    let whole = file(&long(), 999);
    for end in [4, 12, whole.len() / 2, whole.len() - 1] {
        assert!(read(folder.path(), &whole[..end], &plain).unwrap_err().contains("a whole Parquet file"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn damaged_files_are_answered(at in any::<prop::sample::Index>(), with in any::<u8>(), near_end in any::<bool>()) {
        let folder = tempfile::tempdir().unwrap();
        let table: Vec<_> = long().into_iter().map(|(name, cells)| (name, cells[..50].to_vec())).collect();
        let mut bytes = file(&table, 20);
        let size = bytes.len();
        // The footer, where lengths and places are, is at the end.
        let at = if near_end { size - 1 - at.index(size.min(1500)) } else { at.index(size) };
        bytes[at] = with;
        let _ = read(folder.path(), &bytes, &Options::default());
    }
}
