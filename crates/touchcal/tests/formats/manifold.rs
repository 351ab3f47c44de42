//! Poses and stored manifolds: read as written, everything else refused.

use crate::support;
use crate::support::{gzip, refused};

use nalgebra::{Quaternion, UnitQuaternion};
use proptest::prelude::*;
use touchcal::io::Input;
use touchcal::io::manifold_file::{self, ManifoldFile, Provenance};
use touchcal::io::{atomic, pose_file};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::{Coverage, PoseSamples};
use touchcal::se3::Pose;

const HEADER: &str = "x,y,z,qw,qx,qy,qz\n";

fn read(content: impl AsRef<[u8]>) -> Result<Vec<Pose>, String> {
    pose_file::read(content.as_ref(), "p.csv").map_err(|error| error.to_string())
}

#[test]
fn columns_of_poses_are_found_by_name() {
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(0.6, 0.0, -0.8, 0.0));
    let expected = vec![Pose::from_parts([1e-3, -0.2, 3.0].into(), turn); 2];
    for text in [
        "x,y,z,qw,qx,qy,qz\n0.001,-0.2,3,0.6,0,-0.8,0\n1e-3,-0.2,3,0.6,0,-0.8,0\n",
        "\u{feff}gap, QZ,qw,qx,qy,z,y,x\r\n\r\n?,0,0.6,0,-0.8,3,-0.2,0.001\r\n,0,0.6,0,-0.8,3,-0.2,0.001",
        "\"x\",y,z,qw,qx,qy,qz,\"a, b\"\n0.001,-0.2,3,0.6,0,-0.8,0,\n0.001,-0.2,3,0.6,0,-0.8,0,\",\"\n",
    ] {
        assert_eq!(read(text).unwrap(), expected, "{text}");
        assert_eq!(read(gzip(text.as_bytes())).unwrap(), expected);
    }
    assert_eq!(read(HEADER).unwrap(), []);
}

#[test]
fn bad_poses_are_refused_with_line_and_column() {
    let rows = |rows: &str| read(format!("{HEADER}{rows}"));
    refused(read(""), &["p.csv: expected a header with x,y,z,qw,qx,qy,qz, found an empty file"]);
    refused(read("x,y,z,qw,qx,qy\n"), &["p.csv:1", "`qz` is missing", "found columns \"x,y,z,qw,qx,qy\""]);
    refused(read("0,0,0,1,0,0,0\n"), &["p.csv:1", "`x` is missing"]);
    refused(read("x;y;z;qw;qx;qy;qz\n"), &["separated by `,`, not by `;`"]);
    refused(read("x,y,z,qw,qx,qy,qz,X\n"), &["`x` twice (columns 1 and 8)"]);
    refused(rows("0,0,0,1,0,0\n"), &["p.csv:2: expected 7 columns, as in the header, found 6"]);
    refused(rows("0,0,0,1,0,0,0\n0,0,nan,1,0,0,0\n"), &["p.csv:3, column z: expected a number, found \"nan\""]);
    refused(rows("0,0,0,1,0,0,1e999\n"), &["column qz", "found \"1e999\""]);
    refused(
        rows("0,12.5,0,1,0,0,0\n"),
        &["p.csv:2, column y: expected metres within ±10, found 12.5: in millimetres?"],
    );
    refused(rows("0,0,0,1,0,0,1\n"), &["p.csv:2: expected a quaternion qw,qx,qy,qz of norm 1, found norm 1.414"]);
    refused(rows("0,0,0,0,0,0,0\n"), &["found norm 0"]);
    refused(read(&gzip(HEADER.as_bytes())[..20]), &["complete gzip data"]);
    refused(read(gzip(&vec![b'x'; 64 << 20])), &["at most 65536 bytes in a line"]);
    refused(read(b"PK\x03\x04"), &["a zip archive"]);
    refused(read(b"\xff\xfe"), &["text in UTF-16"]);

    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, rows: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("{HEADER}{rows}")).unwrap();
        pose_file::read_file(&path).map_err(|error| error.to_string())
    };
    refused(file("none.csv", ""), &["none.csv: expected at least two different poses, found 0 in 0"]);
    refused(file("one.csv", &"0,0,0,1,0,0,0\n".repeat(4)), &["one.csv", "found 1 in 4"]);
    let (samples, input) = file("two.csv", "0,0,0,1,0,0,0\n0,0,1,1,0,0,0\n").unwrap();
    assert_eq!((samples.len(), input.sha256.len()), (2, 64));
    assert!(pose_file::read_file(folder.path()).unwrap_err().to_string().contains("found a folder"));
}

