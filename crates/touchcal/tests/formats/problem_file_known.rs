//! How well problem files say that places, shapes and distances are known: defaults, `exact`,
//! standard deviations, and the notes about them.

use touchcal::estimate::{
    DEFAULT_DISTANCE_SIGMA, EXACT_DISTANCE_SIGMA, PlacePrior, Problem, ShapeTolerance, TrendVariable, WrenchTolerance,
};
use touchcal::parameter::Parameter;

use super::problem_file::{BALL, FULL, POSES, folder, read, read_in, refused};

/// The problem in which `lines` stand in the table of the hole, the plane or the distance.
fn with(table: &str, lines: &str) -> Problem {
    read(&changed(table, lines)).unwrap().problem
}

fn changed(table: &str, lines: &str) -> String {
    let at = match table {
        "tool" => "length_mm = 40\nsigma_mm = 0.1\nsigma_deg = 0.5",
        "hole" => "depth_mm = 30",
        "table" => "base_from_fixture = { xyz_mm = [0, 0, 10] }",
        _ => "mm = 50\nsigma_mm = 0.1",
    };
    let kept = at.lines().next().unwrap();
    assert!(FULL.contains(at), "{at}");
    FULL.replacen(at, &format!("{kept}\n{lines}"), 1)
}

/// What the notes say beyond those of the logs.
fn notes(problem: &Problem) -> Vec<&str> {
    let notes = problem.contacts.notes().iter().map(String::as_str);
    notes.filter(|note| note.contains("standard deviations")).collect()
}

fn gaussian(sigma_mm: f64, sigma_deg: f64) -> PlacePrior {
    PlacePrior::Gaussian { sigma: sigma_mm * 1e-3, sigma_angle: sigma_deg * std::f64::consts::PI / 180.0 }
}

#[test]
fn nothing_is_exact_by_default() {
    let problem = with("tool", "");
    assert_eq!((problem.tool.prior, PlacePrior::DEFAULT_TOOL), (PlacePrior::DEFAULT_TOOL, gaussian(0.3, 0.2)));
    assert_eq!(PlacePrior::DEFAULT_FIXTURE, gaussian(1.0, 0.5));
    for fixture in &problem.fixtures {
        assert_eq!(fixture.prior, PlacePrior::DEFAULT_FIXTURE, "{}", fixture.name);
    }
    assert_eq!(
        problem.fixtures[0].tolerance,
        ShapeTolerance { clearance: 0.03e-3, depth: 0.03e-3, edge_radius: 0.05e-3 }
    );
    assert_eq!(problem.fixtures[1].tolerance, ShapeTolerance::EXACT);
    assert_eq!(with("distance", "").distances[0].sigma, DEFAULT_DISTANCE_SIGMA);
    assert_eq!(DEFAULT_DISTANCE_SIGMA, 0.1e-3);
}

#[test]
fn exact_is_all_of_a_table_or_the_listed_parts() {
    let tolerance = |lines: &str| with("hole", lines).fixtures[0].tolerance;
    let prior = |lines: &str| with("hole", lines).fixtures[0].prior;
    let default = ShapeTolerance::DEFAULT;
    for (lines, place, expected) in [
        ("exact = true", true, ShapeTolerance::EXACT),
        ("exact = false", false, default),
        ("exact = []", false, default),
        ("exact = [\"place\"]", true, default),
        ("exact = [\"outline\"]", false, default),
        ("exact = [\"clearance\"]", false, ShapeTolerance { clearance: 0.0, ..default }),
        ("exact = [\"place\", \"depth\"]", true, ShapeTolerance { depth: 0.0, ..default }),
        ("exact = [\"edge_radius\"]", false, ShapeTolerance { edge_radius: 0.0, ..default }),
    ] {
        assert_eq!(prior(lines) == PlacePrior::Fixed, place, "{lines}");
        assert_eq!(tolerance(lines), expected, "{lines}");
    }
    for lines in ["exact = true", "exact = [\"place\", \"outline\"]"] {
        assert_eq!(with("tool", lines).tool.prior, PlacePrior::Fixed, "{lines}");
    }
    assert_eq!(with("tool", "exact = [\"outline\"]").tool.prior, PlacePrior::DEFAULT_TOOL);
    assert_eq!(with("table", "exact = [\"place\"]").fixtures[1].prior, PlacePrior::Fixed);
    for lines in ["exact = true", "exact = [\"length\"]", "sigma_mm = 0"] {
        assert_eq!(with("distance", lines).distances[0].sigma, EXACT_DISTANCE_SIGMA, "{lines}");
    }
}

