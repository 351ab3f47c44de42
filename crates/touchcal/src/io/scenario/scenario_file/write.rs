//! A scenario as text, and the tables that it shares with the problem it poses.

use std::fmt::Write;

use super::read::ScenarioFile;
use crate::estimate::ShapeTolerance;
use crate::geometry::{Parts, Polygon, PrismPair};
use crate::io::base::toml_text::{number, quoted};
use crate::robot::{GRAVITY, JointKind};
use crate::se3::Pose;
use crate::sim::{ArmErrors, PlaceError, Scenario, Thermal, Touch};

/// Name and content of a text file to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct TextFile {
    /// Name of the file within its folder.
    pub name: String,
    /// Content of the file.
    pub text: String,
}

impl TextFile {
    pub(super) fn new(name: impl Into<String>, text: impl Into<String>) -> TextFile {
        TextFile { name: name.into(), text: text.into() }
    }
}

/// Name of the scenario file in the folder of a simulation or campaign.
pub const SCENARIO: &str = "scenario.toml";
/// Name of the robot's URDF beside the files that refer to it.
const URDF: &str = "robot.urdf";
/// Name of the tool's outline.
const PEG: &str = "peg.csv";

/// The text of `scenario.toml` with every key and numbers of twelve digits, as
/// [`read`](super::read) takes it, preceded by the files that it refers to: the URDF of an arm that
/// is not built in, and the outlines of parts. The scenario file is the last.
pub fn scenario_text(file: &ScenarioFile) -> Vec<TextFile> {
    let scenario = &file.scenario;
    let mut files = Vec::new();
    let mut text =
        String::from("# What was simulated. Lengths are in mm, angles in degrees, as the keys say.\nschema = 1\n");
    let mut line = Lines(&mut text);
    line.number("contacts", scenario.contacts as f64);
    line.number("friction", scenario.friction);
    line.number("contact_mm", 1e3 * scenario.contact_sigma);
    let robot = robot_text(file, &mut files);
    line.0.push_str(&robot);
    errors_text(&scenario.errors, &mut line);
    let tool = tool_text(scenario, &mut files);
    line.0.push_str(&tool);
    line.sigmas(scenario.tool_error);
    for touch in &scenario.touches {
        line.touch(scenario, touch, &mut files);
    }
    for distance in &scenario.distances {
        line.between(scenario, distance.between);
        line.number("sigma_mm", 1e3 * distance.sigma);
    }
    line.table("[stiffness]");
    line.number("n_per_m", scenario.stiffness.translation);
    line.number("nm_per_rad", scenario.stiffness.rotation);
    let recorder = &scenario.recorder;
    line.table("[recorder]");
    line.number("rate_hz", recorder.rate);
    line.number("encoder_deg", recorder.encoder_sigma.to_degrees());
    line.number("encoder_step_deg", recorder.encoder_step.to_degrees());
    line.number("encoder_trend_deg", recorder.encoder_trend.to_degrees());
    line.number("warm_up_k", recorder.warm_up);
    line.number("encoder_walk_deg", recorder.encoder_walk.to_degrees());
    line.number("force_lag_s", recorder.force_lag);
    line.number("force_sigma_n", recorder.force_sigma);
    line.number("torque_sigma_nm", recorder.torque_sigma);
    line.number("force_bias_n", recorder.force_bias);
    line.number("torque_bias_nm", recorder.torque_bias);
    line.number("wrench_scale", recorder.wrench_scale);
    line.number("tau_joint_sigma_nm", recorder.joint_torque_sigma);
    line.number("force_threshold_n", recorder.force_threshold);
    line.number("missed", recorder.missed);
    line.number("spurious", recorder.spurious);
    let thermal = scenario.thermal.unwrap_or(Thermal::NONE);
    line.table("[thermal]");
    line.number("expansion_per_k", thermal.expansion);
    line.number("reference_c", thermal.reference);
    line.number("sensor_sigma_k", thermal.sensor_sigma);
    files.push(TextFile::new(SCENARIO, text));
    files
}

