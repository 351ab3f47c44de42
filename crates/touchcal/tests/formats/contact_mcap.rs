//! Contact logs in ROS 2 bags, written by the crates `mcap` and `cdr-encoding`: the contacts that
//! were put in, and damage refused.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use crate::support::small_arm::arm;
use byteorder::{BigEndian, LittleEndian};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use proptest::prelude::*;
use serde::Serialize;
use touchcal::contact::{AngleUnit, ContactLog, Detection, Load, LoadFrame, LoadOn, TorqueOf};
use touchcal::io::contact_log::{self, Options};

#[derive(Serialize)]
struct Header {
    sec: i32,
    nanosec: u32,
    frame_id: String,
}

#[derive(Serialize)]
struct JointState {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

#[derive(Serialize)]
struct WrenchStamped {
    header: Header,
    force_and_torque: [f64; 6],
}

/// A message as DDS writes it.
fn cdr(message: &impl Serialize, little_endian: bool) -> Vec<u8> {
    let body = match little_endian {
        true => cdr_encoding::to_vec::<_, LittleEndian>(message),
        false => cdr_encoding::to_vec::<_, BigEndian>(message),
    };
    [&[0, u8::from(little_endian), 0, 0][..], &body.unwrap()].concat()
}

/// Frame names of every length, so that what follows is aligned in every way; no stamp is zero,
/// which means that it is not set.
fn header(ms: i64) -> Header {
    let ms = ms + 1000;
    let (sec, nanosec) = (ms.div_euclid(1000) as i32, ms.rem_euclid(1000) as u32 * 1_000_000);
    Header { sec, nanosec, frame_id: "x".repeat(ms as usize % 10) }
}

fn unset() -> Header {
    Header { sec: 0, nanosec: 0, frame_id: String::new() }
}

fn joints(ms: i64, state: &[(&str, f64)]) -> JointState {
    let name = state.iter().map(|(name, _)| (*name).to_owned()).collect();
    JointState {
        header: header(ms),
        name,
        position: state.iter().map(|(_, q)| *q).collect(),
        velocity: vec![1.0; 3],
        effort: Vec::new(),
    }
}

fn wrench(ms: i64, force: f64) -> WrenchStamped {
    WrenchStamped { header: header(ms), force_and_torque: [0.0, 0.6 * force, 0.8 * force, 9.0, 9.0, 9.0] }
}

/// Writes messages, one after the other, to topics.
struct Bag {
    writer: Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<String, u16>,
    little_endian: bool,
}

impl Bag {
    fn new(options: WriteOptions) -> Self {
        Bag { writer: options.create(Cursor::new(Vec::new())).unwrap(), channels: BTreeMap::new(), little_endian: true }
    }

    fn raw(&mut self, topic: &str, (schema, encoding): (&str, &str), ms: u64, data: &[u8]) {
        let channel_id = *self.channels.entry(topic.to_owned()).or_insert_with(|| {
            let schema = self.writer.add_schema(schema, "ros2msg", b"float64 x").unwrap();
            self.writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap()
        });
        let head = MessageHeader { channel_id, sequence: 0, log_time: ms * 1_000_000, publish_time: 0 };
        self.writer.write_to_known_channel(&head, data).unwrap();
    }

    fn joints(&mut self, topic: &str, ms: i64, state: &[(&str, f64)]) {
        let data = cdr(&joints(ms, state), self.little_endian);
        self.raw(topic, ("sensor_msgs/msg/JointState", "cdr"), 77, &data);
    }

    fn wrench(&mut self, topic: &str, ms: i64, force: f64) {
        let data = cdr(&wrench(ms, force), self.little_endian);
        self.raw(topic, ("geometry_msgs/msg/WrenchStamped", "cdr"), 78, &data);
    }

