//! `touchcal manifold`.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;
use touchcal::estimate::{ArmFit, FixtureDisplacement, Problem, arm_fit, contact_poses, evaluate};
use touchcal::io::Input;
use touchcal::io::manifold_file::{ManifoldFile, Provenance};
use touchcal::io::{Loaded, atomic, pose_file, problem_file};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::{Coverage, PoseSamples, Quantiles, ResidualKind};
use touchcal::statistics::p_value_statement;

use crate::args::ManifoldArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::table::Table;

const COORDINATES: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Reads poses, thins them, writes the samples, prints their coverage.
pub fn run(args: &ManifoldArgs) -> Result<Outcome, Failure> {
    let recording = Recording::read(args)?;
    let inputs = recording.inputs.iter().map(|input| Path::new(&input.path));
    super::prepare_outputs([args.out.clone()], inputs)?;
    let metric = Metric { metres_per_radian: args.mm_per_deg * 1e-3 / 1f64.to_radians() };
    let spacing = args.spacing_mm * 1e-3;
    let thinned = recording.samples.thinned(spacing, metric);
    let samples = thinned.map_err(|error| Failure::Samples { of: "--spacing-mm".to_owned(), error })?;
    let provenance = Provenance {
        fixture: recording.fixture,
        recorded: recording.samples.len() as u64,
        spacing,
        metres_per_radian: metric.metres_per_radian,
        inputs: recording.inputs,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let coverage = Coverage::of(&samples, metric);
    let file = ManifoldFile { samples, provenance };
    crate::progress::defer_interrupts();
    atomic::write(&args.out, &file.to_bytes()?)?;
    let summary =
        Summary { file: &file, coverage: &coverage, distance: recording.distance, logs: recording.logs, args };
    output::print(&if args.json { summary.json()? } else { summary.text() })?;
    Ok(Outcome::Done)
}

/// Recorded poses of the tool in a fixture.
struct Recording {
    samples: PoseSamples,
    fixture: String,
    inputs: Vec<Input>,
    /// Mean distance (m) of the poses from the contact manifold of the problem's shapes.
    distance: Option<f64>,
    /// Number of logs with contacts of the fixture; `None` of a table of poses.
    logs: Option<usize>,
}

impl Recording {
    fn read(args: &ManifoldArgs) -> Result<Recording, Failure> {
        let named = args.fixture.as_deref();
        if let Some(poses) = &args.poses {
            let (samples, input) = pose_file::read_file(poses)?;
            let fixture = named.unwrap_or_default().to_owned();
            return Ok(Recording { samples, fixture, inputs: vec![input], distance: None, logs: None });
        }
        // clap requires one of the sources.
        let path = args.problem.as_deref().unwrap_or(Path::new("PROBLEM.toml"));
        let Loaded { problem, inputs, .. } = problem_file::read_file(path)?;
        let names: Vec<&str> = problem.fixtures.iter().map(|fixture| fixture.name.as_str()).collect();
        let chosen = match (named, names.as_slice()) {
            (None, [_]) => Some(0),
            (Some(named), _) => names.iter().position(|name| *name == named),
            (None, _) => None,
        };
        let Some(chosen) = chosen else {
            let found = named.map_or_else(|| "none".to_owned(), |named| format!("`{named}`"));
            let expected = format!("--fixture with the name of one ({})", names.join(", "));
            return Err(Failure::Setup(format!("{}: expected {expected}, found {found}", path.display())));
        };
        require_calibrated_arm(&problem, chosen, path)?;
        let samples = PoseSamples::from_poses(&contact_poses(&problem, chosen)).map_err(|error| Failure::Samples {
            of: format!("{}, contacts of fixture `{}`", path.display(), names[chosen]),
            error,
        })?;
        let has_shapes = problem.fixtures[chosen].manifold.residual_kind() != ResidualKind::Unmodeled;
        let distance = evaluate(&problem).per_fixture.get(chosen).filter(|_| has_shapes).map(|spread| spread.mean);
        let contacts = &problem.contacts;
        let of_fixture = (0..contacts.len()).filter(|&i| contacts.fixture(i) == chosen);
        let logs: BTreeSet<u32> = of_fixture.map(|i| contacts.source(i).file).collect();
        Ok(Recording { samples, fixture: names[chosen].to_owned(), inputs, distance, logs: Some(logs.len()) })
    }
}

/// Refuses contacts with fixture number `chosen` if the arm misses its fixtures, as an arm that is
/// not calibrated does; says so if nothing can tell, or if a fixture is not quite where it is
/// declared.
fn require_calibrated_arm(problem: &Problem, chosen: usize, path: &Path) -> Result<(), Failure> {
    let file = path.display();
    let name = |fixture: usize| &problem.fixtures[fixture].name;
    let refused = |evidence: String| Err(Failure::ArmMisses { problem: file.to_string(), evidence });
    let found = |displacement: &FixtureDisplacement| {
        let FixtureDisplacement { distance, angle, .. } = displacement;
        format!("{:.2} mm and {:.2}° from where it is declared", 1e3 * distance, angle.to_degrees())
    };
    match arm_fit(problem, chosen) {
        ArmFit::Met => {}
        ArmFit::Displaced(displacement) => output::notes(&[format!(
            "by these contacts tool or fixture `{}` is {}, within its tolerance: stored poses are relative to the declared place",
            name(displacement.fixture),
            found(&displacement)
        )]),
        ArmFit::Elsewhere(displacement) => {
            return refused(format!(
                "expected tool and fixture `{}` within their tolerances by their contacts, found them {} ({})",
                name(displacement.fixture),
                found(&displacement),
                p_value_statement(displacement.p_value)
            ));
        }
        ArmFit::Missed { fixture, found, allowed } => {
            return refused(format!(
                "expected contacts with `{}` within {:.2} mm of its surfaces, wherever they put it (root mean square; noise and declared tolerances allow that), found {:.2} mm",
                name(fixture),
                1e3 * allowed,
                1e3 * found
            ));
        }
        ArmFit::Unknown => output::notes(&[format!(
            "no fixture of known shape in {file} shows whether its arm is calibrated: poses are taken as they are"
        )]),
    }
    Ok(())
}

/// Output of the command.
struct Summary<'a> {
    file: &'a ManifoldFile,
    coverage: &'a Coverage,
    distance: Option<f64>,
    logs: Option<usize>,
    args: &'a ManifoldArgs,
}

