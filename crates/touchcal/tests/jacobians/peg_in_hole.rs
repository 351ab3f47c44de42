//! Laws of the peg-in-hole gap and its manifold: derivatives against central differences, slope
//! through contact, near ties.

use std::f64::consts::TAU;

use nalgebra::{Point2, Rotation2, Translation3, Vector3, Vector6};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use touchcal::geometry::{
    EdgeRadii, Feature, GapQuery, Polygon, PrismPair, SignedGap, nearest_feature, visit_features_within,
};
use touchcal::manifold::{ContactManifold, PegInHole, Residual};
use touchcal::se3::{Pose, Twist, exp, twist};

fn model() -> PrismPair {
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5e-3).unwrap();
    PrismPair::new(peg, 0.04, hole, 0.03).unwrap()
}

fn pose(p: [f64; 3], w: [f64; 3]) -> Pose {
    let mut pose = exp(&twist(&Vector3::zeros(), &Vector3::from(w)));
    pose.translation.vector = Vector3::from(p);
    pose
}

/// Features within `margin` of the least.
fn ties(model: &PrismPair, pose: &Pose, margin: f64) -> Vec<(SignedGap, Feature)> {
    let mut found = Vec::new();
    visit_features_within(model, pose, margin, |gap, feature| found.push((gap.clone(), feature)));
    found
}

/// A step of one component: metres scaled to the peg's size, so that both kinds of component move
/// it alike.
fn step(k: usize, h: f64) -> Twist {
    let mut xi = Vector6::zeros();
    xi[k] = if k < 3 { h * 0.015 } else { h };
    xi
}

fn check_envelope(manifold: &PegInHole<PrismPair>, at: &Pose) -> Result<(), TestCaseError> {
    let rows = |pose: &Pose| {
        let mut rows = Residual::new();
        manifold.envelope(pose, &mut rows);
        rows
    };
    let here = rows(at);
    let h = 1e-4;
    for k in 0..6 {
        let difference = |h: f64| {
            let (up, down) = (rows(&(at * exp(&step(k, h)))), rows(&(at * exp(&step(k, -h)))));
            Vector6::from_fn(|i, _| (up.values()[i] - down.values()[i]) / (2.0 * h))
        };
        let numeric = (difference(h / 2.0) * 4.0 - difference(h)) / 3.0;
        for i in 0..6 {
            if i == 2 && (at.translation.z.abs() < 1e-4 || (at.translation.z + 0.03).abs() < 1e-4) {
                continue;
            }
            let analytic = here.jacobian()[i].dot(&step(k, 1.0));
            prop_assert!((numeric[i] - analytic).abs() <= 1e-7 * (1.0 + here.jacobian()[i].norm()), "{i} {k}");
        }
    }
    Ok(())
}

fn check_gradient(model: &PrismPair, at: &Pose) -> Result<(), TestCaseError> {
    let (gap, feature) = nearest_feature(model, at);
    // Only where one feature is least all around.
    let near = ties(model, at, 2e-6);
    prop_assume!(near.iter().all(|(_, other)| *other == feature));
    let h = 2e-5;
    for k in 0..6 {
        let difference = |h: f64| {
            let [(up, of_up), (down, of_down)] = [h, -h].map(|h| nearest_feature(model, &(at * exp(&step(k, h)))));
            (of_up == feature && of_down == feature).then(|| (up.value - down.value) / (2.0 * h))
        };
        let (Some(coarse), Some(fine)) = (difference(h), difference(h / 2.0)) else {
            return Err(TestCaseError::reject("another feature took over"));
        };
        // Richardson: the error falls as h².
        let numeric = (4.0 * fine - coarse) / 3.0;
        let analytic = gap.gradient.dot(&step(k, 1.0));
        prop_assert!((numeric - analytic).abs() <= 1e-7 * 0.02, "{k}: {numeric} {analytic} {:?}", gap);
    }
    Ok(())
}