fn manifold() -> ManifoldFile {
    let samples = (0..20).map(|i| [1e-3 * f64::from(i), 0.1, -0.2, 1e-9 * f64::from(i), 3.1, -1.0 / 3.0]);
    ManifoldFile {
        samples: PoseSamples::new(samples.collect()).unwrap(),
        provenance: Provenance {
            fixture: "hole/0 \"é\"".to_owned(),
            recorded: 81,
            spacing: 5e-4,
            metres_per_radian: Metric::MILLIMETRE_PER_DEGREE.metres_per_radian,
            inputs: vec![Input { path: "a/b.csv.gz".to_owned(), sha256: "0f".repeat(32), is_log: false }],
            version: "0.1.0".to_owned(),
        },
    }
}

fn back(bytes: &[u8]) -> Result<ManifoldFile, String> {
    ManifoldFile::from_bytes(bytes, "m.safetensors").map_err(|error| error.to_string())
}

/// The file's bytes with `from` in its header replaced by `to`.
fn changed(from: &str, to: &str) -> Vec<u8> {
    let bytes = manifold().to_bytes().unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header = std::str::from_utf8(&bytes[8..8 + length]).unwrap();
    assert!(header.contains(from), "no `{from}` in {header}");
    let header = header.replace(from, to);
    [&(header.len() as u64).to_le_bytes()[..], header.as_bytes(), &bytes[8 + length..]].concat()
}

#[test]
fn a_stored_manifold_comes_back() {
    let bytes = manifold().to_bytes().unwrap();
    assert_eq!(back(&bytes).unwrap(), manifold());
    assert_eq!(bytes, manifold().to_bytes().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/m.safetensors");
    atomic::write(&path, &bytes).unwrap();
    let (samples, metric, input) = manifold_file::read_samples(&path).unwrap();
    assert_eq!((samples, metric), (manifold().samples, Some(Metric::MILLIMETRE_PER_DEGREE)));
    assert!(input.path.ends_with("m.safetensors"));
    let csv = folder.path().join("p.csv");
    std::fs::write(&csv, format!("{HEADER}0,0,0,1,0,0,0\n0,0,1,1,0,0,0\n")).unwrap();
    assert_eq!(manifold_file::read_samples(&csv).unwrap().1, None);
}

#[test]
fn damaged_and_foreign_manifolds_are_refused() {
    let bytes = manifold().to_bytes().unwrap();
    refused(back(&[]), &["m.safetensors: expected a whole safetensors file, found header too small"]);
    refused(back(&bytes[..bytes.len() - 1]), &["a whole safetensors file"]);
    refused(back(&[&bytes[..], b"1"].concat()), &["a whole safetensors file"]);
    refused(back(&[&u64::MAX.to_le_bytes()[..], &bytes[8..]].concat()), &["a whole safetensors file", "large"]);
    refused(back(b"x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n"), &["a whole safetensors file"]);
    let mut flipped = bytes.clone();
    let last = flipped.len() - 3;
    flipped[last] ^= 1;
    refused(back(&flipped), &["tensor `poses`", "SHA-256", "damaged ones"]);

    refused(back(&changed("touchcal_manifold", "touchcal_network")), &["metadata", "entry `touchcal_manifold`"]);
    refused(back(&changed("\\\"schema\\\":1", "\\\"schema\\\":2")), &["metadata, schema", "schema 1", "found 2"]);
    refused(back(&changed("fixture_from_tool", "tool_from_fixture")), &["metadata, pose", "\"tool_from_fixture\""]);
    refused(back(&changed("roll_rad", "roll_deg")), &["metadata, columns", "roll_deg"]);
    refused(back(&changed("recorded\\\":81", "recorded\\\":3")), &["recorded", "at least the 20 samples", "found 3"]);
    refused(back(&changed("recorded\\\":81", "recorded\\\":-3")), &["metadata, touchcal_manifold"]);
    refused(back(&changed("spacing\\\":0.0005", "spacing\\\":-1.0")), &["metadata, spacing", "at least 0", "found -1"]);
    refused(
        back(&changed("metres_per_radian\\\":0.", "metres_per_radian\\\":-0.")),
        &["metres_per_radian", "positive"],
    );
    refused(back(&changed("\\\"spacing", "\\\"extra\\\":1,\\\"spacing")), &["unknown field `extra`"]);
    refused(back(&changed("\"poses\"", "\"weights\"")), &["tensor `poses`: expected one, found none"]);
    refused(back(&changed("[20,6]", "[6,20]")), &["F64 of shape [n, 6], found F64 of shape [6, 20]"]);
    refused(back(&changed("[20,6]", "[120]")), &["found F64 of shape [120]"]);
    refused(back(&changed("\"F64\"", "\"I64\"")), &["found I64"]);
    refused(back(&changed("[20,6]", "[9999999999999,6]")), &["a whole safetensors file"]);
}

#[test]
fn a_file_that_is_too_large_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.safetensors");
    std::fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
    let message = ManifoldFile::read_file(&path).unwrap_err().to_string();
    assert!(message.contains("huge.safetensors: expected at most"), "{message}");
}

