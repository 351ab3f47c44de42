//! Rest against analytic cases.

use nalgebra::{Point2, Point3, Vector3};

use super::equilibrium::{Equilibrium, Rest, Stiffness};
use crate::geometry::{GapQuery, Parts, Polygon, PrismPair};
use crate::se3::{self, Pose};

const STIFFNESS: Stiffness = Stiffness { translation: 3000.0, rotation: 50.0 };
const RADIUS: f64 = 0.0125;
/// What parts may overlap at rest (m).
const OVERLAP: f64 = 1e-6;

fn ball() -> Parts {
    Parts::OnPlane { points: vec![Point3::origin()], radius: RADIUS }
}

/// Force of the fixture on the tool, in the fixture's frame (N).
fn force(rest: &Rest) -> Vector3<f64> {
    rest.fixture_from_tool.rotation * se3::linear(&rest.wrench)
}

fn settle(equilibrium: &mut Equilibrium<'_>, x: f64, z: f64) -> Rest {
    equilibrium.settle(&Pose::translation(x, 0.0, z)).unwrap()
}

#[test]
fn a_ball_rests_on_the_plane_and_bears_what_the_spring_presses() {
    let parts = ball();
    let mut equilibrium = Equilibrium::new(&parts, STIFFNESS, 0.0, Pose::translation(0.0, 0.0, 0.02));
    let free = settle(&mut equilibrium, 1e-3, RADIUS + 1e-3);
    assert!(!free.touching && free.wrench.norm() < 1e-5);
    for depth in [1e-4, 1e-3, 1e-2] {
        let rest = settle(&mut equilibrium, 1e-3, RADIUS - depth);
        let gap = rest.fixture_from_tool.translation.z - RADIUS;
        assert!(rest.touching && (-OVERLAP..=0.0).contains(&gap), "{gap:e}");
        let wanted = Vector3::new(0.0, 0.0, STIFFNESS.translation * depth);
        assert!((force(&rest) - wanted).norm() < 1e-4 * wanted.norm(), "{}", force(&rest));
    }
}

#[test]
fn a_ball_is_seated_by_its_socket() {
    let mut equilibrium = Equilibrium::new(&Parts::BallInSocket, STIFFNESS, 0.0, Pose::translation(0.0, 0.0, 0.01));
    let command =
        Pose::translation(1e-3, -2e-3, -8e-3) * se3::exp(&se3::twist(&Vector3::zeros(), &Vector3::new(0.4, -0.3, 0.5)));
    let rest = equilibrium.settle(&command).unwrap();
    assert!(rest.fixture_from_tool.translation.vector.norm() < OVERLAP);
    // A ball in a socket turns freely.
    assert!(rest.fixture_from_tool.rotation.angle_to(&command.rotation) < 1e-9);
    assert!((force(&rest) + STIFFNESS.translation * command.translation.vector).norm() < 1e-3);
}

#[test]
fn a_peg_leans_on_one_wall() {
    let square = |half: f64| {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        Polygon::new(corners.map(Point2::from).to_vec()).unwrap()
    };
    let shapes = PrismPair::new(square(0.01), 0.04, square(0.0105), 0.03).unwrap();
    let parts = Parts::PegInHole(Box::new(shapes.clone()));
    let mut equilibrium = Equilibrium::new(&parts, STIFFNESS, 0.0, Pose::translation(0.0, 0.0, -0.015));
    let rest = settle(&mut equilibrium, 2e-3, -0.015);
    let at = rest.fixture_from_tool.translation.vector;
    assert!((at - Vector3::new(0.5e-3, 0.0, -0.015)).norm() < OVERLAP, "{at}");
    let gap = shapes.gap(&rest.fixture_from_tool).value;
    assert!((-OVERLAP..=1e-9).contains(&gap), "{gap:e}");
    let wanted = Vector3::new(-STIFFNESS.translation * 1.5e-3, 0.0, 0.0);
    assert!((force(&rest) - wanted).norm() < 1e-3 * wanted.norm(), "{}", force(&rest));
}

/// What slides is held back by μN against its motion; what is pulled less than that stays.
#[test]
fn friction_opposes_sliding_and_holds_what_is_pulled_less() {
    const FRICTION: f64 = 0.25;
    let parts = ball();
    let mut equilibrium = Equilibrium::new(&parts, STIFFNESS, FRICTION, Pose::translation(0.0, 0.0, RADIUS));
    let pressed = 4e-3;
    let normal = STIFFNESS.translation * pressed;
    let mut at = |x: f64| settle(&mut equilibrium, x, RADIUS - pressed);
    at(0.0);
    // Pulled by 2/3 of what it can bear: it sticks, but for the shear of its contact spring.
    let stuck = at(FRICTION * pressed * 2.0 / 3.0);
    // Its lowest point stays; the ball rolls a little about it, as its controller lets it turn.
    let lowest = stuck.fixture_from_tool
        * Point3::from(stuck.fixture_from_tool.rotation.inverse() * Vector3::new(0.0, 0.0, -RADIUS));
    assert!(lowest.x.abs() < 1e-5, "{}", lowest.x);
    let held = -force(&stuck).x;
    assert!(held < 0.9 * FRICTION * normal && held > 0.5 * FRICTION * normal, "{held} of {normal}");
    for (to, sign) in [(10.0, -1.0), (-10.0, 1.0)] {
        let steps = (1..=40).map(|step| step as f64 / 40.0);
        let slid = steps.fold(None, |_, share| Some(at(to * 1e-3 * share))).unwrap();
        let force = force(&slid);
        assert!((force.z - normal).abs() < 2e-3 * normal, "{force}");
        assert!((force.x - sign * FRICTION * force.z).abs() < 1e-3 * normal && force.y.abs() < 1e-6, "{force}");
        let lag = 1e-3 * to - slid.fixture_from_tool.translation.x;
        assert!((lag + sign * FRICTION * pressed).abs() < 1e-5, "{lag}");
    }
}
