//! Measured joint torques: columns of logs, keys of problems, compliances of URDFs.

use touchcal::contact::{ContactLog, TorqueOf};
use touchcal::estimate::Problem;
use touchcal::io::contact_csv;
use touchcal::io::contact_log::{self, Columns, Options};
use touchcal::io::problem_file;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{BACKLASH_TORQUE, JointLoad, KinematicParameter, Kinematics, calibrated};
use touchcal::se3::Pose;

use crate::support::refused;
use crate::support::small_arm::{ARM, arm};

fn options(of: TorqueOf) -> Options {
    Options { joint_torques: Some(of), ..Options::default() }
}

fn read(text: &str, options: &Options) -> Result<ContactLog, String> {
    let mut log = ContactLog::new(2);
    contact_csv::read(text.as_bytes(), "c.csv", &arm(), options, &mut log).map_err(|error| error.to_string())?;
    Ok(log)
}

#[test]
fn columns_are_found_by_name_or_number() {
    let renamed = |pairs: &[(&str, &str)]| Options {
        columns: pairs.iter().map(|(usual, name)| ((*usual).to_owned(), (*name).to_owned())).collect(),
        ..options(TorqueOf::Load)
    };
    for (text, options) in [
        ("q1,q2,tau_1,tau_2\n0.1,0.2,3,-4\n", options(TorqueOf::Load)),
        ("tau_sl,TAU_SH,q1,q2\n-4,3,0.1,0.2\n", options(TorqueOf::Load)),
        ("q1,q2,tau_1,tau_2\n0.1,0.2,-3,4\n", options(TorqueOf::Motor)),
        ("q1,q2,a,tau_2\n0.1,0.2,3,-4\n", renamed(&[("tau_1", "a")])),
        ("q1,q2,a,b\n0.1,0.2,3,-4\n", renamed(&[("tau_sh", "a"), ("tau_sl", "b")])),
    ] {
        let log = read(text, &options).expect(text);
        assert_eq!(log.joint_torques(0), Some(&[3.0, -4.0][..]), "{text}");
        assert!(log.has_joint_torques() && !log.has_loads() && log.joint_torques(1).is_none());
    }
    // Numbers are those of the columns of positions.
    let joints = Some(vec!["sl".to_owned(), "sh".to_owned()]);
    let log = read("q1,q2,tau_1,tau_2\n0.2,0.1,-4,3\n", &Options { joints, ..options(TorqueOf::Load) }).unwrap();
    assert_eq!((log.q(0), log.joint_torques(0)), (&[0.1, 0.2][..], Some(&[3.0, -4.0][..])));
    // Where they are not asked for, they are columns like any other.
    assert!(!read("q1,q2,tau_1,tau_2\n0.1,0.2,x,y\n", &Options::default()).unwrap().has_joint_torques());
}

#[test]
fn torques_stay_with_their_contacts() {
    let text = "q1,q2,tau_1,tau_2\n0.1,0.2,1,0\n0.1,0.2,2,0\n0.3,0.2,3,0\n";
    let log = read(text, &Options { apart: Some(0.1), ..options(TorqueOf::Load) }).unwrap();
    let first = |log: &ContactLog, i: usize| log.joint_torques(i).map(|torques| torques[0]);
    assert_eq!([0, 1].map(|i| first(&log, i)), [Some(1.0), Some(3.0)]);
    let mut both = read("q1,q2\n0.5,0.6\n", &Options::default()).unwrap();
    both.append(&log, 0);
    assert_eq!([0, 1, 2].map(|i| first(&both, i)), [None, Some(1.0), Some(3.0)]);
    assert_eq!(first(&both.filtered(|i| i == 2), 0), Some(3.0));
    let load = [1.0; 6];
    assert_eq!(both.load_on_joints(0, &load), JointLoad::OnTip(&load));
    assert_eq!(both.load_on_joints(1, &load), JointLoad::Torques(&[1.0, 0.0]));
    let names = ["q1", "q2", "tau_1", "tau_2"].map(str::to_owned);
    let value = |row: usize, column: usize| (row + column) as f64 / 10.0;
    let mut of_columns = ContactLog::new(2);
    let columns = Columns { names: &names, rows: 2, value: &value };
    contact_log::read_columns(&columns, "array", &arm(), &options(TorqueOf::Motor), &mut of_columns).unwrap();
    assert_eq!(of_columns.joint_torques(1), Some(&[-0.3, -0.4][..]));
}