#[test]
fn exact_is_a_truth_value_or_a_list_of_names() {
    #[track_caller]
    fn refused_in(table: &str, lines: &str, parts: &[&str]) {
        let message = read(&changed(table, lines)).expect_err(lines);
        for part in parts {
            assert!(message.contains(part), "expected `{part}` in: {message}");
        }
    }
    let hole = "a list of what is exact (`place`, `outline`, `clearance`, `depth` or `edge_radius`)";
    refused_in(
        "hole",
        "exact = [\"palce\"]",
        &[
            "problem.toml:20:9, fixture `hole`, exact",
            "true, false, or",
            hole,
            "found \"palce\"; did you mean `place`?",
        ],
    );
    refused_in("hole", "exact = \"place\"", &["problem.toml:20:9, fixture `hole`, exact", hole, "found string"]);
    refused_in("hole", "exact = 1", &["found integer"]);
    refused_in("hole", "exact = [1]", &["fixture `hole`, exact", "found integer"]);
    refused_in("table", "exact = [\"depth\"]", &["fixture `table`, exact", "exact (`place`), found \"depth\""]);
    refused_in("tool", "exact = [\"depth\"]", &["problem.toml:11:9, tool, exact", "(`place` or `outline`)"]);
    refused_in("distance", "exact = [\"lenght\"]", &["distance, exact", "did you mean `length`?"]);
    refused_in("hole", "exat = true", &["unknown field `exat`", "did you mean `exact`?"]);
}

#[test]
fn what_contradicts_itself_is_refused() {
    let both = |table: &str, lines: &str, part: &str| {
        let message = read(&changed(table, lines)).expect_err(lines);
        assert!(message.contains(part) && message.ends_with("found both"), "expected `{part}` in: {message}");
    };
    both("hole", "exact = true\nsigma_mm = 1", "problem.toml:21:12, fixture `hole`: expected exact or standard");
    both("hole", "exact = [\"place\"]\nsigma_deg = 1", "problem.toml:21:13, fixture `hole`: expected exact or");
    both("tool", "exact = true\nsigma_mm = 1", "tool: expected exact or standard deviations above 0");
    both("hole", "exact = true\nfree = true", "fixture `hole`: expected free or exact");
    both("hole", "free = true\nsigma_mm = 0", "fixture `hole`: expected free or standard deviations");
    both(
        "hole",
        "exact = true\nclearance_sigma_mm = 0.1",
        "problem.toml:21:22, fixture `hole`, clearance_sigma_mm: expected clearance_sigma_mm or `exact` with \"clearance\"",
    );
    both("hole", "exact = [\"depth\"]\ndepth_sigma_mm = 0.1", "depth_sigma_mm or `exact` with \"depth\"");
    both("distance", "sigma_mm = 0.1\nexact = true", "distance, sigma_mm: expected sigma_mm or exact");
    // Of 0 says the same.
    let problem = with(
        "hole",
        "exact = true\nsigma_mm = 0\nsigma_deg = 0\nclearance_sigma_mm = 0\ndepth_sigma_mm = 0\nedge_radius_sigma_mm = 0",
    );
    assert_eq!((problem.fixtures[0].prior, problem.fixtures[0].tolerance), (PlacePrior::Fixed, ShapeTolerance::EXACT));
    // A free place may have an exact shape.
    let problem = with("hole", "free = true\nexact = [\"clearance\", \"depth\", \"edge_radius\"]");
    assert_eq!((problem.fixtures[0].prior, problem.fixtures[0].tolerance), (PlacePrior::Flat, ShapeTolerance::EXACT));
    refused("depth_mm = 30", "depth_mm = 30\nclearance_sigma_mm = -1", &["clearance_sigma_mm", "at least 0"]);
}