/// The table of the errors.
fn errors_text(errors: &ArmErrors, line: &mut Lines<'_>) {
    line.table("[errors]");
    line.text("distribution", errors.distribution.name());
    line.number("strain", errors.strain);
    line.number("segment_strain", errors.segment_strain);
    line.number("joint_offset_deg", errors.joint_offset.to_degrees());
    line.number("origin_mm", 1e3 * errors.origin_length);
    line.number("origin_deg", errors.origin_angle.to_degrees());
    line.number("origin_zero_deg", errors.origin_zero.to_degrees());
    line.number("joint_compliance_rad_per_nm", errors.joint_compliance);
    line.number("joint_backlash_deg", errors.joint_backlash.to_degrees());
    line.number("joint_harmonic_deg", errors.joint_harmonic.to_degrees());
    line.number("joint_harmonic_2_deg", errors.joint_harmonic_2.to_degrees());
    line.number("joint_gear_ratio", errors.joint_gear_ratio);
}

fn in_user_units(scenario: &Scenario, posture: &[f64]) -> Vec<String> {
    let unit = |kind| if kind == JointKind::Prismatic { 1e3 } else { 1f64.to_degrees() };
    scenario.robot.moving().zip(posture).map(|(joint, q)| number(unit(joint.kind) * q)).collect()
}

/// Lines `key = value` of a file.
pub(super) struct Lines<'a>(pub(super) &'a mut String);

impl Lines<'_> {
    /// The table of a fixture.
    fn touch(&mut self, scenario: &Scenario, touch: &Touch, files: &mut Vec<TextFile>) {
        let fixture = fixture_text(scenario, touch, files);
        self.0.push_str(&fixture);
        self.place(touch);
        self.sigmas(touch.place_error);
        if touch.free {
            self.0.push_str("free = true\n");
        }
        self.number("clearance_sigma_mm", 1e3 * touch.clearance_sigma);
        self.number("depth_sigma_mm", 1e3 * touch.depth_sigma);
        self.number("unequal_clearance_sigma_mm", 1e3 * touch.unequal_clearance_sigma);
        self.number("edge_wear_mm", 1e3 * touch.edge_wear);
        self.number("edge_radius_sigma_mm", 1e3 * touch.edge_radius_sigma);
        let posture = |posture: &Vec<f64>| format!("[{}]", in_user_units(scenario, posture).join(", "));
        let postures: Vec<String> = touch.postures.iter().map(posture).collect();
        self.raw("postures_deg", &format!("[{}]", postures.join(", ")));
        let exploration = &touch.exploration;
        let keys = [
            ("radius_mm", 1e3 * exploration.radius),
            ("tilt_deg", exploration.tilt.to_degrees()),
            ("press_mm", 1e3 * exploration.press),
            ("lift_mm", 1e3 * exploration.lift),
            ("swing_deg", exploration.swing.to_degrees()),
            ("pace", exploration.pace),
        ];
        let mut keys: Vec<String> = keys.iter().map(|(key, value)| format!("{key} = {}", number(*value))).collect();
        keys.push(format!("random_phases = {}", exploration.random_phases));
        self.raw("exploration", &format!("{{ {} }}", keys.join(", ")));
    }

    pub(super) fn raw(&mut self, key: &str, value: &str) {
        // Writing to a String cannot fail.
        let written = writeln!(self.0, "{key} = {value}");
        debug_assert!(written.is_ok());
    }

    pub(super) fn number(&mut self, key: &str, value: f64) {
        self.raw(key, &number(value));
    }

    pub(super) fn text(&mut self, key: &str, value: &str) {
        self.raw(key, &quoted(value));
    }

    pub(super) fn table(&mut self, name: &str) {
        self.0.push('\n');
        self.0.push_str(name);
        self.0.push('\n');
    }

    /// A table `[[distance]]` with the two fixtures that it is between.
    pub(super) fn between(&mut self, scenario: &Scenario, (first, second): (usize, usize)) {
        let names = [first, second].map(|fixture| quoted(&scenario.touches[fixture].name));
        self.table("[[distance]]");
        self.raw("between", &format!("[{}]", names.join(", ")));
    }

    pub(super) fn place(&mut self, touch: &Touch) {
        self.raw("base_from_fixture", &pose(&touch.base_from_fixture));
    }

    /// How well a place is known, unless it is unknown, and the shape of a hole; what is exact says
    /// so.
    pub(super) fn tolerances(&mut self, place: Option<PlaceError>, shape: Option<ShapeTolerance>) {
        let is_exact_place = place == Some(PlaceError::default());
        if let Some(error) = place.filter(|_| !is_exact_place) {
            self.sigmas(error);
        }
        let mut exact = Vec::from_iter(is_exact_place.then_some("place"));
        let ShapeTolerance { clearance, depth, edge_radius } = shape.unwrap_or(ShapeTolerance::EXACT);
        for (name, sigma) in [("clearance", clearance), ("depth", depth), ("edge_radius", edge_radius)] {
            match shape {
                None => {}
                Some(_) if sigma == 0.0 => exact.push(name),
                Some(_) => self.number(&format!("{name}_sigma_mm"), 1e3 * sigma),
            }
        }
        match exact.len() {
            0 => {}
            4 => self.raw("exact", "true"),
            1 if shape.is_none() => self.raw("exact", "true"),
            _ => self.raw("exact", &format!("{exact:?}")),
        }
    }

    fn sigmas(&mut self, error: PlaceError) {
        self.number("sigma_mm", 1e3 * error.length);
        self.number("sigma_deg", error.angle.to_degrees());
    }
}