    fn finish(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }
}

fn bag(options: WriteOptions, fill: impl FnOnce(&mut Bag)) -> Vec<u8> {
    let mut bag = Bag::new(options);
    fill(&mut bag);
    bag.finish()
}

fn plain() -> WriteOptions {
    WriteOptions::new().compression(None)
}

fn read(folder: &Path, bytes: &[u8], options: &Options) -> Result<ContactLog, String> {
    let path = folder.join("b.mcap");
    std::fs::write(&path, bytes).unwrap();
    let mut log = ContactLog::new(2);
    contact_log::read_file(&path, &arm(), options, &mut log).map_err(|error| error.to_string())?;
    Ok(log)
}

fn force(threshold: f64) -> Options {
    Options { detection: Some(Detection { threshold, release: threshold, debounce: 1 }), ..Options::default() }
}

fn contacts(log: &ContactLog) -> Vec<(u64, [f64; 2])> {
    (0..log.len()).map(|i| (log.source(i).line, [log.q(i)[0], log.q(i)[1]])).collect()
}

/// 300 joint states every 10 ms and wrenches every 7 ms whose force rises by 1 N a second, among a
/// camera's pictures.
fn recording(bag: &mut Bag) {
    let mut wrenches = (0i64..).map(|k| 7 * k).peekable();
    for k in 0..300i64 {
        let ms = 10 * k;
        bag.raw("/camera", ("sensor_msgs/msg/Image", "cdr"), 1, &vec![k as u8; 5000]);
        bag.joints("/joint_states", ms, &[("sl", 0.001 * k as f64), ("gripper", f64::NAN), ("sh", -0.002 * k as f64)]);
        while let Some(at) = wrenches.next_if(|at| *at <= ms + 20) {
            bag.wrench("/wrench", at, at as f64 * 1e-3);
        }
        bag.joints("/joint_states", ms, &[("gripper", 0.0)]);
    }
}

#[test]
fn what_was_recorded_is_read_whatever_packs_it() {
    let folder = tempfile::tempdir().unwrap();
    let packings = [None, Some(Compression::Lz4), Some(Compression::Zstd)];
    let chunked = packings.map(|packing| WriteOptions::new().compression(packing).chunk_size(Some(100_000)));
    let whole = WriteOptions::new().compression(Some(Compression::Zstd)).chunk_size(None);
    for options in chunked.into_iter().chain([whole, WriteOptions::new().use_chunks(false)]) {
        for little_endian in [true, false] {
            let bytes = bag(options.clone(), |bag| {
                bag.little_endian = little_endian;
                recording(bag);
            });
            let log = read(folder.path(), &bytes, &Options::default()).unwrap();
            let expected: Vec<_> = (0..300).map(|k| (k + 1, [-0.002 * k as f64, 0.001 * k as f64])).collect();
            assert_eq!((contacts(&log), log.rows_read()), (expected.clone(), 300));

            // 1.005 N is between joint states 100 and 101, and in general between two wrenches.
            let log = read(folder.path(), &bytes, &force(1.005)).unwrap();
            assert_eq!(contacts(&log), expected[101..]);
            assert_eq!((log.rows_read(), log.notes()), (300, &[][..]));

            let load = Some(Load { on: LoadOn::Fixture, frame: LoadFrame::Tip, lag: 0.0 });
            let log = read(folder.path(), &bytes, &Options { load, ..Options::default() }).unwrap();
            let last = log.load(log.len() - 1);
            let force = -0.01 * (log.source(log.len() - 1).line - 1) as f64;
            let expected = [0.0, 0.6 * force, 0.8 * force, -9.0, -9.0, -9.0];
            assert!(last.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12), "{last:?}");
        }
    }
}

/// Efforts of joint states are torques where these are asked for, with and without wrenches.
#[test]
fn efforts_are_joint_torques() {
    let folder = tempfile::tempdir().unwrap();
    let options = Options { joint_torques: Some(TorqueOf::Motor), ..Options::default() };
    let with = |effort: &[f64]| {
        [true, false].map(|little_endian| {
            bag(plain(), |bag| {
                for ms in 0..20 {
                    let mut state = joints(ms, &[("sl", 0.2), ("sh", 0.1)]);
                    (state.effort, state.velocity) = (effort.to_vec(), vec![1.0; ms as usize % 3]);
                    bag.raw("/j", ("sensor_msgs/msg/JointState", "cdr"), 77, &cdr(&state, little_endian));
                    bag.wrench("/w", ms, 5.0);
                }
            })
        })
    };
    for bytes in with(&[-4.0, 3.0]) {
        for options in [options.clone(), Options { joint_torques: options.joint_torques, ..force(1.0) }] {
            let log = read(folder.path(), &bytes, &options).unwrap();
            assert!(log.len() > 15);
            assert!((0..log.len()).all(|i| log.joint_torques(i) == Some(&[-3.0, 4.0][..])), "{log:?}");
        }
        assert!(!read(folder.path(), &bytes, &Options::default()).unwrap().has_joint_torques());
    }
    for bytes in [with(&[]), with(&[1.0, f64::NAN])].concat() {
        let message = read(folder.path(), &bytes, &options).unwrap_err();
        assert!(message.contains("joint state 1: expected a finite effort of each joint"), "{message}");
    }
}