#[test]
fn only_a_hole_has_a_shape_that_may_be_uncertain() {
    for key in ["clearance_sigma_mm", "depth_sigma_mm"] {
        let part = format!("`{key}`");
        refused(
            "kind = \"socket\"\nfree = true",
            &format!("kind = \"socket\"\nfree = true\n{key} = 0.1"),
            &["fixture `front/0`", "what belongs to a socket", &part],
        );
        refused("kind = \"plane\"", &format!("kind = \"plane\"\n{key} = 0.1"), &["what belongs to a plane", &part]);
    }
}

#[test]
fn one_standard_deviation_leaves_the_default_of_the_other() {
    let problem = with("tool", "sigma_mm = 2");
    assert_eq!(problem.tool.prior, gaussian(2.0, 0.2));
    assert!(notes(&problem)[0].contains("tool: place ± 2 mm, 0.2°;"), "{:?}", notes(&problem));
    assert_eq!(with("hole", "sigma_deg = 2").fixtures[0].prior, gaussian(1.0, 2.0));
    assert_eq!(with("hole", "sigma_mm = 0").fixtures[0].prior, gaussian(0.0, 0.5));
    let problem = with("hole", "depth_sigma_mm = 0.2");
    assert_eq!(problem.fixtures[0].tolerance, ShapeTolerance { depth: 0.2e-3, ..ShapeTolerance::DEFAULT });
    let problem = with("hole", "edge_radius_sigma_mm = 0.2");
    assert_eq!(problem.fixtures[0].tolerance, ShapeTolerance { edge_radius: 0.2e-3, ..ShapeTolerance::DEFAULT });
    let problem = with("hole", "depth_sigma_mm = 0.2");
    let note = notes(&problem)[0];
    assert!(note.contains("fixture `hole`: clearance ± 0.03 mm;") && !note.contains("depth ±"), "{note}");
}

#[test]
fn what_is_assumed_is_told() {
    let told = |problem: &Problem| notes(problem).into_iter().map(str::to_owned).collect::<Vec<_>>();
    let keys =
        "declare them (sigma_mm, sigma_deg, clearance_sigma_mm, depth_sigma_mm, edge_radius_sigma_mm, or exact = true)";
    let found = told(&read(&changed("tool", "").replace("mm = 50\nsigma_mm = 0.1", "mm = 50")).unwrap().problem);
    let expected = format!(
        "assumed, since no standard deviations are declared: tool: place ± 0.3 mm, 0.2°; \
         fixture `hole`: place ± 1 mm, 0.5°; fixture `hole`: clearance ± 0.03 mm; fixture `hole`: depth ± 0.03 mm; \
         fixture `hole`: edge radius ± 0.05 mm; fixture `table`: place ± 1 mm, 0.5°; distance hole–table: ± 0.1 mm; {keys}"
    );
    assert_eq!(found, [expected]);
    // With everything declared nothing is said.
    let declared = FULL.replace("depth_mm = 30", "depth_mm = 30\nexact = true").replace(
        "base_from_fixture = { xyz_mm = [0, 0, 10] }",
        "base_from_fixture = { xyz_mm = [0, 0, 10] }\nexact = true",
    );
    assert_eq!(told(&read(&declared).unwrap().problem), [""; 0]);
    // The rotation of a point is nothing; its position is declared.
    let point =
        declared.replace("kind = \"peg\"\n", "kind = \"ball\"\nradius_mm = 3\n").replace("length_mm = 40\n", "");
    let socket = point[..point.find("[[fixture]]\nname = \"hole\"").unwrap()].replace("outline = \"peg.csv\"\n", "");
    let socket = socket.replace("sigma_deg = 0.5\n", "")
        + "[[fixture]]\nname = \"s\"\nkind = \"socket\"\nbase_from_fixture = { xyz_mm = [600, 0, 0] }\n\
           [[contacts]]\nfile = \"log.csv\"\nfixture = \"s\"\n[estimate]\nparameters = [\"strain\"]\n";
    let found = told(&read(&socket).unwrap().problem);
    assert_eq!(
        found,
        [format!("assumed, since no standard deviations are declared: fixture `s`: place ± 1 mm; {keys}")]
    );
    // Nor is it exact by a standard deviation of 0.
    let zero = socket.replace("sigma_mm = 0.1\n", "sigma_mm = 0.1\nsigma_deg = 0\n");
    assert_eq!(told(&read(&zero).unwrap().problem), found);
    // The shape of a hole that is known by samples is not assumed.
    let folder = folder();
    std::fs::write(folder.path().join("poses.csv"), POSES).unwrap();
    let nearest = FULL.replace("depth_mm = 30", "manifold = \"nearest\"\nsamples = \"poses.csv\"");
    let found = told(&read_in(folder.path(), &nearest).unwrap().problem);
    assert!(found[0].contains("fixture `hole`: place") && !found[0].contains("clearance ±"), "{found:?}");
}

