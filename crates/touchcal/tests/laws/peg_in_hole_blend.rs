//! Laws of the blended gap: its formula, its derivative, and its limit at temperature 0.

use nalgebra::{Translation3, Vector3, Vector6};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use touchcal::geometry::{GapQuery, Polygon, PrismPair, nearest_feature, visit_features_within};
use touchcal::se3::{Pose, Twist, exp, twist};

/// How many temperatures above the least gap a feature stops to count, as documented.
const REACH: f64 = 4.0;

fn model() -> PrismPair {
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5e-3).unwrap();
    PrismPair::new(peg, 0.04, hole, 0.03).unwrap()
}

/// A pose moved to contact along the normal of its gap, and by `past` (m) farther out.
fn contact(model: &PrismPair, p: [f64; 3], w: [f64; 3], past: f64) -> Pose {
    let mut at = exp(&twist(&Vector3::zeros(), &Vector3::from(w)));
    at.translation.vector = Vector3::from(p);
    for _ in 0..10 {
        let gap = model.gap(&at);
        at = Translation3::from(gap.normal_in_fixture * (past - gap.value)) * at;
    }
    at
}

/// The documented mean, from the gaps that `visit_features_within` reports.
fn reference(model: &PrismPair, at: &Pose, temperature: f64) -> f64 {
    let least = model.gap(at).value;
    let (mut weights, mut weighted) = (0.0, 0.0);
    visit_features_within(model, at, REACH * temperature, |gap, _| {
        let x = (gap.value - least) / temperature;
        if x < REACH {
            let weight = (-x).exp() * (1.0 - (x / REACH).powi(2)).powi(2);
            weights += weight;
            weighted += weight * gap.value;
        }
    });
    weighted / weights
}

/// A step of one component: metres scaled to the peg's size, so that both kinds of component move
/// it alike.
fn step(k: usize, h: f64) -> Twist {
    let mut xi = Vector6::zeros();
    xi[k] = if k < 3 { h * 0.015 } else { h };
    xi
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), max_global_rejects: 100_000, ..ProptestConfig::default() })]

    #[test]
    fn agrees_with_the_formula(p in [-5e-4..5e-4, -5e-4..5e-4, -0.03..1e-3], w in [-0.026..0.026, -0.026..0.026, -0.026..0.026],
                               past in -3e-5..3e-5, temperature in 1e-6..2e-4) {
        let model = model();
        let at = contact(&model, p, w, past);
        let (mean, _) = model.blended_gap(&at, temperature);
        let expected = reference(&model, &at, temperature);
        prop_assert!((mean - expected).abs() < 1e-12, "{} {}", mean, expected);
    }

    /// More features within reach than are kept at a time.
    #[test]
    fn agrees_with_the_formula_when_hot(p in [-5e-4..5e-4, -5e-4..5e-4, -0.03..1e-3], w in [-0.026..0.026, -0.026..0.026, -0.026..0.026]) {
        let model = model();
        let at = contact(&model, p, w, 0.0);
        let (mean, _) = model.blended_gap(&at, 1e-3);
        prop_assert!((mean - reference(&model, &at, 1e-3)).abs() < 1e-12);
    }

    #[test]
    fn cold_it_is_the_gap(p in [-1e-3..1e-3, -1e-3..1e-3, -0.03..1e-3], w in [-0.03..0.03, -0.03..0.03, -0.03..0.03]) {
        let model = model();
        let at = contact(&model, p, w, 1e-5);
        let gap = model.gap(&at);
        prop_assert_eq!(model.blended_gap(&at, 0.0), (gap.value, gap.gradient));
    }

    #[test]
    fn gradient(p in [-5e-4..5e-4, -5e-4..5e-4, -0.028..-1e-3], w in [-0.026..0.026, -0.026..0.026, -0.026..0.026],
                past in -2e-5..2e-5, temperature in 2e-5..3e-5) {
        let model = model();
        let at = contact(&model, p, w, past);
        let features = |at: &Pose| {
            let mut found = Vec::new();
            visit_features_within(&model, at, REACH * temperature, |_, feature| found.push(format!("{feature:?}")));
            found.sort();
            (format!("{:?}", nearest_feature(&model, at).1), found)
        };
        let here = features(&at);
        let (_, gradient) = model.blended_gap(&at, temperature);
        let h = 2e-5;
        for k in 0..6 {
            // Only where no feature comes or goes and the least stays the same.
            prop_assume!(features(&(at * exp(&step(k, h)))) == here && features(&(at * exp(&step(k, -h)))) == here);
            let difference = |h: f64| {
                let value = |h: f64| model.blended_gap(&(at * exp(&step(k, h))), temperature).0;
                (value(h) - value(-h)) / (2.0 * h)
            };
            // Richardson, twice: the error falls as h².
            let (d1, d2, d4) = (difference(h), difference(h / 2.0), difference(h / 4.0));
            let (r1, r2) = ((4.0 * d2 - d1) / 3.0, (4.0 * d4 - d2) / 3.0);
            // Nor where one of the features has a kink within the steps: the differences then do
            // not settle.
            prop_assume!((d1 - d2).abs() <= 1e-5 && (r1 - r2).abs() <= 1e-7);
            let numeric = (16.0 * r2 - r1) / 15.0;
            let analytic = gradient.dot(&step(k, 1.0));
            prop_assert!((numeric - analytic).abs() <= 1e-7 * 0.02, "{}: {} {}", k, numeric, analytic);
        }
    }
}