#[test]
fn torques_that_lack_are_refused() {
    let asked = options(TorqueOf::Load);
    let lacks = read("q1,q2,tau_1\n0.1,0.2,3\n", &asked);
    refused(lacks, &["c.csv:1", "torque about every joint: `tau_sl` or `tau_2`", "`columns`", "q1,q2,tau_1"]);
    refused(read("0.1,0.2\n", &asked), &["c.csv:1", "a header", "joint torques", "no header"]);
    let broken = "q1,q2,tau_1,tau_2\n0.1,0.2,3,\n";
    refused(read(broken, &asked), &["c.csv:2", "column tau_2", "a number in N"]);
    let columns = [("tau_3".to_owned(), "a".to_owned())].into();
    refused(read("q1,q2,a\n0,0,0\n", &Options { columns, ..asked }), &["columns", "`tau_1`", "`tau_3`"]);
}

/// A problem of two logs with these lines in `[log]` and the tables of the logs, for a URDF.
fn problem(log: &str, tables: [&str; 2], urdf: &str) -> Result<Problem, String> {
    problem_with("", "\"joint_compliance\"", (log, tables), urdf)
}

/// The same with another block, and a line in `[estimate]`.
fn problem_with(line: &str, block: &str, (log, tables): (&str, [&str; 2]), urdf: &str) -> Result<Problem, String> {
    let folder = tempfile::tempdir().unwrap();
    let with = "q1,q2,fx,fy,fz,tx,ty,tz,tau_1,tau_2\n0.1,0.2,0,0,9,0,0,0,3,-4\n";
    std::fs::write(folder.path().join("a.csv"), with).unwrap();
    std::fs::write(folder.path().join("b.csv"), with.replace("0.1", "0.15")).unwrap();
    std::fs::write(folder.path().join("arm.urdf"), urdf).unwrap();
    let [a, b] = tables;
    let text = format!(
        "[robot]\nurdf = \"arm.urdf\"\n[tool]\nkind = \"ball\"\n[[fixture]]\nname = \"socket\"\nkind = \"socket\"\n\
         free = true\n[log]\n{log}\n[[contacts]]\nfile = \"a.csv\"\nfixture = \"socket\"\n{a}\n\
         [[contacts]]\nfile = \"b.csv\"\nfixture = \"socket\"\n{b}\n[estimate]\n{line}\nparameters = [{block}]\n"
    );
    let loaded = problem_file::read(&text, "problem.toml", folder.path()).map_err(|error| error.to_string())?;
    Ok(loaded.problem)
}

#[test]
fn a_problem_has_torques_of_all_its_logs_or_of_none() {
    for (key, sign) in [("tau_joint = \"load\"", 1.0), ("tau_joint = \"motor\"", -1.0)] {
        let problem = problem(key, ["", ""], ARM).unwrap();
        assert_eq!(problem.contacts.joint_torques(1), Some(&[3.0 * sign, -4.0 * sign][..]));
        assert!(problem.robot.has_measured_torques());
        // Masses are not needed.
        assert!(!problem.contacts.notes().iter().any(|note| note.contains("masses")), "{:?}", problem.contacts.notes());
    }
    let key = "tau_joint = \"load\"";
    refused(problem("", [key, ""], ARM), &["b.csv, tau_joint", "in each log or in none", "a log without"]);
    refused(problem("", [key, "held_out = true"], ARM), &["b.csv, tau_joint", "in each log or in none"]);
    let both = problem("load_on = \"tool\"", [key, key], ARM);
    refused(
        both,
        &[
            "problem.toml:",
            "contacts, tau_joint",
            "`tau_joint` or `load_on`",
            "both",
            "what a peg rests on is then found from gaps alone",
        ],
    );
    refused(problem("tau_joint = \"arm\"", ["", ""], ARM), &["problem.toml:", "`load` or `motor`"]);
}