#[test]
fn the_recorded_poses_are_a_manifold() {
    let path = support::data().join("mujoco_iiwa14/extrusion/offline/contact_poses.csv.gz");
    let (samples, _) = pose_file::read_file(&path).unwrap();
    assert_eq!(samples.len(), 81_000);
    let coverage = Coverage::of(&samples, Metric::MILLIMETRE_PER_DEGREE);
    // Contacts 1/300 s apart lie close together, while runs in other directions are millimetres
    // from each other.
    assert!((coverage.spacing.median - 0.093e-3).abs() < 1e-6, "{coverage:?}");
    assert!((coverage.unseen.median - 0.57e-3).abs() < 1e-5 && coverage.unseen.q95 > 3e-3, "{coverage:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = read(&bytes);
        let _ = read([HEADER.as_bytes(), &bytes].concat());
        let _ = read([&[0x1f, 0x8b][..], &bytes].concat());
        prop_assert!(back(&bytes).is_err());
        prop_assert!(back(&[&(bytes.len() as u64).to_le_bytes()[..], &bytes].concat()).is_err());
    }

    #[test]
    fn mutated_files_are_answered(at in 0..1700usize, cut in 0..8usize, with in prop::collection::vec(any::<u8>(), 0..5)) {
        let mut bytes = manifold().to_bytes().unwrap();
        let at = at % bytes.len();
        let end = (at + cut).min(bytes.len());
        bytes.splice(at..end, with.clone());
        // What is accepted is what was written, but for names.
        if let Ok(read) = back(&bytes) {
            prop_assert_eq!(read.samples, manifold().samples);
        }
        let mut text = format!("{HEADER}0,0,0,1,0,0,0\n0.5,0,0,0,1,0,0\n").into_bytes();
        let at = at % text.len();
        let end = (at + cut).min(text.len());
        text.splice(at..end, with);
        let _ = read(&text);
    }

    #[test]
    fn written_poses_are_read_exactly(rows in prop::collection::vec((-9.0..9.0f64, -9.0..9.0f64), 1..20)) {
        let text: String = rows.iter().map(|(a, b)| format!("{a},{b:e},{a},1,0,0,0\n")).collect();
        let poses = read(format!("{HEADER}{text}")).unwrap();
        let places: Vec<(f64, f64)> = poses.iter().map(|pose| (pose.translation.x, pose.translation.y)).collect();
        prop_assert_eq!(places, rows);
    }
}