#[test]
fn topics_names_and_units_are_as_declared() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = bag(plain(), |bag| {
        bag.joints("/left", 0, &[("a", 90.0), ("b", 0.5)]);
        bag.joints("/right", 0, &[("a", 45.0), ("b", 0.7)]);
        bag.wrench("/ft", 0, 5.0);
        bag.wrench("/ft_raw", 0, 0.0);
    });
    let columns = [("q1", "a"), ("sl", "b")].map(|(usual, name)| (usual.to_owned(), name.to_owned())).into();
    let joint_topic = Some("/right".to_owned());
    let options = Options { columns, joint_topic, unit: AngleUnit::Degree, ..Options::default() };
    let turn = std::f64::consts::FRAC_PI_4;
    assert_eq!(contacts(&read(folder.path(), &bytes, &options).unwrap()), [(1, [turn, 0.7])]);
    let options = Options { wrench_topic: Some("/ft".to_owned()), detection: force(3.0).detection, ..options };
    assert_eq!(contacts(&read(folder.path(), &bytes, &options).unwrap()), [(1, [turn, 0.7])]);
    let options = Options { wrench_topic: Some("/ft_raw".to_owned()), ..options };
    assert_eq!(contacts(&read(folder.path(), &bytes, &options).unwrap()), []);

    let refused = |options: &Options, part: &str| {
        let message = read(folder.path(), &bytes, options).unwrap_err();
        assert!(message.contains("b.mcap") && message.contains(part), "expected `{part}` in: {message}");
    };
    refused(&Options { joint_topic: None, ..options.clone() }, "`joint_topic`, found \"/left\" and \"/right\"");
    refused(&Options { joint_topic: Some("/write".to_owned()), ..options.clone() }, "on /write, found topics `/left`");
    refused(&Options { joint_topic: Some("/rihgt".to_owned()), ..options.clone() }, "did you mean `/right`?");
    refused(
        &Options { columns: BTreeMap::new(), ..options.clone() },
        "joint states of `sh` or `sl` on /right, found those of `a` or `b`",
    );
    refused(&Options { columns: [("q3".to_owned(), "a".to_owned())].into(), ..options.clone() }, "a name to rename");
    refused(
        &Options { unit: AngleUnit::Radian, wrench_topic: Some("/ft".to_owned()), ..options },
        "looks like degrees",
    );
}

#[test]
fn without_stamps_it_counts_when_messages_were_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = bag(plain(), |bag| {
        for k in 0..4u64 {
            let state = joints(0, &[("sh", 0.0), ("sl", k as f64)]);
            let state = JointState { header: unset(), ..state };
            bag.raw("/j", ("sensor_msgs/msg/JointState", "cdr"), 10 * k, &cdr(&state, true));
            let wrench = WrenchStamped { header: unset(), ..wrench(0, 10.0 * k as f64) };
            bag.raw("/w", ("geometry_msgs/msg/WrenchStamped", "cdr"), 10 * k + 5, &cdr(&wrench, true));
        }
    });
    let log = read(folder.path(), &bytes, &force(10.0)).unwrap();
    // The first has no wrench before it; the others see 5, 15 and 25 N.
    assert_eq!(contacts(&log), [(3, [0.0, 2.0]), (4, [0.0, 3.0])]);
    assert!(log.notes()[0].contains("1 joint states have no wrench"), "{:?}", log.notes());
}

#[test]
fn bad_bags_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |bytes: &[u8], options: &Options, part: &str| {
        let message = read(folder.path(), bytes, options).unwrap_err();
        assert!(message.contains("b.mcap") && message.contains(part), "expected `{part}` in: {message}");
    };
    let none = Options::default();
    let states = |states: &[&[(&str, f64)]]| {
        bag(plain(), |bag| states.iter().zip(0..).for_each(|(state, ms)| bag.joints("/j", ms, state)))
    };
    let good: &[(&str, f64)] = &[("sh", 0.1), ("sl", 0.2)];
    refused(
        &states(&[good, &good[..1]]),
        &none,
        "joint state 2: expected finite positions of all joints (`sh` or `sl`), found none of `sl`",
    );
    refused(&states(&[good, &[("sh", f64::NAN), ("sl", 0.0)]]), &none, "joint state 2: expected finite positions");
    refused(&states(&[&[("sh", 0.1), ("sl", 0.2), ("sh", 0.1)]]), &none, "each joint once");
    refused(&states(&[&[("sh", 0.0), ("sl", 1e9)]]), &none, "joint state 1, column sl: expected a joint position");
    refused(
        &states(&[&[("other", 0.1)]]),
        &none,
        "b.mcap: expected joint states of `sh` or `sl` on /j, found those of `other`; `columns = { sh = \"…\" }` says",
    );
    refused(&states(&[&[("sh", 0.1), ("sll", 0.1)]]), &none, "found none of `sl`, but `sll`; did you mean `sll`?");
    refused(
        &states(&[good]),
        &force(1.0),
        "geometry_msgs/msg/WrenchStamped for the force threshold, found topics `/j`",
    );
    let back = bag(plain(), |bag| [5, 3].into_iter().for_each(|ms| bag.joints("/j", ms, good)));
    refused(&back, &none, "topic /j, message 2: expected messages in the order of time, found 2000000 ns before");
    let json = bag(plain(), |bag| bag.raw("/j", ("sensor_msgs/msg/JointState", "json"), 0, b"{}"));
    refused(&json, &none, "topic /j: expected messages encoded as cdr, found \"json\"");
    let apart = bag(plain(), |bag| {
        bag.joints("/j", 5000, good);
        bag.wrench("/w", 0, 1.0);
        bag.wrench("/w", 9000, 1.0);
    });
    refused(&apart, &force(1.0), "wrenches within 0.1 s of joint states, found none");
    for short in [0, 3, 4, 7, 20, 59] {
        let data = cdr(&joints(0, good), true);
        let cut = bag(plain(), |bag| bag.raw("/j", ("sensor_msgs/msg/JointState", "cdr"), 0, &data[..short]));
        refused(&cut, &none, "joint state 1: expected");
    }
    // A length that memory does not have: neither of a record nor of names.
    let mut long = states(&[good]);
    long.truncate(8);
    long.extend([3].into_iter().chain((1u64 << 60).to_le_bytes()));
    refused(&long, &none, "a record of 1152921504606846976 bytes");
    let many = bag(plain(), |bag| {
        let names = [&[0, 1, 0, 0][..], &[0; 8], &[1, 0, 0, 0, 0, 0, 0, 0], &u32::MAX.to_le_bytes()].concat();
        bag.raw("/j", ("sensor_msgs/msg/JointState", "cdr"), 0, &names);
    });
    refused(&many, &none, "joint state 1: expected a whole message");
    refused(b"\x89MCAP", &none, "a whole MCAP file, found one that is cut off");
    refused(b"\x89MCAP1\r\n", &none, "another beginning");
    let mut checked = bag(plain(), recording);
    let at = checked.windows(7).position(|window| window == b"gripper").unwrap();
    checked[at] ^= 1;
    refused(&checked, &none, "a chunk whose checksum is another");
}

