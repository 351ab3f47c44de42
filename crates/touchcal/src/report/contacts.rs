//! Statistics of all contacts, and the few that are drawn one by one.

use nalgebra::{DVector, Vector3};
use serde::Serialize;

use super::relative::CommonFolder;
use crate::contact::ContactLog;
use crate::estimate::{Estimate, Method, Problem, Verdict, contact_residuals};
use crate::statistics::upper_median;

/// Largest number of contacts that the page draws one by one; of more, it draws an even subsample
/// and the 300 with the largest distances.
pub const MOST_DRAWN: usize = 3000;
/// Number of these with the largest distances; the others are evenly spread over the log.
const FARTHEST_DRAWN: usize = 300;
/// Largest number of rejected contacts outliers, and number of largest distances outliers if none
/// was rejected.
const MOST_LISTED: usize = 100;
const FARTHEST_LISTED: usize = 10;
/// Bars of a histogram per decade, and the distance (m) below which all contacts are in the first
/// bar.
const BARS_PER_DECADE: f64 = 8.0;
const LEAST: f64 = 1e-7;
/// Largest number of sections of the log with a median each, and fewest contacts in one.
const MOST_SECTIONS: usize = 120;
const SHORTEST_SECTION: usize = 10;

/// The page's data of the contacts. Distances in m.
#[derive(Serialize)]
pub(super) struct Contacts {
    read: u64,
    used: usize,
    rejected: usize,
    /// Number of contacts that the search used, if it was a gradient descent.
    #[serde(skip_serializing_if = "Option::is_none")]
    used_by_descent: Option<usize>,
    files: Vec<String>,
    /// Stride between drawn contacts.
    every: usize,
    drawn: DrawnContacts,
    histogram: Vec<Bar>,
    sections: Vec<Section>,
    outliers: Vec<Outlier>,
    #[serde(skip)]
    rejected_per_fixture: Vec<usize>,
}

/// Contacts drawn one by one, a column each.
#[derive(Default, Serialize)]
pub(super) struct DrawnContacts {
    /// Index of each drawn contact in the log.
    pub index: Vec<usize>,
    fixture: Vec<usize>,
    file: Vec<u32>,
    line: Vec<u64>,
    before: Vec<f32>,
    after: Vec<f32>,
    /// First rows of the residual after the calibration, see [`contact_residuals`].
    residual: Vec<[f32; 3]>,
    rejected: Vec<u8>,
}

/// Contacts between two distances.
#[derive(Serialize)]
struct Bar {
    from: f64,
    to: f64,
    before: usize,
    after: usize,
}

/// Medians over a section of the log.
#[derive(Serialize)]
struct Section {
    from: usize,
    to: usize,
    before: f32,
    after: f32,
}

/// A contact of a large distance.
#[derive(Serialize)]
struct Outlier {
    index: usize,
    fixture: usize,
    file: u32,
    line: u64,
    after: f32,
    /// Distance in standard deviations, of a rejected contact.
    deviations: Option<f32>,
}

impl Contacts {
    /// Statistics of the contacts of `problem` with its result, and its logs without `folder`.
    pub fn new(problem: &Problem, estimate: &Estimate, folder: &CommonFolder) -> Self {
        let log = &problem.contacts;
        let values = estimate.values();
        let residuals = contact_residuals(problem, &values);
        let distances = |residuals: &[Vector3<f64>]| residuals.iter().map(Vector3::norm).collect::<Vec<f64>>();
        let before = distances(&contact_residuals(problem, &DVector::zeros(values.len())));
        let after = distances(&residuals);
        let mut rejected_per_fixture = vec![0; problem.fixtures.len()];
        for (i, verdict) in estimate.verdicts.iter().enumerate() {
            if matches!(verdict, Verdict::Rejected { .. }) {
                rejected_per_fixture[log.fixture(i)] += 1;
            }
        }
        let farthest = farthest(&after);
        let every = log.len().div_ceil(MOST_DRAWN - FARTHEST_DRAWN).max(1);
        let every = if log.len() <= MOST_DRAWN { 1 } else { every };
        let mut which: Vec<usize> = (0..log.len()).step_by(every).collect();
        which.extend(&farthest[..FARTHEST_DRAWN.min(farthest.len())]);
        which.sort_unstable();
        which.dedup();
        Contacts {
            read: estimate.contacts.read,
            used: estimate.contacts.used,
            rejected: estimate.contacts.rejected,
            used_by_descent: match &problem.method {
                Method::GradientDescent(options) => Some(options.contacts_used(log.len())),
                Method::LevenbergMarquardt => None,
            },
            files: log.files().iter().map(|file| folder.shown(file)).collect(),
            every,
            drawn: drawn(log, &estimate.verdicts, which, (&before, &residuals)),
            histogram: histogram(&before, &after),
            sections: sections(&before, &after),
            outliers: outliers(log, &estimate.verdicts, &farthest, &after),
            rejected_per_fixture,
        }
    }

