//! Contact logs: columns found, contacts chosen, bad input refused.

use crate::support::{gzip, refused};
use std::io::Read;

use crate::support::small_arm::{ARM, arm};
use proptest::prelude::*;
use touchcal::contact::{AngleUnit, ContactLog, Detection, KnownRows, Load, LoadFrame, LoadOn, RowsLeftOut};
use touchcal::io::contact_csv;
use touchcal::io::contact_log::{self, Columns, Options};
use touchcal::io::urdf::{self, Ends};

fn read_with(content: impl Read, options: &Options) -> Result<ContactLog, String> {
    let mut log = ContactLog::new(2);
    contact_csv::read(content, "c.csv", &arm(), options, &mut log).map_err(|error| error.to_string())?;
    Ok(log)
}

fn read(text: &str) -> Result<ContactLog, String> {
    read_with(text.as_bytes(), &Options::default())
}

fn q(log: &ContactLog) -> Vec<[f64; 2]> {
    (0..log.len()).map(|i| [log.q(i)[0], log.q(i)[1]]).collect()
}

fn lines(log: &ContactLog) -> Vec<u64> {
    (0..log.len()).map(|i| log.source(i).line).collect()
}

fn force(threshold: f64) -> Options {
    Options { detection: Some(Detection { threshold, release: threshold, debounce: 1 }), ..Options::default() }
}

