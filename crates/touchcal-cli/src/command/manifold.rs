//! `touchcal manifold`.

use std::path::Path;

use serde::Serialize;
use touchcal::estimate::{contact_poses, evaluate};
use touchcal::io::estimate_file::InputEntry;
use touchcal::io::manifold_file::{ManifoldFile, Provenance};
use touchcal::io::{Loaded, atomic, pose_file, problem_file};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::{Coverage, PoseSamples, Quantiles};

use super::{Failure, Outcome};
use crate::args::ManifoldArgs;
use crate::output;
use crate::table::Table;

const COORDINATES: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Reads, thins, writes, tells.
pub fn run(args: &ManifoldArgs) -> Result<Outcome, Failure> {
    let recorded = Recorded::read(args)?;
    let inputs = recorded.inputs.iter().map(|input| Path::new(&input.path));
    super::check_outputs([args.out.clone()], inputs)?;
    let metric = Metric { metres_per_radian: args.mm_per_deg * 1e-3 / 1f64.to_radians() };
    let spacing = args.spacing_mm * 1e-3;
    let thinned = recorded.samples.thinned(spacing, metric);
    let samples = thinned.map_err(|error| Failure::Samples { of: "--spacing-mm".to_owned(), error })?;
    let provenance = Provenance {
        fixture: recorded.fixture,
        recorded: recorded.samples.len() as u64,
        spacing,
        metres_per_radian: metric.metres_per_radian,
        inputs: recorded.inputs,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let coverage = samples.coverage(metric);
    let file = ManifoldFile { samples, provenance };
    if crate::progress::interrupted() {
        return Err(Failure::Interrupted);
    }
    atomic::write(&args.out, &file.to_bytes()?)?;
    let told = Told { file: &file, coverage: &coverage, off: recorded.off, args };
    output::print(&if args.json { told.json()? } else { told.text() })?;
    Ok(Outcome::Done)
}

/// Poses as they were recorded.
struct Recorded {
    samples: PoseSamples,
    fixture: String,
    inputs: Vec<InputEntry>,
    /// Mean distance (m) from touching by the shapes that the problem knows.
    off: Option<f64>,
}

impl Recorded {
    fn read(args: &ManifoldArgs) -> Result<Recorded, Failure> {
        let named = args.fixture.as_deref();
        if let Some(poses) = &args.poses {
            let (samples, input) = pose_file::read_file(poses)?;
            let fixture = named.unwrap_or_default().to_owned();
            return Ok(Recorded { samples, fixture, inputs: vec![(&input).into()], off: None });
        }
        // clap lets neither source pass.
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
        let samples = PoseSamples::from_poses(&contact_poses(&problem, chosen)).map_err(|error| Failure::Samples {
            of: format!("{}, contacts of fixture `{}`", path.display(), names[chosen]),
            error,
        })?;
        let known = !problem.fixtures[chosen].manifold.is_unknown();
        let off = evaluate(&problem).per_fixture.get(chosen).filter(|_| known).map(|spread| spread.mean);
        Ok(Recorded {
            samples,
            fixture: names[chosen].to_owned(),
            inputs: inputs.iter().map(Into::into).collect(),
            off,
        })
    }
}

/// What is told of a manifold.
struct Told<'a> {
    file: &'a ManifoldFile,
    coverage: &'a Coverage,
    off: Option<f64>,
    args: &'a ManifoldArgs,
}

impl Told<'_> {
    fn text(&self) -> String {
        let Provenance { fixture, recorded, inputs, .. } = &self.file.provenance;
        let of = if fixture.is_empty() { String::new() } else { format!(" of {fixture}") };
        let kept = match self.args.spacing_mm {
            0.0 => "all kept".to_owned(),
            spacing => format!("{} kept, {spacing} mm apart or more", self.coverage.count),
        };
        let off = self.off.map_or_else(String::new, |off| {
            format!("Touch     {:.3} mm from touching on average, with the arm as it is\n", 1e3 * off)
        });
        let files = if inputs.len() == 1 { "1 file".to_owned() } else { format!("{} files", inputs.len()) };
        [
            format!("Manifold  {recorded} poses{of} from {files}, {kept}\n"),
            off,
            format!("Metric    {} mm count as 1 deg\n\n", self.args.mm_per_deg),
            self.coordinates(),
            self.distances(),
            format!("Written   {}\n", self.args.out.display()),
        ]
        .concat()
    }

    fn coordinates(&self) -> String {
        let mut table = Table::new(["coordinate", "least", "5 %", "median", "95 %", "most", "unit"]);
        for (k, (name, quantiles)) in COORDINATES.iter().zip(&self.coverage.coordinates).enumerate() {
            let (factor, unit) = if k < 3 { (1e3, "mm") } else { (1f64.to_degrees(), "deg") };
            let numbers = all(quantiles).map(|value| format!("{:.2}", factor * value));
            table.row([(*name).to_owned()].into_iter().chain(numbers).chain([unit.to_owned()]));
        }
        format!("{table}\n")
    }

    fn distances(&self) -> String {
        let mut table = Table::new(["to the nearest other sample", "least", "5 %", "median", "95 %", "most", "unit"]);
        let Coverage { spacing, unseen, .. } = self.coverage;
        for (name, quantiles) in [("of all", spacing), ("of the other nine tenths of the record", unseen)] {
            let numbers = all(quantiles).map(|value| format!("{:.3}", 1e3 * value));
            table.row([name.to_owned()].into_iter().chain(numbers).chain(["mm".to_owned()]));
        }
        format!("{table}\n")
    }

    fn json(&self) -> Result<String, Failure> {
        let told = ManifoldJson {
            schema: 1,
            provenance: &self.file.provenance,
            samples: self.coverage.count,
            touch: self.off.and_then(output::finite),
            coordinates: COORDINATES.into_iter().zip(self.coverage.coordinates.iter().map(all)).collect(),
            spacing: all(&self.coverage.spacing),
            unseen: all(&self.coverage.unseen),
        };
        Ok(serde_json::to_string_pretty(&told)? + "\n")
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

fn all(quantiles: &Quantiles) -> [f64; 5] {
    let Quantiles { least, q05, median, q95, greatest } = *quantiles;
    [least, q05, median, q95, greatest]
}