fn pose(pose: &Pose) -> String {
    let xyz = pose.translation.vector.map(|x| 1e3 * x);
    let q = pose.rotation.quaternion();
    let list = |numbers: &[f64]| numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", ");
    format!("{{ xyz_mm = [{}], quat_wxyz = [{}] }}", list(xyz.as_slice()), list(&[q.w, q.i, q.j, q.k]))
}

/// The table `[robot]`.
pub(super) fn robot_text(file: &ScenarioFile, files: &mut Vec<TextFile>) -> String {
    let mut text = String::new();
    let mut line = Lines(&mut text);
    let robot = &file.scenario.robot;
    line.table("[robot]");
    match &file.builtin {
        Some(name) => line.text("builtin", name),
        None => {
            line.text("urdf", URDF);
            files.push(TextFile::new(URDF, file.urdf.clone()));
        }
    }
    line.text("base", robot.base());
    line.text("tip", robot.tip());
    let gravity = robot.gravity();
    if gravity.as_slice() != GRAVITY {
        line.raw("gravity", &format!("[{}, {}, {}]", number(gravity.x), number(gravity.y), number(gravity.z)));
    }
    text
}

/// The peg and hole of the first hole, if there is one.
fn peg_and_hole(scenario: &Scenario) -> Option<&PrismPair> {
    scenario.touches.iter().find_map(|touch| match &touch.parts {
        Parts::PegInHole(parts) => Some(parts.as_ref()),
        _ => None,
    })
}