#[test]
fn standard_deviations_of_0_are_exact_and_told() {
    let zero = |table: &str, lines: &str, part: &str| {
        let problem = with(table, lines);
        let expected = format!("standard deviations of 0 are taken as exact: {part}");
        assert_eq!(notes(&problem).last(), Some(&expected.as_str()), "{lines}");
        problem
    };
    assert_eq!(zero("tool", "sigma_mm = 0\nsigma_deg = 0", "tool").tool.prior, PlacePrior::Fixed);
    let problem = zero(
        "hole",
        "sigma_mm = 0\nsigma_deg = 0\nclearance_sigma_mm = 0",
        "fixture `hole`, fixture `hole`: clearance",
    );
    assert_eq!(problem.fixtures[0].prior, PlacePrior::Fixed);
    assert_eq!(problem.fixtures[0].tolerance, ShapeTolerance { clearance: 0.0, ..ShapeTolerance::DEFAULT });
    assert_eq!(zero("distance", "sigma_mm = 0", "distance hole–table").distances[0].sigma, EXACT_DISTANCE_SIGMA);
}

#[test]
fn bias_and_scale_of_the_wrench_are_declared_or_assumed() {
    let changed = |noise: &str, load: &str, blocks: &str| {
        let text = FULL.replacen("[noise]", &format!("[noise]\n{noise}"), 1).replacen("debounce = 1", load, 1);
        let problem = read(&text.replacen("\"strain\", ", blocks, 1)).unwrap().problem;
        let notes = problem.contacts.notes().iter().filter(|note| note.contains("wrench"));
        (problem.wrench, notes.cloned().collect::<Vec<_>>())
    };
    let (load, blocks) = ("debounce = 1\nload_on = \"tool\"", "\"strain\", \"joint_compliance\", ");
    let (wrench, notes) = changed("", load, blocks);
    assert_eq!(wrench, WrenchTolerance::DEFAULT);
    let expected = "assumed, since no standard deviations are declared: wrench: bias of the forces ± 0.5 N; \
        wrench: bias of the moments ± 0.05 N m; wrench: noise of the forces ± 0.1 N; \
        wrench: noise of the moments ± 0.005 N m; wrench: scale ± 2 %; \
        declare them (force_bias_n, torque_bias_nm, force_noise_n, torque_noise_nm, wrench_scale in [noise])";
    assert_eq!(notes, [expected]);
    let (wrench, notes) = changed("force_bias_n = 0\nwrench_scale = 0.05", load, blocks);
    assert_eq!(wrench, WrenchTolerance { force: 0.0, scale: 0.05, ..WrenchTolerance::DEFAULT });
    assert!(notes[0].contains("declared: wrench: bias of the moments ± 0.05 N m; wrench: noise"), "{notes:?}");
    assert_eq!(notes[1], "standard deviations of 0 are taken as exact: wrench: bias of the forces");
    let all =
        "force_bias_n = 1\ntorque_bias_nm = 0.1\nforce_noise_n = 0.3\ntorque_noise_nm = 0.02\nwrench_scale = 0.01";
    let expected = WrenchTolerance { force: 1.0, torque: 0.1, scale: 0.01, force_noise: 0.3, torque_noise: 0.02 };
    assert_eq!(changed(all, load, blocks), (expected, vec![]));
    // Where no joint deflects under a load there is nothing to assume, and nothing to declare.
    assert_eq!(changed("", "debounce = 1", blocks).1, [""; 0]);
    let (_, notes) = changed("torque_bias_nm = 0.1", "debounce = 1", blocks);
    assert_eq!(
        notes,
        [
            "force_bias_n, torque_bias_nm, force_noise_n, torque_noise_nm, wrench_scale in [noise]: no joint deflects under a load, so that they change nothing"
        ]
    );
    refused("[noise]", "[noise]\nforce_bias_n = -1", &["problem.toml:", "noise, force_bias_n", "at least 0"]);
    refused(
        "[noise]",
        "[noise]\nwrench_scale = \"2 %\"",
        &["problem.toml:", "expected a number, found the text \"2 %\""],
    );
}

