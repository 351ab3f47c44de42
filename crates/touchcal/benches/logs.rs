//! How fast logs are read, and in how much memory: bags of a gigabyte, tables of ten million rows.
//! The files lie in a temporary folder, and are gone afterwards.
//!
//! `cargo bench -p touchcal --features mcap,parquet --bench logs --profile dev`, or without
//! `--profile dev` as it is released.
// A bench fails by panicking, and reports by printing.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use byteorder::LittleEndian;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Serialize;
use touchcal::contact::ContactLog;
use touchcal::contact::Detection;
use touchcal::io::contact_log::{self, LogTable, Options};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Robot;

/// Bytes of a bag before it is packed.
const BAG: usize = 1_000_000_000;
/// Bytes of a picture, and how many joint states and wrenches follow it.
const PICTURE: usize = 20_000;
const STATES: u64 = 4;
/// Rows of a table.
const ROWS: usize = 10_000_000;

#[derive(Serialize)]
struct Header<'a>(i32, u32, &'a str);

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    for (name, packing) in [("none", None), ("lz4", Some(Compression::Lz4)), ("zstd", Some(Compression::Zstd))] {
        let path = folder.path().join("log.mcap");
        write_bag(&path, &robot, packing);
        let detection = Some(Detection { threshold: 0.5, release: 0.5, debounce: 1 });
        measure(&format!("MCAP, {name}"), &path, &robot, &Options { detection, ..Options::default() });
        std::fs::remove_file(path).unwrap();
    }
    let path = folder.path().join("log.csv");
    write_table(&path, &robot);
    measure("CSV", &path, &robot, &Options::default());
    let parquet = folder.path().join("log.parquet");
    LogTable::read_file(&path, &robot, &Options::default()).unwrap().write_file(&parquet).unwrap();
    measure("Parquet", &parquet, &robot, &Options::default());
}

fn measure(what: &str, path: &Path, robot: &Robot, options: &Options) {
    let megabytes = std::fs::metadata(path).unwrap().len() as f64 / 1e6;
    forget_peak();
    let (start, worked) = (Instant::now(), processor_seconds());
    let mut log = ContactLog::new(robot.dof());
    contact_log::read_file(path, robot, options, &mut log).unwrap();
    let (seconds, worked) = (start.elapsed().as_secs_f64(), processor_seconds() - worked);
    println!(
        "{what}: {megabytes:.0} MB, {} rows, {} contacts in {seconds:.2} s ({worked:.2} s of a processor): {:.0} MB/s; most memory {}",
        log.rows_read(),
        log.len(),
        megabytes / seconds,
        peak()
    );
}

/// Pictures, which nobody asks for, among joint states and wrenches. They pack to about two thirds.
fn write_bag(path: &Path, robot: &Robot, packing: Option<Compression>) {
    let mut chance = Pcg64::seed_from_u64(1);
    let names: Vec<&str> = robot.moving().map(|joint| joint.name.as_str()).collect();
    let mut writer =
        WriteOptions::new().compression(packing).create(BufWriter::new(File::create(path).unwrap())).unwrap();
    let channel = |writer: &mut Writer<BufWriter<File>>, topic: &str, kind: &str| {
        let schema = writer.add_schema(kind, "ros2msg", b"").unwrap();
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap()
    };
    let pictures = channel(&mut writer, "/camera", "sensor_msgs/msg/Image");
    let states = channel(&mut writer, "/joint_states", "sensor_msgs/msg/JointState");
    let wrenches = channel(&mut writer, "/wrench", "geometry_msgs/msg/WrenchStamped");
    let mut picture = vec![0u8; PICTURE];
    for k in 0..(BAG / (PICTURE + 450 * STATES as usize)) as u64 {
        picture.iter_mut().for_each(|byte| *byte = chance.random_range(0..32));
        write(&mut writer, pictures, k, &picture);
        for ms in k * STATES..(k + 1) * STATES {
            let header = || Header((ms / 1000) as i32 + 1, (ms % 1000) as u32 * 1_000_000, "base");
            let wave = (ms as f64 * 1e-3).sin();
            let none: [f64; 0] = [];
            let state = (header(), &names, vec![wave; names.len()], &none[..], &none[..]);
            write(&mut writer, states, ms, &cdr(&state));
            write(&mut writer, wrenches, ms, &cdr(&(header(), [0.0, 0.0, 10.0 * wave, 0.0, 0.0, 0.0])));
        }
    }
    writer.finish().unwrap();
}

fn write(writer: &mut Writer<BufWriter<File>>, channel_id: u16, time: u64, data: &[u8]) {
    let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
    writer.write_to_known_channel(&header, data).unwrap();
}

fn cdr(message: &impl Serialize) -> Vec<u8> {
    [&[0, 1, 0, 0][..], &cdr_encoding::to_vec::<_, LittleEndian>(message).unwrap()].concat()
}

/// Joint positions with nine decimals.
fn write_table(path: &Path, robot: &Robot) {
    let names: Vec<&str> = robot.moving().map(|joint| joint.name.as_str()).collect();
    let value = |row: usize, column: usize| (row as f64 * 0.61 + column as f64).sin();
    let mut file = BufWriter::new(File::create(path).unwrap());
    writeln!(file, "{}", names.join(",")).unwrap();
    for row in 0..ROWS {
        write!(file, "{:.9}", value(row, 0)).unwrap();
        (1..names.len()).for_each(|column| write!(file, ",{:.9}", value(row, column)).unwrap());
        writeln!(file).unwrap();
    }
    file.flush().unwrap();
}

/// Seconds that this process has worked.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = stat
        .rsplit(") ")
        .next()
        .unwrap_or_default()
        .split(' ')
        .skip(11)
        .take(2)
        .filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / 100.0
}

/// Makes the system forget the most memory that this process had so far, where it can: elsewhere
/// [`peak`] is that of the whole run.
fn forget_peak() {
    std::fs::write("/proc/self/clear_refs", "5").unwrap_or_default();
}

/// Most memory that this process had since [`forget_peak`], as the system says it.
fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or("unknown".to_owned(), |line| line.trim().to_owned())
}
