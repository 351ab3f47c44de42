//! What `evaluate --json` prints.

use std::collections::BTreeMap;
use std::path::Path;

use super::truth::ParameterError;
use crate::command::rms_and_max::RmsAndMaxJson;
use serde::Serialize;
use touchcal::estimate::{CommonStrain, Contradiction, Evaluation, Fixture, FixtureDistance, Score};
use touchcal::experiment::PoseErrors;
use touchcal::io::calibration_folder::stats;
use touchcal::io::estimate_file::{ResidualStats, ScatterEntry, WarningEntry};

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
    /// Errors of the tool relative to the true arm, where that is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<TruthJson>,
}

/// Errors of the tool across the workspace, and of parameters.
#[derive(Serialize)]
pub struct TruthJson {
    nominal: PoseErrorsJson,
    given: PoseErrorsJson,
    /// Those of the calibration, if it is given, that contacts determine first.
    parameters: Vec<ParameterErrorJson>,
}

/// Values in the parameter's unit, as in `estimate.json`.
#[derive(Serialize)]
struct ParameterErrorJson {
    name: String,
    unit: &'static str,
    #[serde(rename = "true")]
    truth: f64,
    estimated: f64,
    difference: f64,
    sigma: Option<f64>,
    /// Difference over sigma; none where the parameter is not identifiable.
    deviations: Option<f64>,
    identifiable: bool,
}

#[derive(Serialize)]
struct PoseErrorsJson {
    position_mm: RmsAndMaxJson,
    angle_deg: RmsAndMaxJson,
    aligned_position_mm: RmsAndMaxJson,
    aligned_angle_deg: RmsAndMaxJson,
    distance_mm: RmsAndMaxJson,
}

impl TruthJson {
    /// Of the nominal and the given arm, and of the calibration's parameters.
    pub fn new([nominal, given]: &[PoseErrors; 2], parameters: &[ParameterError]) -> Self {
        let entry = |errors: &PoseErrors| {
            let (mm, deg) = (1e3, 1f64.to_degrees());
            PoseErrorsJson {
                position_mm: RmsAndMaxJson::new(errors.position, mm),
                angle_deg: RmsAndMaxJson::new(errors.angle, deg),
                aligned_position_mm: RmsAndMaxJson::new(errors.aligned_position, mm),
                aligned_angle_deg: RmsAndMaxJson::new(errors.aligned_angle, deg),
                distance_mm: RmsAndMaxJson::new(errors.distance, mm),
            }
        };
        let parameters = parameters.iter().map(|error| ParameterErrorJson {
            name: error.name.clone(),
            unit: error.unit.symbol(),
            truth: error.truth,
            estimated: error.estimated,
            difference: error.difference(),
            sigma: error.sigma,
            deviations: error.deviations(),
            identifiable: error.is_identifiable,
        });
        TruthJson { nominal: entry(nominal), given: entry(given), parameters: parameters.collect() }
    }
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
            truth: None,
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
        severity: contradiction.severity().into(),
        message: contradiction.message(),
        advice: contradiction.advice().to_owned(),
    }
}