#[test]
fn estimated_places_without_standard_deviations_are_free() {
    let problem = read(BALL).unwrap().problem;
    assert_eq!((problem.tool.prior, problem.fixtures[1].prior), (PlacePrior::Flat, PlacePrior::Flat));
    assert_eq!(notes(&problem), [""; 0]);
    let estimated = |blocks: &str, lines: &str| {
        let text = changed("hole", lines).replace("sigma_mm = 0.1\nsigma_deg = 0.5\n", "");
        read(&text.replace("\"strain\", ", &format!("\"strain\", {blocks}, "))).unwrap().problem
    };
    let problem = estimated("\"tool\"", "");
    assert_eq!((problem.tool.prior, problem.fixtures[0].prior), (PlacePrior::Flat, PlacePrior::DEFAULT_FIXTURE));
    let problem = estimated("\"fixture\"", "");
    assert_eq!((problem.tool.prior, problem.fixtures[0].prior), (PlacePrior::DEFAULT_TOOL, PlacePrior::Flat));
    // Its shape is no place.
    assert_eq!(problem.fixtures[0].tolerance, ShapeTolerance::DEFAULT);
    for (lines, prior) in [("sigma_mm = 2", gaussian(2.0, 0.5)), ("exact = true", PlacePrior::Fixed)] {
        assert_eq!(estimated("\"fixture\"", lines).fixtures[0].prior, prior, "{lines}");
    }
}

#[test]
fn changes_of_encoders_over_the_log_are_estimated_where_asked_for() {
    let read = |noise: &str, blocks: &str| {
        let text = FULL.replace("[noise]\n", &format!("[noise]\n{noise}\n"));
        read(&text.replace("\"strain\", ", &format!("\"strain\", {blocks}"))).map(|read| read.problem)
    };
    let sigmas = |noise: &str, blocks: &str, block: &str| -> Vec<f64> {
        let parameters = read(noise, blocks).unwrap().parameters;
        let of_block = parameters.iter().filter(|parameter| parameter.name.starts_with(block));
        of_block.filter_map(Parameter::prior_sigma).collect()
    };
    assert_eq!(sigmas("", "\"joint_trend\", ", "joint_trend.").len(), 7);
    assert_eq!(sigmas("", "", "joint_walk."), [0.0; 0]);
    assert_eq!(sigmas("encoder_walk_deg = 0", "", "joint_walk."), [0.0; 0]);
    // Eleven cosines for each of seven joints, the first of √2/(2π) of the walk.
    for (noise, blocks, walk) in [("encoder_walk_deg = 0.1", "", 0.1f64), ("", "\"joint_walk\", ", 0.02)] {
        let found = sigmas(noise, blocks, "joint_walk.");
        assert_eq!(found.len(), 77);
        assert!((found[0] - walk.to_radians() / (2.0f64.sqrt() * std::f64::consts::PI)).abs() < 1e-12, "{found:?}");
    }
    assert_eq!(sigmas("", "\"joint_harmonic\", ", "joint_harmonic."), [0.05_f64.to_radians(); 14]);
    assert_eq!(sigmas("", "\"joint_harmonic_2\", ", "joint_harmonic_2."), [0.02_f64.to_radians(); 14]);
    assert_eq!(sigmas("", "\"joint_gear_ratio\", ", "joint_gear_ratio."), [1e-4; 7]);
    assert_eq!(sigmas("", "\"joint_backlash\", ", "joint_backlash."), [0.01_f64.to_radians(); 7]);
    let error = read("encoder_walk_deg = 0", "\"joint_walk\", ").unwrap_err().to_string();
    assert!(error.contains("`encoder_walk_deg` is 0"), "{error}");
}

