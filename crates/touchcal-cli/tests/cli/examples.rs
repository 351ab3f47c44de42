//! The examples at the end of each command's help run, with files of these names. That the command
//! line takes all of them is tested beside them, in `args/help.rs`.

use std::path::Path;

use super::manifold::demonstration;
use super::{data, stdout, touchcal};

/// Commands in an order in which each finds what it reads; `train` and `experiment` take minutes.
const ORDER: [&str; 13] = [
    "new",
    "demo",
    "simulate",
    "inspect",
    "select",
    "calibrate",
    "evaluate",
    "compare",
    "convert",
    "manifold",
    "completions",
    "man",
    "schema",
];
const LONG: [&str; 2] = ["train", "experiment"];

/// The examples of a command's help.
fn examples(folder: &Path, command: &str) -> Vec<String> {
    let help = stdout(&touchcal(folder, &[command, "--help"]).success());
    let (_, examples) = help.split_once("\nExamples:\n").unwrap();
    let joined = examples.replace("\\\n", "");
    joined.lines().filter_map(|line| line.strip_prefix("    touchcal ")).map(str::to_owned).collect()
}

/// Files that the examples name and no example writes.
fn prepare(folder: &Path) {
    demonstration(folder, "600");
    let (_, urdf) = touchcal::robot::builtin::ALL.iter().find(|(name, _)| *name == "iiwa14").unwrap();
    std::fs::write(folder.join("arm.urdf"), urdf).unwrap();
    std::fs::write(folder.join("scenario.toml"), "preset = \"paper\"\ncontacts = 300\n").unwrap();
    std::fs::write(folder.join("log.csv"), "q1,q2,q3,q4,q5,q6,q7\n0.1,0.2,0.3,0.4,0.5,0.6,0.7\n").unwrap();
    std::fs::write(folder.join("degrees.csv"), "10,20,30,40,50,60,70\n").unwrap();
    let pose = |k: u32| format!("{},0,0,1,0,0,0\n", f64::from(k) * 1e-3);
    let poses: String = (0..20).map(pose).collect();
    std::fs::write(folder.join("poses.csv"), format!("x,y,z,qw,qx,qy,qz\n{poses}")).unwrap();
    let logs = data().join("mukca/kuka_14/front");
    std::fs::create_dir_all(folder.join("logs/front")).unwrap();
    for (name, other) in [("hole_0.csv", "a.csv"), ("hole_1.csv", "b.csv")] {
        std::fs::copy(logs.join(name), folder.join("logs/front").join(name)).unwrap();
        std::fs::copy(logs.join(name), folder.join("logs").join(other)).unwrap();
    }
}

#[test]
fn examples_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    prepare(folder);
    for command in ORDER {
        if command == "compare" {
            std::fs::rename(folder.join("out"), folder.join("january")).unwrap();
            std::fs::rename(folder.join("fitted"), folder.join("march")).unwrap();
        }
        for example in examples(folder, command) {
            let words: Vec<&str> = example.split_whitespace().take_while(|word| *word != ">").collect();
            assert_eq!(words[0], command);
            touchcal(folder, &words).success();
        }
    }
    let help = stdout(&touchcal(folder, &["--help"]).success());
    let commands = help.split("\nCommands:\n").nth(1).unwrap().lines().take_while(|line| !line.is_empty());
    let names = commands.filter_map(|line| line.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty()));
    for name in names.filter(|name| *name != "help") {
        assert!(ORDER.contains(&name) || LONG.contains(&name), "{name}: no example was run");
    }
}