#[test]
fn a_load_needs_a_whole_wrench() {
    let load = Options { load: Some(Load { on: LoadOn::Tool, frame: LoadFrame::Tip, lag: 0.0 }), ..Options::default() };
    let whole = "q1,q2,fx,fy,fz,tx,ty,tz\n0.1,0.2,1,2,3,4,5,6\n";
    assert_eq!(read_with(whole.as_bytes(), &load).unwrap().load(0), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let rests = "q1,q2,fx,fy,fz,tx,ty,tz\n0.1,0.2,1,0,0,0,0,0\n0.1,0.2,2,0,0,0,0,0\n0.3,0.2,3,0,0,0,0,0\n";
    let log = read_with(rests.as_bytes(), &Options { apart: Some(0.1), ..load.clone() }).unwrap();
    assert_eq!((log.len(), log.load(0)[0], log.load(1)[0]), (2, 1.0, 3.0));
    let force = "q1,q2,fx,fy,fz\n0.1,0.2,1,2,3\n";
    refused(read_with(force.as_bytes(), &load), &["c.csv", "fx, fy, fz, tx, ty and tz", "load", "q1,q2,fx,fy,fz"]);
    refused(read_with("0.1,0.2\n".as_bytes(), &load), &["c.csv", "load", "no header"]);
}

#[test]
fn columns_are_found_by_name_or_order() {
    let expected = [[0.1, 0.2], [0.3, 0.4]];
    for text in [
        "0.1,0.2\n0.3,0.4\n",
        "q1,q2\n0.1,0.2\n0.3,0.4",
        "\u{feff} Q2 ,time, q1\r\n0.2,x,0.1\r\n\r\n0.4,,0.3\r\n",
        "sl,sh\n0.2,0.1\n0.4,0.3\n",
        "\"t, s\",\"SH\",\"q2\"\n\"9,9\",\"0.1\",0.2\n1,0.3,0.4\n",
        "q1,q2,sh,sl\n7,7,0.1,0.2\n7,7,0.3,0.4\n",
    ] {
        let log = read(text).unwrap();
        assert_eq!(q(&log), expected, "{text}");
        assert_eq!((log.rows_read(), log.files()), (2, &["c.csv".to_owned()][..]));
    }
    assert_eq!(lines(&read("q1,q2\r\n\r\n0.1,0.2\r\n0.3,0.4\r\n").unwrap()), [3, 4]);
}

#[test]
fn order_renames_and_units_are_applied() {
    let joints = Some(vec!["sl".to_owned(), "sh".to_owned()]);
    let swapped = Options { joints, ..Options::default() };
    assert_eq!(q(&read_with(&b"0.2,0.1\n"[..], &swapped).unwrap()), [[0.1, 0.2]]);
    assert_eq!(q(&read_with(&b"q1,q2\n0.2,0.1\n"[..], &swapped).unwrap()), [[0.1, 0.2]]);
    let columns = [("q1", "Axis 1"), ("sl", "rail")].map(|(a, b)| (a.to_owned(), b.to_owned())).into();
    let renamed = Options { columns, unit: AngleUnit::Degree, ..Options::default() };
    let log = read_with(&b"rail,axis 1\n0.2,90\n"[..], &renamed).unwrap();
    assert_eq!(q(&log), [[std::f64::consts::FRAC_PI_2, 0.2]]);
    refused(read_with(&b"q1,rail\n0,0\n"[..], &renamed), &["c.csv:1", "column `Axis 1`, which holds `q1`"]);
    let wrong = Options { columns: [("q9".to_owned(), "a".to_owned())].into(), ..Options::default() };
    refused(read_with(&b"q1,q2\n0,0\n"[..], &wrong), &["c.csv, columns", "`q9`; did you mean"]);
    let wrong = Options { joints: Some(vec!["sh".to_owned(), "sm".to_owned()]), ..Options::default() };
    refused(read_with(&b"q1,q2\n0,0\n"[..], &wrong), &["joints", "`sm`; did you mean `sh`?"]);
    let wrong = Options { joints: Some(vec!["sh".to_owned()]), ..Options::default() };
    refused(read_with(&b"q1,q2\n0,0\n"[..], &wrong), &["all 2 moving joints", "found 1"]);
}

#[test]
fn an_arm_at_rest_is_one_contact_if_contacts_are_to_be_apart() {
    // At rest, moving slowly, back, and at rest elsewhere; the encoder's last digit flickers.
    let moments = [0.5, 0.50001, 0.5, 0.50001, 0.51, 0.52, 0.5, 0.9, 0.90001, 0.9, 0.90001, 0.9];
    let rows = moments.iter().enumerate().map(|(k, q)| format!("{k},{q},0.1\n"));
    let text = format!("t,q1,q2\n{}", rows.collect::<String>());
    let thinned = Options { apart: Some(0.015), ..Options::default() };
    let mut log = read("t,q1,q2\n0,0.5,0.1\n1,0.5,0.1\n").unwrap();
    contact_csv::read(text.as_bytes(), "c.csv", &arm(), &thinned, &mut log).unwrap();
    // Contacts of the file before are not counted on, and stay.
    assert_eq!(q(&log), [[0.5, 0.1], [0.5, 0.1], [0.5, 0.1], [0.52, 0.1], [0.5, 0.1], [0.9, 0.1]]);
    assert_eq!((lines(&log), log.rows_read()), (vec![2, 3, 2, 7, 8, 9], 14));
    assert_eq!(log.rows_left_out(), RowsLeftOut { at_rest: 8, ..RowsLeftOut::default() });
    assert!(log.notes().is_empty(), "{:?}", log.notes());

    let all = read(&text).unwrap();
    assert_eq!((all.len(), all.notes().len()), (12, 1));
    assert!(all.notes()[0].contains("c.csv: in 7 of 12 contacts no joint has moved by 0.01 deg"), "{:?}", all.notes());
    let slide = "q1,q2\n0,0.1\n0,0.11\n0,0.12\n";
    assert_eq!(lines(&read_with(slide.as_bytes(), &thinned).unwrap()), [2, 4]);
}

#[test]
fn rows_that_are_equal_in_all_columns_are_one_contact() {
    let text = "t,q1,q2,fx,fy,fz,tx,ty,tz\n0,0.5,0.1,9,0,0,0,0,0\n1,0.5,0.1,9,0,0,0,0,0\n1,0.5,0.1,8,0,0,0,0,0\n1,0.5,0.1,9,0,0,0,0,0\n";
    let note =
        |repeated: usize, all: usize| format!("c.csv: {repeated} of {all} contacts are rows that were read before");
    let options = Options { fixture: 1, ..force(1.0) };
    let log = read_with(text.as_bytes(), &options).unwrap();
    assert_eq!((lines(&log), log.rows_read()), (vec![2, 3, 4], 4));
    assert!(log.notes()[0].starts_with(&note(1, 4)), "{:?}", log.notes());
    // Once more, as contacts with another fixture, with a row that is new.
    let (folder, mut log, mut known) = (tempfile::tempdir().unwrap(), ContactLog::new(2), KnownRows::default());
    let paths = ["a.csv", "b.csv"].map(|name| folder.path().join(name));
    std::fs::write(&paths[0], text).unwrap();
    std::fs::write(&paths[1], format!("{text}2,0.5,0.1,9,0,0,0,0,0\n")).unwrap();
    for (fixture, path) in paths.iter().enumerate() {
        let options = Options { fixture, ..force(1.0) };
        contact_log::read_new(path, &arm(), &options, (&mut log, &mut known)).unwrap();
    }
    assert_eq!((lines(&log), log.fixture(3), log.rows_read()), (vec![2, 3, 4, 6], 1, 9));
    assert_eq!(log.rows_left_out(), RowsLeftOut { repeated: 5, ..RowsLeftOut::default() });
    assert!(log.notes()[2].contains("b.csv: 4 of 5 contacts are rows that were read before"), "{:?}", log.notes());
}

const RECORDER: &str = "%  ZeitInSec ZeitInNanoSec axisQMsr_LBR_1[0] axisQMsr_LBR_1[1] axisQCmd_LBR_1[0] cartForce1_X cartForce1_Y cartForce1_Z \
    cartForceVar1_X cartTorque1_TauX\n";

#[test]
fn a_log_of_kukas_recorder_is_read_as_it_is() {
    let rows = " 7 1000 -90.0  0.1 5 3 4 0 9 1\n 7\t2000\t45.0\t0.2\t5\t0\t0\t1\t9\t1\n";
    let log = read(&(RECORDER.to_owned() + rows)).unwrap();
    let turn = std::f64::consts::FRAC_PI_2;
    assert_eq!(q(&log), [[-turn, 0.1], [turn / 2.0, 0.2]]);
    assert!(log.notes()[1].contains("there are forces, but no threshold: every row counts"), "{:?}", log.notes());
    assert!(log.notes()[0].starts_with("c.csv: ") && log.notes()[0].contains("DEGREES"), "{:?}", log.notes());
    assert_eq!(q(&read_with((RECORDER.to_owned() + rows).as_bytes(), &force(4.0)).unwrap()), [[-turn, 0.1]]);

    // As radians where they fit, and as declared without a note.
    let small = " 7 1000 -1.5 0.1 5 3 4 0 9 1\n";
    let log = read(&(RECORDER.to_owned() + small)).unwrap();
    assert_eq!(q(&log), [[-1.5, 0.1]]);
    assert!(log.notes()[0].contains("RADIANS"), "{:?}", log.notes());
    let degrees = Options { unit: AngleUnit::Degree, ..Options::default() };
    let log = read_with((RECORDER.to_owned() + small).as_bytes(), &degrees).unwrap();
    assert_eq!(q(&log), [[-1.5f64.to_radians(), 0.1]]);
    assert!(log.notes().iter().all(|note| note.contains("no threshold")), "{:?}", log.notes());
    let radians = Options { unit: AngleUnit::Radian, ..Options::default() };
    refused(read_with((RECORDER.to_owned() + rows).as_bytes(), &radians), &["c.csv:2, joint `sh`", "declare unit"]);
    refused(read(&(RECORDER.to_owned() + &rows.replace("-90.0", "-900"))), &["c.csv:2, joint `sh`", "another robot"]);
    refused(read(&(RECORDER.to_owned() + "7 1000 1\n")), &["c.csv:2: expected 10 columns", "found 3"]);

    // Made into CSV by others; contacts of files read before stay as they were.
    let csv = "axisQMsr_LBR_iiwa_14_R820_1[1],axisQMsr_LBR_iiwa_14_R820_1[0]\n0.3,-80\n0.4,60\n";
    let mut log = ContactLog::new(2);
    for text in ["q1,q2\n1,0.5\n", csv] {
        contact_csv::read(text.as_bytes(), "c.csv", &arm(), &Options::default(), &mut log).unwrap();
    }
    assert_eq!(q(&log), [[1.0, 0.5], [-80f64.to_radians(), 0.3], [60f64.to_radians(), 0.4]]);
}

#[test]
fn columns_of_a_file_without_header_are_declared() {
    let header = ["t", "sl", "q1", "fx", "fy", "fz", "t"].map(str::to_owned).to_vec();
    let options = Options { header: Some(header), ..force(4.0) };
    let log = read_with(&b"0,0.2,0.1,3,4,0,x\n1,0.4,0.3,0,0,5,y\n"[..], &options).unwrap();
    assert_eq!((q(&log), lines(&log)), (vec![[0.1, 0.2], [0.3, 0.4]], vec![1, 2]));
    refused(read_with(&b"0,0.2\n"[..], &options), &["c.csv:1: expected 7 columns, as `header` declares, found 2"]);
    refused(read_with(&b"t,sl,q1,fx,fy,fz,x\n"[..], &options), &["c.csv:1, column sl: expected a number in metres"]);
    let options = Options { header: Some(vec!["a".to_owned(), "q2".to_owned()]), ..Options::default() };
    refused(read_with(&b"0,0\n"[..], &options), &["c.csv, header", "`sh` or `q1`", "columns \"a,q2\""]);
}

#[test]
fn a_misspelt_joint_is_pointed_at() {
    let long = ARM.replace("'sh'", "'shoulder'").replace("'sl'", "'slide'");
    let robot = urdf::read(&long, "arm.urdf", Ends::default()).unwrap();
    let found = |text: &str| {
        let read = contact_csv::read(text.as_bytes(), "c.csv", &robot, &Options::default(), &mut ContactLog::new(2));
        read.expect_err("accepted").to_string()
    };
    let message = found("time,sholder,slide\n0,0,0\n");
    assert!(message.contains("c.csv:1: expected a column for every joint: `shoulder` or `q1`"), "{message}");
    assert!(message.ends_with("(\"sholder\"; did you mean `shoulder`?)"), "{message}");
    assert!(found("j1,j2\n0,0\n").ends_with("(\"j1\"; did you mean `q1`?)"));
    // What is another joint's, or like none, is not offered.
    assert!(found("q1,time\n0,0\n").ends_with("found columns \"q1,time\""));
}

#[test]
fn contacts_come_from_force_or_flag_or_all_rows() {
    let text = "q1,q2,fx,fy,fz,contact\n0,0,0,0,0,1\n0,0,3,4,0,0\n0,0,0,0,-6,False\n0,0,1,0,0,TRUE\n";
    assert_eq!(lines(&read(text).unwrap()), [2, 5]);
    assert_eq!(lines(&read_with(text.as_bytes(), &force(4.0)).unwrap()), [3, 4]);
    let slow =
        Options { detection: Some(Detection { threshold: 4.0, release: 0.5, debounce: 2 }), ..Options::default() };
    assert_eq!(lines(&read_with(text.as_bytes(), &slow).unwrap()), [4, 5]);
    let light = read_with(text.as_bytes(), &force(99.0)).unwrap();
    assert_eq!((light.rows_read(), light.rows_left_out().out_of_contact), (4, 4));
    refused(read_with(&b"q1,q2,fx,fy\n0,0,1,1\n"[..], &force(3.0)), &["columns fx, fy and fz", "q1,q2,fx,fy"]);
    refused(read_with(&b"0,0\n"[..], &force(3.0)), &["columns fx, fy and fz", "no header"]);
}

#[test]
fn bad_content_is_refused_with_line_and_column() {
    refused(read("q1,q2\n0,0\n0,abc\n"), &["c.csv:3, column q2: expected a number in metres, found \"abc\""]);
    refused(read("sh,q2\n0,0\n1e,0\n"), &["c.csv:3, column sh: expected a number in radians, found \"1e\""]);
    refused(read("0,0\nnan,0\n"), &["c.csv:2, column q1", "found \"nan\""]);
    refused(read("nan,inf\n0,0\n"), &["c.csv:1, column q1", "found \"nan\""]);
    refused(read("0,0\n1e999,0\n"), &["found \"1e999\""]);
    refused(read("0,0\n,0\n"), &["c.csv:2, column q1", "found \"\""]);
    refused(read("q1,q2,contact\n0,0,yes\n"), &["column contact: expected 0, 1, true or false, found \"yes\""]);
    refused(read("q1,q2,fx,fy,fz\n0,0,0,0,x\n"), &["column fz: expected a number in N"]);
    refused(read("q1,q2\n0,0\n0\n"), &["c.csv:3: expected 2 columns", "`sh` or `sl`", "found 1"]);
    refused(read("q1,q2\n0,0,0\n"), &["c.csv:2: expected 2 columns", "found 3"]);
    refused(
        read("0,0,0\n"),
        &["c.csv:1", "2 columns, the joints in order (`sh` or `sl`), or a header", "found 3 columns"],
    );
    refused(read("0;0\n"), &["separated by `,`, not by `;`"]);
    refused(read("a,b\n0,0\n"), &["c.csv:1", "`sh` or `q1`", "found columns \"a,b\""]);
    refused(read("q1,q2,Q1\n0,0,0\n"), &["distinct column names", "`q1` twice (columns 1 and 3)"]);
    refused(read(""), &["c.csv", "an empty file"]);
    refused(read("\n \r\n"), &["an empty file"]);
    refused(read("q1,q2\n"), &["c.csv:1", "only a header"]);
    refused(read_with(&b"q1,q2\n0,\xff\xfe\n"[..], &Options::default()), &["c.csv:2, column q2"]);
    refused(read_with(&b"\xff,q2,x\n0,0,0\n"[..], &Options::default()), &["column names in UTF-8"]);
    refused(read_with(&b"PAR1\x15"[..], &Options::default()), &["found Parquet"]);
    refused(read_with(&b"\x89MCAP0\r\n"[..], &Options::default()), &["found MCAP"]);
    refused(read_with(&b"\xff\xfeq\x001\x00"[..], &Options::default()), &["found text in UTF-16"]);
    refused(read(&"9".repeat(1 << 20)), &["c.csv:1", "at most 65536 bytes in a line"]);
    refused(read("q1,q2\n\"0,0\n0,0\n"), &["c.csv:2, column q1"]);
}

#[test]
fn degrees_where_radians_are_declared_are_noticed() {
    refused(
        read("0,0\n45.0,0\n-80,0\n"),
        &["c.csv:2, joint `sh`", "[-2.0000, 2.0000]", "45", "looks like degrees; declare unit = \"deg\""],
    );
    let turned = "7.5,0\n-8.0,0\n";
    let (asked, of_recorder) =
        ("too large by a turn, or degrees; bring angles into the limits", turned.replace(',', " ") + "0 0\n");
    refused(read(turned), &["c.csv:1, joint `sh`", "7.5", asked]);
    refused(read(&("% axisQMsr_LBR_1[0] axisQMsr_LBR_1[1]\n".to_owned() + &of_recorder)), &["joint `sh`", asked]);
    refused(read("0,0\n1e7,0\n"), &["c.csv:2, column q1", "a joint position"]);
    // An encoder a little beyond the limit, and one odd row of many, are no other unit.
    assert!(read("2.2,0\n-2.8,0\n").is_ok());
    assert!(read(&("0,0\n".repeat(50) + "9,0\n")).is_ok());
    let degrees = Options { unit: AngleUnit::Degree, ..Options::default() };
    refused(read_with(&b"400,0\n"[..], &degrees), &["degrees within the joint limits [-114.6, 114.6]", "400"]);
}

#[test]
fn gzip_is_unpacked_and_damage_noticed() {
    let packed_from = |first: usize| {
        let rows = (first..first + 1000).map(|k| format!("0.{k:05},0.2\n"));
        gzip(rows.collect::<String>().as_bytes())
    };
    let packed = packed_from(0);
    assert_eq!(read_with(&packed[..], &Options::default()).unwrap().len(), 1000);
    let both = [packed.clone(), packed_from(1000)].concat();
    assert_eq!(read_with(&both[..], &Options::default()).unwrap().len(), 2000);
    refused(read_with(&packed[..packed.len() / 2], &Options::default()), &["c.csv:", "complete gzip data", "damaged"]);
    let mut flipped = packed.clone();
    let at = flipped.len() - 6;
    flipped[at] ^= 0xff;
    refused(read_with(&flipped[..], &Options::default()), &["complete gzip data"]);
    refused(read_with(&packed[..5], &Options::default()), &["complete gzip data"]);
}

#[test]
fn a_bomb_of_one_line_is_not_unpacked() {
    let bomb = gzip(&vec![b'1'; 64 << 20]);
    refused(read_with(&bomb[..], &Options::default()), &["c.csv:1", "at most 65536 bytes in a line"]);
}

#[test]
fn files_are_fingerprinted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.csv");
    std::fs::write(&path, "0.1,0.2\n").unwrap();
    let mut log = ContactLog::new(2);
    let input = contact_log::read_file(&path, &arm(), &Options::default(), &mut log).unwrap();
    assert_eq!(input.sha256, "cfd4683f10687dd7d53b38219422f8b28f0f570807e7e2271a25652d86bf9e0d");
    let missing = contact_log::read_file(&folder.path().join("no.csv"), &arm(), &Options::default(), &mut log);
    assert!(missing.unwrap_err().to_string().contains("no.csv: could not open"));
    let directory = contact_log::read_file(folder.path(), &arm(), &Options::default(), &mut log);
    assert!(directory.unwrap_err().to_string().contains("expected a file, found a folder"));
}