    /// Indices of the contacts drawn one by one.
    pub fn drawn(&self) -> &[usize] {
        &self.drawn.index
    }

    /// Rejected contacts of fixture `f`.
    pub fn rejected_count(&self, f: usize) -> usize {
        self.rejected_per_fixture[f]
    }
}

/// Indices of all contacts, the largest distance first.
fn farthest(after: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..after.len()).collect();
    order.sort_by(|&a, &b| after[b].total_cmp(&after[a]));
    order
}

fn drawn(
    log: &ContactLog,
    verdicts: &[Verdict],
    which: Vec<usize>,
    (before, residuals): (&[f64], &[Vector3<f64>]),
) -> DrawnContacts {
    let rejected = |i: &usize| u8::from(matches!(verdicts.get(*i), Some(Verdict::Rejected { .. })));
    DrawnContacts {
        fixture: which.iter().map(|&i| log.fixture(i)).collect(),
        file: which.iter().map(|&i| log.source(i).file).collect(),
        line: which.iter().map(|&i| log.source(i).line).collect(),
        before: which.iter().map(|&i| before[i] as f32).collect(),
        after: which.iter().map(|&i| residuals[i].norm() as f32).collect(),
        residual: which.iter().map(|&i| residuals[i].map(|row| row as f32).into()).collect(),
        rejected: which.iter().map(rejected).collect(),
        index: which,
    }
}

/// Bars of equal width in the distance's logarithm.
fn histogram(before: &[f64], after: &[f64]) -> Vec<Bar> {
    let bar_of = |distance: &f64| (distance.max(LEAST).log10() * BARS_PER_DECADE).floor() as i64;
    let bars = || before.iter().chain(after).filter(|distance| distance.is_finite()).map(bar_of);
    let (Some(first), Some(last)) = (bars().min(), bars().max()) else { return Vec::new() };
    let edge = |bar: i64| 10f64.powf(bar as f64 / BARS_PER_DECADE);
    let mut histogram: Vec<Bar> =
        (first..=last).map(|bar| Bar { from: edge(bar), to: edge(bar + 1), before: 0, after: 0 }).collect();
    let place = |distance: &f64| distance.is_finite().then(|| (bar_of(distance) - first) as usize);
    before.iter().filter_map(place).for_each(|bar| histogram[bar].before += 1);
    after.iter().filter_map(place).for_each(|bar| histogram[bar].after += 1);
    histogram
}

fn sections(before: &[f64], after: &[f64]) -> Vec<Section> {
    let length = before.len().div_ceil(MOST_SECTIONS).max(SHORTEST_SECTION);
    let each = before.chunks(length).zip(after.chunks(length)).enumerate();
    each.map(|(k, (before, after))| Section {
        from: k * length,
        to: k * length + before.len(),
        before: upper_median(before.to_vec()).unwrap_or(0.0) as f32,
        after: upper_median(after.to_vec()).unwrap_or(0.0) as f32,
    })
    .collect()
}

/// The rejected contacts, the most standard deviations first; if there are none, the contacts of
/// the largest distances.
fn outliers(log: &ContactLog, verdicts: &[Verdict], farthest: &[usize], after: &[f64]) -> Vec<Outlier> {
    let deviations = |i: usize| match verdicts.get(i) {
        Some(Verdict::Rejected { deviations }) => Some(*deviations),
        _ => None,
    };
    let mut rejected: Vec<(usize, Option<f64>)> =
        (0..verdicts.len()).map(|i| (i, deviations(i))).filter(|(_, deviations)| deviations.is_some()).collect();
    rejected.sort_by(|(_, a), (_, b)| b.unwrap_or(0.0).total_cmp(&a.unwrap_or(0.0)));
    rejected.truncate(MOST_LISTED);
    if rejected.is_empty() {
        rejected = farthest.iter().take(FARTHEST_LISTED).map(|&i| (i, None)).collect();
    }
    let each = rejected.into_iter().map(|(i, deviations)| Outlier {
        index: i,
        fixture: log.fixture(i),
        file: log.source(i).file,
        line: log.source(i).line,
        after: after[i] as f32,
        deviations: deviations.map(|value| value as f32),
    });
    each.collect()
}
