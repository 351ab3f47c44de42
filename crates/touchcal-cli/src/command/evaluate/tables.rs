//! What is found by an evaluation, beside what is predicted.

use touchcal::estimate::{CommonStrain, DistanceSource, Evaluation, Fixture, FixtureDistance, Scatter, Severity};
use touchcal::report::signed;

use crate::summary::{MOST_FIXTURES, millimetres, warning};
use crate::table::Table;

/// Tables of scatter and of distances, and what contradicts the calibration. `is_calibrated` says
/// whether what the calibration leaves uncertain is known.
pub fn evaluation(fixtures: &[Fixture], evaluation: &Evaluation, is_calibrated: bool) -> String {
    let source = match is_calibrated {
        true => "what the calibration leaves uncertain",
        false => "declared tolerances, with an exact arm",
    };
    let contradictions = &evaluation.contradictions;
    let warnings: String =
        contradictions.iter().map(|each| warning(Severity::Doubtful, &each.message(), each.advice())).collect();
    let agreement = match is_calibrated && evaluation.agrees() == Some(true) {
        true => "Nothing here contradicts the calibration's covariance beyond chance.\n",
        false => "",
    };
    scatter(fixtures, evaluation, source) + &distances(evaluation, source) + &warnings + agreement
}

/// Scatter found and predicted; nothing where none is predicted.
fn scatter(fixtures: &[Fixture], evaluation: &Evaluation, source: &str) -> String {
    let Evaluation { scatter, per_fixture, score, .. } = evaluation;
    if scatter.is_none() && per_fixture.iter().all(Option::is_none) {
        return String::new();
    }
    let mut table = Table::new(["", "found", "predicted", "found/predicted", "by chance (99.9 %)"]);
    let touched: Vec<_> = fixtures
        .iter()
        .zip(per_fixture)
        .zip(&score.per_fixture)
        .filter(|(_, spread)| spread.count > 0)
        .map(|(fixture, _)| fixture)
        .collect();
    let mut row = |name: &str, scatter: &Option<Scatter>| {
        let Some(scatter) = scatter else {
            return table.row([name.to_owned()].into_iter().chain((0..4).map(|_| "-".to_owned())));
        };
        let [low, high] = scatter.by_chance;
        let lengths = [scatter.found, scatter.predicted].map(millimetres);
        let ratios = [format!("{:.3}", scatter.ratio()), format!("{low:.3} to {high:.3}")];
        table.row([name.to_owned()].into_iter().chain(lengths).chain(ratios));
    };
    row("all", scatter);
    if fixtures.len() > 1 {
        touched.iter().take(MOST_FIXTURES).for_each(|(fixture, scatter)| row(&fixture.name, scatter));
    }
    let more = more(touched.len());
    format!("Scatter found, and predicted from noise and {source} (rms, mm)\n{table}{more}\n")
}

/// Distances between fixtures; nothing where there are none. Of many, the worst are listed.
fn distances(evaluation: &Evaluation, source: &str) -> String {
    let mut distances: Vec<&FixtureDistance> = evaluation.distances.iter().collect();
    if distances.is_empty() {
        return String::new();
    }
    if distances.len() > MOST_FIXTURES {
        distances.sort_by(|a, b| b.deviations().abs().total_cmp(&a.deviations().abs()));
    }
    let mut table = Table::new(["", "declared by", "declared", "found", "difference", "± sigma", "difference/sigma"]);
    for distance in distances.iter().take(MOST_FIXTURES) {
        let [a, b] = &distance.between;
        let declaration = match distance.source {
            DistanceSource::Distance => "distance",
            DistanceSource::Places => "places",
        };
        table.row([
            format!("{a} – {b}"),
            declaration.to_owned(),
            millimetres(distance.declared),
            millimetres(distance.found),
            signed(1e3 * distance.difference(), 3),
            millimetres(distance.sigma),
            signed(distance.deviations(), 1),
        ]);
    }
    let more = more(distances.len());
    let common = evaluation.common_strain.map_or_else(String::new, common_strain);
    format!("Distances of fixtures, with noise and {source} (mm)\n{table}{more}{common}\n")
}

fn common_strain(common: CommonStrain) -> String {
    let [strain, sigma] = [common.strain, common.sigma].map(|value| 100.0 * value);
    let deviations = signed(common.deviations(), 1);
    format!("  common to all: {} ± {sigma:.3} %, {deviations} sigma\n", signed(strain, 3))
}

fn more(count: usize) -> String {
    match count.saturating_sub(MOST_FIXTURES) {
        0 => String::new(),
        more => format!("  … and {more} more (--json lists them)\n"),
    }
}