proptest! {
    #[test]
    fn any_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..300), threshold in any::<bool>()) {
        let options = if threshold { force(3.0) } else { Options::default() };
        let _ = read_with(&bytes[..], &options);
        let _ = read_with(&gzip(&bytes)[..], &options);
        let _ = read_with(&[&[0x1f, 0x8b][..], &bytes].concat()[..], &options);
    }

    #[test]
    fn mutated_logs_are_answered(at in 0..60usize, cut in 0..8usize, with in "[0-9q,.\"\\n\\r eE+-]{0,5}") {
        let text = "t,q1,q2,fx,fy,fz,contact\n0,0.1,0.2,1,2,3,1\n1,0.3,0.4,4,5,6,0\n";
        let mut bytes = text.as_bytes().to_vec();
        bytes.splice(at..(at + cut).min(text.len()), with.bytes());
        let _ = read_with(&bytes[..], &force(3.0));
        let mut packed = gzip(text.as_bytes());
        let at = at % packed.len();
        packed[at] ^= 1 + cut as u8;
        let _ = read_with(&packed[..], &Options::default());
    }

    #[test]
    fn written_numbers_are_read_exactly(rows in prop::collection::vec((-2.0..2.0f64, -5.0..5.0f64), 1..20)) {
        let text: String = rows.iter().map(|(a, b)| format!("{a},{b:e}\n")).collect();
        let expected: Vec<[f64; 2]> = rows.iter().map(|(a, b)| [*a, *b]).collect();
        prop_assert_eq!(q(&read(&text).unwrap()), expected);
    }
}