/// The table `[tool]`, without how far it may be off.
pub(super) fn tool_text(scenario: &Scenario, files: &mut Vec<TextFile>) -> String {
    let mut text = String::new();
    let mut line = Lines(&mut text);
    line.table("[tool]");
    let on_plane = scenario.touches.iter().find_map(|touch| match &touch.parts {
        Parts::OnPlane { points, radius } => Some((points, *radius)),
        _ => None,
    });
    match (peg_and_hole(scenario), on_plane) {
        (Some(parts), _) => {
            line.text("kind", "peg");
            outline(parts.peg(), PEG, &mut line, files);
            line.number("length_mm", 1e3 * parts.length());
            line.number("edge_radius_mm", 1e3 * parts.edge_radii().peg);
        }
        (None, Some((points, radius))) if points.len() > 1 => {
            line.text("kind", "peg");
            line.text("outline", PEG);
            let eroded: Vec<_> = points.iter().map(|point| point.xy()).collect();
            let sharp = Polygon::new(eroded.clone()).and_then(|outline| outline.offset_mitred(radius));
            let tip = sharp.map_or(eroded, |outline| outline.vertices().to_vec());
            files.push(TextFile::new(PEG, vertices(tip.iter().map(|point| [point.x, point.y]))));
            line.number("edge_radius_mm", 1e3 * radius);
        }
        (None, Some((_, radius))) => {
            line.text("kind", "ball");
            line.number("radius_mm", 1e3 * radius);
        }
        (None, None) => line.text("kind", "ball"),
    }
    line.raw("tip_from_tool", &pose(&scenario.tip_from_tool));
    text
}

fn outline(profile: &Polygon, name: &str, line: &mut Lines<'_>, files: &mut Vec<TextFile>) {
    if *profile == Polygon::extrusion25() {
        line.text("builtin", "extrusion25");
    } else {
        line.text("outline", name);
        files.push(TextFile::new(name, vertices(profile.vertices().iter().map(|v| [v.x, v.y]))));
    }
}

fn vertices(points: impl Iterator<Item = [f64; 2]>) -> String {
    let lines = points.map(|[x, y]| format!("{},{}\n", number(1e3 * x), number(1e3 * y)));
    format!("x_mm,y_mm\n{}", lines.collect::<String>())
}

/// A table `[[fixture]]` with its name and shape.
pub(super) fn fixture_text(scenario: &Scenario, touch: &Touch, files: &mut Vec<TextFile>) -> String {
    let mut text = String::new();
    let mut line = Lines(&mut text);
    line.table("[[fixture]]");
    line.text("name", &touch.name);
    match &touch.parts {
        Parts::PegInHole(parts) => {
            line.text("kind", "hole");
            match offset(parts) {
                Some(offset) => line.number("outline_offset_mm", 1e3 * offset),
                None => {
                    let name = format!("{}.outline.csv", file_name(scenario, touch));
                    outline(parts.hole(), &name, &mut line, files);
                }
            }
            line.number("depth_mm", 1e3 * parts.depth());
            line.number("edge_radius_mm", 1e3 * parts.edge_radii().hole);
        }
        Parts::BallInSocket => line.text("kind", "socket"),
        Parts::OnPlane { .. } => line.text("kind", "plane"),
    }
    text
}

/// How far (m) the hole is the peg's outline moved outwards, if it is that.
fn offset(parts: &PrismPair) -> Option<f64> {
    let between = parts.hole().vertices().first()? - parts.peg().vertices().first()?;
    let offset = between.dot(&parts.peg().outward(0));
    let moved = parts.peg().offset_mitred(offset).ok().filter(|_| offset > 0.0)?;
    let same = |(a, b): (&nalgebra::Point2<f64>, &nalgebra::Point2<f64>)| (a - b).norm() < 1e-9;
    let all = moved.len() == parts.hole().len() && moved.vertices().iter().zip(parts.hole().vertices()).all(same);
    all.then_some(offset)
}

/// The fixture's name as part of a file's: its number where the name would not do.
pub(super) fn file_name(scenario: &Scenario, touch: &Touch) -> String {
    let plain = |name: &str| name.replace('/', "_");
    let safe = |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    let name = plain(&touch.name);
    let alike = scenario.touches.iter().filter(|other| plain(&other.name).eq_ignore_ascii_case(&name)).count();
    let number = scenario.touches.iter().position(|other| other.name == touch.name).unwrap_or(0);
    if safe(&name) && alike == 1 && name.len() <= 100 { name } else { format!("fixture_{number}") }
}