#[test]
fn encoders_that_change_with_temperature_need_one_for_each_contact() {
    let folder = folder();
    for file in ["log.csv", "deg.csv"] {
        let path = folder.path().join(file);
        let log = std::fs::read_to_string(&path).unwrap();
        let line =
            |(i, line): (usize, &str)| if i == 0 { format!("{line},T\n") } else { format!("{line},{}\n", 20 + i) };
        std::fs::write(path, log.lines().enumerate().map(line).collect::<String>()).unwrap();
    }
    let over = |over: &str, columns: usize| {
        let text = FULL.replace("[noise]\n", &format!("[noise]\nencoder_trend_over = {over:?}\n"));
        read_in(folder.path(), &text.replacen("[[contacts]]\n", "[[contacts]]\ntemperature = \"T\"\n", columns))
    };
    let error = over("temperature", 1).unwrap_err();
    for part in ["noise, encoder_trend_over", "`temperature` in [[contacts]]", "1 contacts without"] {
        assert!(error.contains(part), "{error}");
    }
    let problem = over("temperature", 2).unwrap().problem;
    assert_eq!(problem.trend_variable, TrendVariable::Temperature);
    assert_eq!([problem.contacts.temperature(0), problem.contacts.temperature(1)], [Some(21.0); 2]);
    assert_eq!(over("log", 0).unwrap().problem.trend_variable, TrendVariable::Log);
    assert!(over("time", 0).unwrap_err().contains("`log` or `temperature`"));
}

#[test]
fn a_load_that_changes_nothing_is_noted() {
    let notes = |text: &str| {
        let problem = read(text).unwrap().problem;
        problem.contacts.notes().iter().filter(|note| note.starts_with("load_on:")).count()
    };
    // A hole: the load says which of its surfaces are touched.
    assert_eq!(notes(&FULL.replacen("debounce = 1", "debounce = 1\nload_on = \"tool\"", 1)), 0);
    // A socket and a plane, which a ball touches at one place.
    let columns = "fixture = \"front/0\"\n[estimate]";
    let loaded = "fixture = \"front/0\"\nforce_threshold_n = 3\nload_on = \"tool\"\n[estimate]";
    let text = BALL.replacen(columns, loaded, 1).replacen("panda.csv", "log.csv", 1);
    assert_eq!(notes(&text), 1);
    let flexible = text.replacen("\"fixture\"]", "\"fixture\", \"joint_compliance\"]", 1);
    assert_eq!(notes(&flexible), 0);
}

#[test]
fn a_copy_of_a_log_is_noted() {
    let folder = folder();
    let log = |name: &str, time: u32| {
        let rows = (0..12).map(|k| format!("{},{},0,0,1,0,0,0\n", time + k, 0.01 * f64::from(k)));
        let text = format!("t,q1,q2,q3,q4,q5,q6,q7\n{}", rows.collect::<String>());
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    let contacts = FULL.split_once("[[contacts]]").unwrap().1.split_once("[noise]").unwrap().0;
    let two = "\nfile = \"a.csv\"\nfixture = \"hole\"\n[[contacts]]\nfile = \"b.csv\"\nfixture = \"hole\"\n";
    let text = FULL.replacen(contacts, two, 1);
    let notes = |time: u32, more: &str| {
        log("a.csv", 0);
        log("b.csv", time);
        let problem =
            read_in(folder.path(), &text.replacen("\"b.csv\"", &format!("\"b.csv\"{more}"), 1)).unwrap().problem;
        problem.contacts.notes().iter().filter(|note| note.starts_with("12 of 24 contacts have")).count()
    };
    // The same rows count once; with another time they are a copy, held out or not.
    assert_eq!(notes(0, ""), 0);
    assert_eq!((notes(100, ""), notes(100, "\nheld_out = true")), (1, 1));
}
