//! Round pegs and holes come as polygons. How far a round peg has turned in a round hole no contact
//! tells, whatever their facets seem to say.

use crate::support::parts::{polygon, round_block, round_peg, solid};
use crate::support::solve;
use nalgebra::Vector3;
use touchcal::estimate::{Loss, Method, Noise, Warning};
use touchcal::experiment::{Search, Trial};
use touchcal::geometry::{GapQuery, MeshPair, Parts, PrismPair};
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::{ContactManifold, PegInHole, Residual};
use touchcal::se3::{Pose, adjoint};
use touchcal::sim::{Exploration, Preset};

const RADII: [f64; 2] = [12.5e-3, 13e-3];

fn of_sides(sides: usize) -> PrismPair {
    let [peg, hole] = RADII.map(|radius| polygon(radius, sides));
    PrismPair::new(peg, 0.04, hole, 0.03).unwrap()
}

/// An arm that touches with nearly round parts; its log with parts of other facets. Taken for
/// walls, these told joint 7 with an error of nine of its standard deviations. The largest of 14
/// errors exceeds 3.5 standard deviations by chance once in 150 times.
#[test]
#[ignore = "long form: scripts/test long"]
fn facets_tell_no_turn() {
    for seed in [1, 2] {
        let mut scenario =
            Preset::Paper.scenario(urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot).unwrap();
        scenario.contact_sigma = 20e-6;
        scenario.touches[0].exploration = Exploration {
            radius: 2e-3,
            tilt: 0.04,
            press: 3e-3,
            lift: 0.0,
            swing: 0.2,
            pace: 1.0,
            random_phases: false,
        };
        scenario.touches[0].parts = Parts::PegInHole(Box::new(of_sides(500)));
        let trial = Trial::simulated(&scenario, seed).unwrap();
        let noise = Noise { encoder: 3.5e-5, contact: 20e-6, is_estimated: false };
        let search = Search { method: Method::LevenbergMarquardt, noise, loss: Loss::GemanMcClure(3.0) };
        let estimate = solve(&trial.problem(Box::new(PegInHole::new(of_sides(128))), search));
        assert_eq!(estimate.warnings, [Warning::Unobservable { names: vec!["joint_offset.joint_a7".to_owned()] }]);
        let mut known = 0;
        for (column, truth) in &trial.truth {
            let found = estimate.parameters.iter().find(|p| p.parameter.id == *column).unwrap();
            if found.parameter.name == "joint_offset.joint_a7" {
                assert!(found.sigma.is_none() && !found.identifiable, "{found:?}");
                continue;
            }
            known += 1;
            let off = (found.value - truth) / found.sigma.unwrap();
            assert!(off.abs() < 3.5, "seed {seed}, {}: {off:.2} standard deviations", found.parameter.name);
        }
        assert_eq!(known, 7);
    }
}

/// Bodies of revolution that are not straight, too: their residual's derivative knows no turn about
/// either axis, though the gap between facets does.
#[test]
fn solids_of_revolution_have_no_turn() {
    let bodies = || MeshPair::new(solid(&round_peg(RADII[0], 0.04, 1e-3, 64)), solid(&round_block(RADII[1], 0.03, 64)));
    let manifold = PegInHole::with_depth(bodies(), 0.03);
    let (mut faceted, mut rows): (f64, Residual) = (0.0, Residual::new());
    for turn in 0..20 {
        let hole_from_peg =
            Pose::new(Vector3::new(0.4e-3, 0.1e-3, -0.02), Vector3::new(2e-3, 1e-3, 0.1 * f64::from(turn)));
        let mut about = touchcal::se3::Twist::zeros();
        about[5] = 1.0;
        let of_hole = adjoint(&hole_from_peg.inverse()) * about;
        rows.clear();
        manifold.residual(&hole_from_peg, 0.0, &mut rows);
        let gradient = rows.jacobian()[0];
        assert!(gradient.dot(&about).abs() < 1e-15 && gradient.dot(&of_hole).abs() < 1e-15, "{gradient:?}");
        let (_, of_facets) = bodies().blended_gap(&hole_from_peg, 0.0);
        faceted = faceted.max(of_facets.dot(&about).abs());
        assert!((gradient - of_facets).norm() < 0.1, "{gradient:?} {of_facets:?}");
    }
    assert!(faceted > 1e-4, "{faceted}");
}