fn read_columns(names: &[&str], rows: &[&[f64]], options: &Options) -> Result<ContactLog, String> {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let columns = Columns { names: &names, rows: rows.len(), value: &|row, column| rows[row][column] };
    let mut log = ContactLog::new(2);
    contact_log::read_columns(&columns, "c.csv", &arm(), options, &mut log).map_err(|error| error.to_string())?;
    Ok(log)
}

/// Columns in memory are understood as those of a file are; its first row comes after the header.
#[test]
fn columns_in_memory_are_a_file_without_its_text() {
    let names = ["fz", "Sl", "time", "fx", "q1", "fy"];
    let rows: [&[f64]; 4] = [
        &[0.1, 0.25, 7.0, 0.0, 40.0, 0.0],
        &[9.1, 0.5, 8.0, 0.0, -50.0, 0.0],
        &[2.5, 0.125, f64::NAN, 0.0, 60.0, 0.0],
        &[0.0, 0.0, 9.0, 0.0, 70.0, 0.0],
    ];
    let text: Vec<String> = rows.map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",")).to_vec();
    let text = format!("{}\n{}\n", names.join(","), text.join("\n"));
    let detection = Some(Detection { threshold: 3.0, release: 2.0, debounce: 1 });
    let options = Options { unit: AngleUnit::Degree, detection, ..Options::default() };
    let (file, memory) =
        (read_with(text.as_bytes(), &options).unwrap(), read_columns(&names, &rows, &options).unwrap());
    assert_eq!(q(&file), q(&memory));
    assert_eq!(q(&memory), [[(-50f64).to_radians(), 0.5], [60f64.to_radians(), 0.125]]);
    assert_eq!((lines(&file), lines(&memory)), (vec![3, 4], vec![2, 3]));
    assert_eq!((file.rows_read(), memory.rows_read()), (4, 4));
}