/// Priors of half of the play of a turning and of a sliding joint, by their own keys; the URDF has
/// what they turn out to be, and the kinematics read from it.
#[test]
fn backlash_has_priors_and_its_place_in_the_urdf() {
    let sigmas = |prior: &str| {
        let problem = problem_with(prior, "\"joint_backlash\"", ("tau_joint = \"load\"", ["", ""]), ARM).unwrap();
        problem.parameters.iter().map(|p| p.prior_sigma().unwrap()).collect::<Vec<f64>>()
    };
    assert_eq!(sigmas(""), [0.01_f64.to_radians(), 1e-5]);
    let prior = "prior = { joint_backlash_deg = 0.05, joint_backlash_mm = 0.2 }";
    assert_eq!(sigmas(prior), [0.05_f64.to_radians(), 0.2e-3]);

    let robot = arm().with_measured_torques();
    let columns = [0, 1].map(KinematicParameter::JointBacklash);
    let loose = calibrated(&robot, &columns, &[1e-4, 2e-5]);
    let text = urdf::rewrite(ARM, &loose).unwrap();
    assert_eq!(text.matches("<touchcal_backlash half=").count(), 2);
    let back = urdf::read(&text, "arm.urdf", Ends::default()).unwrap();
    assert!(back.has_measured_torques() && back.is_compliant());
    assert_eq!(urdf::rewrite(&text, &back).unwrap(), text);
    let side = |torque: f64| torque / torque.hypot(BACKLASH_TORQUE);
    for torques in [[3.0, -4.0], [0.0, 0.1], [-1e3, 1e-9]] {
        let pose = |robot: &touchcal::robot::Robot, q: &[f64], load: JointLoad<'_>| {
            Kinematics::new(robot, &[], Pose::identity()).pose_under(q, load)
        };
        let found = pose(&back, &[0.1, 0.2], JointLoad::Torques(&torques));
        let expected = [0.1 + 1e-4 * side(torques[0]), 0.2 + 2e-5 * side(torques[1])];
        let expected = pose(&arm(), &expected, JointLoad::OnTip(&[0.0; 6]));
        assert!(touchcal::se3::log(&(found.inverse() * expected)).amax() < 1e-15, "{torques:?}");
    }
    for (from, to, parts) in [
        ("half=\"1e-4\"", "half=\"wide\"", ["joint `sh`, touchcal_backlash", "a finite number in `half`"]),
        ("half=\"1e-4\"", "", ["attribute `half` of <touchcal_backlash>", "none"]),
        ("type='revolute'", "type='fixed'", ["joint `sh`, touchcal_backlash", "a joint that moves"]),
    ] {
        assert!(text.contains(from), "{text}");
        let other = urdf::read(&text.replacen(from, to, 1), "arm.urdf", Ends::default());
        refused(other.map_err(|error| error.to_string()), &parts);
    }
}

/// Compliances that belong to measured torques say so in the URDF, and need torques then.
#[test]
fn compliances_of_a_urdf_may_belong_to_measured_torques() {
    let robot = arm().with_measured_torques();
    let bent = calibrated(&robot, &[KinematicParameter::JointCompliance(0)], &[1e-4]);
    let text = urdf::rewrite(ARM, &bent).unwrap();
    assert_eq!(text.matches("torque=\"measured\"").count(), 1);
    let back = urdf::read(&text, "arm.urdf", Ends::default()).unwrap();
    assert!(back.is_compliant() && back.has_measured_torques());
    assert_eq!(urdf::rewrite(&text, &back).unwrap(), text);
    // Gravity does not deflect these joints.
    let pose = |robot: &touchcal::robot::Robot, load: JointLoad<'_>| {
        Kinematics::new(robot, &[], Pose::identity()).pose_under(&[0.1, 0.2], load)
    };
    let none = JointLoad::OnTip(&[0.0; 6]);
    assert_eq!(pose(&back, none), pose(&arm(), none));
    assert_ne!(pose(&back, JointLoad::Torques(&[3.0, -4.0])), pose(&arm(), none));
    // From compliances by gravity to such by measured torques.
    let by_gravity =
        urdf::rewrite(ARM, &calibrated(&arm(), &[KinematicParameter::JointCompliance(0)], &[1e-4])).unwrap();
    assert!(!by_gravity.contains("measured"));
    let measured = urdf::rewrite(&by_gravity, &bent).unwrap();
    assert_eq!(urdf::read(&measured, "arm.urdf", Ends::default()).unwrap(), back);

    assert!(problem("tau_joint = \"load\"", ["", ""], &text).is_ok());
    refused(problem("", ["", ""], &text), &["a.csv, tau_joint", "the compliances of the URDF", "without `tau_joint`"]);
    let other = urdf::read(&text.replacen("\"measured\"", "\"felt\"", 1), "arm.urdf", Ends::default());
    refused(other.map_err(|error| error.to_string()), &["touchcal_compliance, torque", "`measured`", "\"felt\""]);
}