/// The peg displaced to where it touches.
fn at_contact(model: &PrismPair, mut at: Pose) -> Pose {
    for _ in 0..30 {
        let gap = model.gap(&at);
        at = Translation3::from(-gap.normal_in_fixture * gap.value) * at;
    }
    at
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), max_global_rejects: 100_000, ..ProptestConfig::default() })]

    #[test]
    fn gradient_seated(p in [-1e-3..1e-3, -1e-3..1e-3, -0.03..-0.001], w in [-0.05..0.05, -0.05..0.05, -0.05..0.05]) {
        check_gradient(&model(), &pose(p, w))?;
    }

    #[test]
    fn gradient_with_round_edges(p in [-1e-3..1e-3, -1e-3..1e-3, -0.03..0.001], w in [-0.05..0.05, -0.05..0.05, -0.05..0.05]) {
        let model = model().with_edge_radii(EdgeRadii { peg: 0.2e-3, hole: 0.1e-3 }).unwrap();
        let at = pose(p, w);
        prop_assert!(ties(&model, &at, 1e-15).iter().any(|(gap, _)| gap.value == model.gap(&at).value));
        check_gradient(&model, &at)?;
    }

    /// At contact, where the same feature is nearest as with edges rounder by a nanometre.
    #[test]
    fn gap_by_edge_radius(p in [-1e-3..1e-3, -1e-3..1e-3, -0.028..-2e-3], w in [-0.05..0.05, -0.05..0.05, -0.05..0.05]) {
        let (sharp, at, radius) = (model(), at_contact(&model(), pose(p, w)), 1e-9);
        let (gap, feature) = nearest_feature(&sharp, &at);
        prop_assume!(gap.value.abs() < 1e-9);
        let rounder = sharp.with_edge_radii(EdgeRadii { peg: radius, hole: radius }).unwrap();
        let (farther, other) = nearest_feature(&rounder, &at);
        prop_assume!(feature == other);
        let normal_in_tool = at.rotation.inverse() * gap.normal_in_fixture;
        let derivative = PegInHole::new(sharp).gap_by_edge_radius(&normal_in_tool, &gap.normal_in_fixture);
        let numeric = (farther.value - gap.value) / radius;
        prop_assert!((numeric - derivative).abs() < 1e-5, "{feature:?}: {numeric} {derivative} {gap:?}");
    }

    #[test]
    fn gradient_on_top(p in [-0.02..0.02, -0.02..0.02, -2e-4..2e-3], w in [-0.1..0.1, -0.1..0.1, -1.0..1.0]) {
        check_gradient(&model(), &pose(p, w))?;
    }

    #[test]
    fn gradient_anywhere(p in [-0.03..0.03, -0.03..0.03, -0.01..0.05], w in [-2.0..2.0, -2.0..2.0, -2.0..2.0]) {
        check_gradient(&model(), &pose(p, w))?;
    }

    /// Every feature's distance goes straight through contact.
    #[test]
    fn no_kink_at_contact(p in [-1e-3..1e-3, -1e-3..1e-3, -0.028..-2e-3], w in [-0.03..0.03, -0.03..0.03, -0.03..0.03]) {
        let model = model();
        let at = at_contact(&model, pose(p, w));
        let gap = model.gap(&at);
        prop_assume!(gap.value.abs() < 1e-9);
        let near = ties(&model, &at, 120e-6);
        for s in [-50e-6, -20e-6, -1e-6, 1e-6, 20e-6, 50e-6] {
            let moved = model.gap(&(Translation3::from(gap.normal_in_fixture * s) * at)).value;
            let straight = near.iter().map(|(g, _)| g.value + s * g.normal_in_fixture.dot(&gap.normal_in_fixture));
            let straight = straight.fold(f64::INFINITY, f64::min);
            prop_assert!((moved - straight).abs() < 1e-9, "{s}: {moved} {straight} from {gap:?}");
        }
    }

    /// The gap cannot change faster than the fastest point of the peg moves.
    #[test]
    fn continuous_when_shallow(p in [-1e-3..1e-3, -1e-3..1e-3, -0.03..5e-4], w in [-0.03..0.03, -0.03..0.03, -0.03..0.03],
                  v in [-1.0..1.0, -1.0..1.0, -1.0..1.0], o in [-1.0..1.0, -1.0..1.0, -1.0..1.0]) {
        let model = model();
        let at = pose(p, w);
        let xi = twist(&(Vector3::from(v) * 1e-6), &(Vector3::from(o) * 1e-5));
        let (here, there) = (model.gap(&at), model.gap(&(at * exp(&xi))));
        prop_assume!(here.value > -0.1e-3);
        let most = xi.fixed_rows::<3>(0).norm() + 0.05 * xi.fixed_rows::<3>(3).norm();
        prop_assert!((here.value - there.value).abs() <= 1.001 * most, "{here:?} {there:?} {most}");
    }

    #[test]
    fn visits_the_least(p in [-1e-3..1e-3, -1e-3..1e-3, -0.03..1e-3], w in [-0.05..0.05, -0.05..0.05, -0.05..0.05]) {
        let model = model();
        let at = pose(p, w);
        let gap = model.gap(&at);
        let found = ties(&model, &at, 1e-4);
        let least = found.iter().map(|(g, _)| g.value).fold(f64::INFINITY, f64::min);
        prop_assert!(least == gap.value, "{least} {}", gap.value);
        prop_assert!(found.iter().all(|(g, _)| g.value <= gap.value + 1.000001e-4));
    }

    #[test]
    fn envelope_jacobian(p in [-0.1..0.1, -0.1..0.1, -0.1..0.1], axis in [-1.0..1.0, -1.0..1.0, -1.0..1.0], angle in 0.0..3.13_f64) {
        let axis = Vector3::<f64>::from(axis);
        prop_assume!(axis.norm() > 0.1);
        let w: Vector3<f64> = axis.normalize() * angle;
        let at = pose(p, [w.x, w.y, w.z]);
        let circle = |radius: f64| {
            let corner = |k: usize| Rotation2::new(TAU * k as f64 / 64.0) * Point2::new(radius, 0.0);
            Polygon::new((0..64).map(corner).collect()).unwrap()
        };
        let round = PrismPair::new(circle(0.01), 0.04, circle(0.0105), 0.03).unwrap();
        check_envelope(&PegInHole::new(model()), &at)?;
        check_envelope(&PegInHole::new(round), &at)?;
    }
}