impl Summary<'_> {
    fn text(&self) -> String {
        let Provenance { fixture, recorded, .. } = &self.file.provenance;
        let of = if fixture.is_empty() { String::new() } else { format!(" of the tool in `{fixture}`") };
        let kept = match self.args.spacing_mm {
            0.0 => "all taken".to_owned(),
            spacing => format!("{} samples at least {spacing} mm apart", self.coverage.count),
        };
        let distance = self.distance.map_or_else(String::new, |distance| {
            format!(
                "Distance  {:.3} mm from the shapes' contact manifold on average, with the arm as given\n",
                1e3 * distance
            )
        });
        let from = match self.logs {
            None => "a table".to_owned(),
            Some(1) => "1 log".to_owned(),
            Some(logs) => format!("{logs} logs"),
        };
        [
            format!("Manifold  {recorded} poses{of} from {from}, {kept}\n"),
            distance,
            format!("Metric    {} mm are equivalent to 1 deg\n\n", self.args.mm_per_deg),
            self.coordinates(),
            self.distances(),
            format!("Written   {}\n", self.args.out.display()),
        ]
        .concat()
    }

    fn coordinates(&self) -> String {
        let mut table = Table::new(["coordinate", "minimum", "5 %", "median", "95 %", "maximum", "unit"]);
        for (k, (name, quantiles)) in COORDINATES.iter().zip(&self.coverage.coordinates).enumerate() {
            let (factor, unit) = if k < 3 { (1e3, "mm") } else { (1f64.to_degrees(), "deg") };
            let numbers = array(quantiles).map(|value| format!("{:.2}", factor * value));
            table.row([(*name).to_owned()].into_iter().chain(numbers).chain([unit.to_owned()]));
        }
        format!("{table}\n")
    }

    fn distances(&self) -> String {
        let mut table =
            Table::new(["distance to the nearest sample", "minimum", "5 %", "median", "95 %", "maximum", "unit"]);
        let Coverage { spacing, unseen, .. } = self.coverage;
        for (name, quantiles) in [("of all others", spacing), ("of the other nine tenths of the recording", unseen)] {
            let numbers = array(quantiles).map(|value| format!("{:.3}", 1e3 * value));
            table.row([name.to_owned()].into_iter().chain(numbers).chain(["mm".to_owned()]));
        }
        format!("{table}\n")
    }

    fn json(&self) -> Result<String, Failure> {
        let json = ManifoldJson {
            schema: 1,
            provenance: &self.file.provenance,
            samples: self.coverage.count,
            touch: self.distance.and_then(output::finite),
            coordinates: COORDINATES.into_iter().zip(self.coverage.coordinates.iter().map(array)).collect(),
            spacing: array(&self.coverage.spacing),
            unseen: array(&self.coverage.unseen),
        };
        Ok(serde_json::to_string_pretty(&json)? + "\n")
    }
}

/// What `--json` prints: SI units and radians; of distances and coordinates least, 5 %, median, 95
/// % and greatest.
#[derive(Serialize)]
struct ManifoldJson<'a> {
    schema: u32,
    provenance: &'a Provenance,
    samples: usize,
    touch: Option<f64>,
    coordinates: std::collections::BTreeMap<&'static str, [f64; 5]>,
    spacing: [f64; 5],
    unseen: [f64; 5],
}

fn array(quantiles: &Quantiles) -> [f64; 5] {
    let Quantiles { least, q05, median, q95, greatest } = *quantiles;
    [least, q05, median, q95, greatest]
}