#[test]
fn the_folder_of_a_bag_is_its_only_file() {
    let folder = tempfile::tempdir().unwrap();
    let read = || {
        let mut log = ContactLog::new(2);
        let input = contact_log::read_file(folder.path(), &arm(), &Options::default(), &mut log);
        input.map(|input| (input.path, log)).map_err(|error| error.to_string())
    };
    let bag = bag(plain(), recording);
    std::fs::write(folder.path().join("metadata.yaml"), "rosbag2_bagfile_information:").unwrap();
    assert!(read().unwrap_err().contains("expected the folder of a bag with one file, found a folder of none"));
    std::fs::write(folder.path().join("run_0.mcap"), &bag).unwrap();
    let (path, log) = read().unwrap();
    assert!(path.ends_with("run_0.mcap") && !log.is_empty(), "{path}");
    assert!(log.notes().iter().any(|note| note.contains("there are forces, but no threshold")), "{:?}", log.notes());
    std::fs::remove_file(folder.path().join("metadata.yaml")).unwrap();
    assert!(read().unwrap().0.ends_with("run_0.mcap"));
    std::fs::write(folder.path().join("run_1.mcap"), &bag).unwrap();
    assert!(read().unwrap_err().ends_with("found a folder of `run_0.mcap` or `run_1.mcap`"));
}

#[test]
fn bags_that_are_cut_off_are_noticed_wherever() {
    let folder = tempfile::tempdir().unwrap();
    for options in [WriteOptions::new().use_chunks(false), WriteOptions::new().compression(Some(Compression::Lz4))] {
        let whole = bag(options, |bag| bag.joints("/j", 0, &[("sh", 0.1), ("sl", 0.2)]));
        // What is after the data (its end is thirteen bytes) is not needed.
        let data_end =
            (0..whole.len()).rev().find(|&at| whole[at..].starts_with(&[0x0f, 4, 0, 0, 0, 0, 0, 0, 0])).unwrap();
        for end in 5..data_end + 13 {
            let message = read(folder.path(), &whole[..end], &Options::default()).unwrap_err();
            assert!(message.contains("a whole MCAP file"), "{end} of {}: {message}", whole.len());
        }
        assert_eq!(read(folder.path(), &whole[..data_end + 13], &Options::default()).unwrap().len(), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn damaged_bags_are_answered(
        packing in 0..4usize,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        end in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let packing = [None, None, Some(Compression::Lz4), Some(Compression::Zstd)][packing];
        // Without checksums, so that damage comes through to what is behind them.
        let options = WriteOptions::new().compression(packing).calculate_chunk_crcs(false).chunk_size(Some(2000));
        let mut bytes = bag(options, |bag| {
            for k in 0..20 {
                bag.joints("/j", k, &[("sh", 0.1), ("sl", 0.2)]);
                bag.wrench("/w", k, 5.0);
            }
        });
        for (at, with) in flips {
            let at = at.index(bytes.len());
            bytes[at] = with;
        }
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        let _ = read(folder.path(), &bytes, &force(1.0));
    }
}
