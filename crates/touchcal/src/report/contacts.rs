//! Contacts: counted all, drawn few.

use nalgebra::DVector;
use serde::Serialize;

use super::Report;
use crate::contact::ContactLog;
use crate::estimate::{Verdict, contact_distances};

/// About this many contacts are drawn one by one.
pub const MOST_DRAWN: usize = 3000;
/// As many of them are the farthest of all, the others evenly spread over the log.
const FARTHEST_DRAWN: usize = 300;
/// Most rejected contacts listed, and the farthest listed if none was rejected.
const MOST_LISTED: usize = 100;
const FARTHEST_LISTED: usize = 10;
/// Bars of a histogram in a factor of ten, and the distance (m) below which everything is in the
/// first.
const BARS_PER_DECADE: f64 = 8.0;
const LEAST: f64 = 1e-7;
/// Most stretches of the log whose medians are told, and fewest contacts in one.
const MOST_STRETCHES: usize = 120;
const SHORTEST_STRETCH: usize = 10;

/// What the page is told of contacts. Distances in m.
#[derive(Serialize)]
pub(super) struct Contacts<'a> {
    read: u64,
    used: usize,
    rejected: usize,
    files: &'a [String],
    /// Every how many contacts one is drawn.
    every: usize,
    drawn: Drawn,
    histogram: Vec<Bar>,
    stretches: Vec<Stretch>,
    listed: Vec<Listed>,
    #[serde(skip)]
    rejected_per_fixture: Vec<usize>,
}

/// Contacts drawn one by one, a column each.
#[derive(Default, Serialize)]
pub(super) struct Drawn {
    pub index: Vec<usize>,
    fixture: Vec<usize>,
    file: Vec<u32>,
    line: Vec<u64>,
    before: Vec<f32>,
    after: Vec<f32>,
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

/// Medians over a stretch of the log.
#[derive(Serialize)]
struct Stretch {
    from: usize,
    to: usize,
    before: f32,
    after: f32,
}

/// A contact to look at.
#[derive(Serialize)]
struct Listed {
    index: usize,
    fixture: usize,
    file: u32,
    line: u64,
    after: f32,
    /// Distance in standard deviations, of a rejected one.
    deviations: Option<f32>,
}

impl<'a> Contacts<'a> {
    pub fn new(report: &Report<'a>) -> Self {
        let Report { problem, estimate, .. } = *report;
        let log = &problem.contacts;
        let values = estimate.values();
        let before = contact_distances(problem, &DVector::zeros(values.len()));
        let after = contact_distances(problem, &values);
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
            files: log.files(),
            every,
            drawn: drawn(log, &estimate.verdicts, which, (&before, &after)),
            histogram: histogram(&before, &after),
            stretches: stretches(&before, &after),
            listed: listed(log, &estimate.verdicts, &farthest, &after),
            rejected_per_fixture,
        }
    }

    /// Indices of the contacts drawn one by one.
    pub fn drawn(&self) -> &[usize] {
        &self.drawn.index
    }

    /// Rejected contacts of fixture `f`.
    pub fn rejected_of(&self, f: usize) -> usize {
        self.rejected_per_fixture[f]
    }
}

/// All contacts, the farthest first.
fn farthest(after: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..after.len()).collect();
    order.sort_by(|&a, &b| after[b].total_cmp(&after[a]));
    order
}

fn drawn(log: &ContactLog, verdicts: &[Verdict], which: Vec<usize>, (before, after): (&[f64], &[f64])) -> Drawn {
    let rejected = |i: &usize| u8::from(matches!(verdicts.get(*i), Some(Verdict::Rejected { .. })));
    Drawn {
        fixture: which.iter().map(|&i| log.fixture(i)).collect(),
        file: which.iter().map(|&i| log.source(i).file).collect(),
        line: which.iter().map(|&i| log.source(i).line).collect(),
        before: which.iter().map(|&i| before[i] as f32).collect(),
        after: which.iter().map(|&i| after[i] as f32).collect(),
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

fn stretches(before: &[f64], after: &[f64]) -> Vec<Stretch> {
    let length = before.len().div_ceil(MOST_STRETCHES).max(SHORTEST_STRETCH);
    let each = before.chunks(length).zip(after.chunks(length)).enumerate();
    each.map(|(k, (before, after))| Stretch {
        from: k * length,
        to: k * length + before.len(),
        before: median(before) as f32,
        after: median(after) as f32,
    })
    .collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// The rejected contacts, the farthest in standard deviations first; if there are none, the
/// farthest that counted.
fn listed(log: &ContactLog, verdicts: &[Verdict], farthest: &[usize], after: &[f64]) -> Vec<Listed> {
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
    let each = rejected.into_iter().map(|(i, deviations)| Listed {
        index: i,
        fixture: log.fixture(i),
        file: log.source(i).file,
        line: log.source(i).line,
        after: after[i] as f32,
        deviations: deviations.map(|value| value as f32),
    });
    each.collect()
}