#[test]
fn columns_in_memory_are_refused_as_a_file_is() {
    let plain = Options::default();
    refused(
        read_columns(&["q1", "q2"], &[&[0.1, f64::NAN]], &plain),
        &["c.csv:1, column q2: expected a number in metres, found NaN"],
    );
    refused(
        read_columns(&["q1", "q2", "contact"], &[&[0.1, 0.2, 0.5]], &plain),
        &["expected 0, 1, true or false, found 0.5"],
    );
    refused(read_columns(&["q1", "fx"], &[&[0.1, 0.2]], &plain), &["expected a column for every joint: `sl` or `q2`"]);
    refused(read_columns(&["q1", "q2"], &[], &plain), &["expected rows of joint positions, found none"]);
    refused(read_columns(&["q1", "q2"], &[&[0.1, 0.2]], &force(3.0)), &["columns fx, fy and fz"]);
    refused(read_columns(&["q1", "q2"], &[&[80.0, 0.2]], &plain), &["looks like degrees"]);
}

#[test]
fn the_temperature_is_that_of_the_named_column() {
    let text = "q1,q2,T arm,contact\n0.1,0.2,21.5,1\n0.1,0.3,22,0\n0.1,0.4,22.25,1\n";
    let log = read(text).unwrap();
    assert_eq!((log.len(), log.temperature(0)), (2, None));
    let named = |name: &str| Options { temperature: Some(name.to_owned()), ..Options::default() };
    let log = read_with(text.as_bytes(), &named("T arm")).unwrap();
    assert_eq!([log.temperature(0), log.temperature(1), log.temperature(2)], [Some(21.5), Some(22.25), None]);
    // With the contacts that are kept, and with those that are appended.
    assert_eq!(log.filtered(|i| i == 1).temperature(0), Some(22.25));
    let mut all = read(text).unwrap();
    all.append(&log, 1);
    assert_eq!([all.temperature(1), all.temperature(2), all.temperature(3)], [None, Some(21.5), Some(22.25)]);
    let apart = Options { apart: Some(0.15), ..named("T arm") };
    let log = read_with(text.replace(",0\n", ",1\n").as_bytes(), &apart).unwrap();
    assert_eq!([log.temperature(0), log.temperature(1)], [Some(21.5), Some(22.25)]);
    let error = read_with(text.as_bytes(), &named("T_arm")).unwrap_err();
    assert!(error.contains("column `T_arm`") && error.contains("did you mean `T arm`"), "{error}");
    let error = read_with(text.replace("22.25", "warm").as_bytes(), &named("T arm")).unwrap_err();
    assert!(error.contains("a number in degrees Celsius") && error.contains("warm"), "{error}");
}
