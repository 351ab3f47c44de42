//! What `evaluate --json` prints.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use touchcal::estimate::{CommonStrain, Contradiction, Evaluation, Fixture, FixtureDistance, Score};
use touchcal::io::calibration_folder::stats;
use touchcal::io::estimate_file::{ResidualStats, ScatterEntry, Severity, WarningEntry};

/// Scores of the given and the nominal arm, and the given one's beside what is predicted.
#[derive(Serialize)]
pub struct EvaluationJson {
    urdf: String,
    /// Of the given URDF, at the top.
    #[serde(flatten)]
    given: ResidualStats,
    /// Of the nominal one.
    nominal: ResidualStats,
    scatter: ScatterJson,
    distances: Vec<DistanceJson>,
    common_strain: Option<CommonStrainJson>,
    warnings: Vec<WarningEntry>,
}

#[derive(Serialize)]
struct ScatterJson {
    all: Option<ScatterEntry>,
    per_fixture: BTreeMap<String, Option<ScatterEntry>>,
}

#[derive(Serialize)]
struct DistanceJson {
    between: [String; 2],
    /// What declares it: `distance` or `places`.
    source: &'static str,
    declared_mm: f64,
    found_mm: f64,
    difference_mm: f64,
    sigma_mm: f64,
    deviations: f64,
}

#[derive(Serialize)]
struct CommonStrainJson {
    strain: f64,
    sigma: f64,
    deviations: f64,
}

impl EvaluationJson {
    /// The output of an evaluation.
    pub fn new(urdf: &Path, fixtures: &[Fixture], evaluation: &Evaluation, nominal: &Score) -> Self {
        let names = fixtures.iter().map(|fixture| fixture.name.clone());
        let per_fixture =
            names.zip(&evaluation.per_fixture).map(|(name, scatter)| (name, scatter.map(ScatterEntry::from)));
        let strain = |common: CommonStrain| CommonStrainJson {
            strain: common.strain,
            sigma: common.sigma,
            deviations: common.deviations(),
        };
        EvaluationJson {
            urdf: urdf.display().to_string(),
            given: stats(&evaluation.score, fixtures),
            nominal: stats(nominal, fixtures),
            scatter: ScatterJson {
                all: evaluation.scatter.map(ScatterEntry::from),
                per_fixture: per_fixture.collect(),
            },
            distances: evaluation.distances.iter().map(distance_entry).collect(),
            common_strain: evaluation.common_strain.map(strain),
            warnings: evaluation.contradictions.iter().map(warning_entry).collect(),
        }
    }
}

fn distance_entry(distance: &FixtureDistance) -> DistanceJson {
    DistanceJson {
        between: distance.between.clone(),
        source: distance.source.name(),
        declared_mm: 1e3 * distance.declared,
        found_mm: 1e3 * distance.found,
        difference_mm: 1e3 * distance.difference(),
        sigma_mm: 1e3 * distance.sigma,
        deviations: distance.deviations(),
    }
}

fn warning_entry(contradiction: &Contradiction) -> WarningEntry {
    WarningEntry {
        kind: contradiction.kind().to_owned(),
        severity: Severity::Caution,
        message: contradiction.message(),
        advice: contradiction.advice().to_owned(),
    }
}
