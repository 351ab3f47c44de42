//! Simulated contacts with holes that are not as declared.

use nalgebra::{Matrix2, Point2, Vector2};
use touchcal::geometry::{EdgeRadii, GapQuery, Polygon, PrismPair};
use touchcal::sim::{self, Scenario, Truth};

use crate::simulation::{hole, paper};

#[test]
fn a_wider_and_deeper_hole_is_felt_as_drawn() {
    let mut scenario = Scenario { contact_sigma: 0.0, ..paper(300) };
    scenario.touches[0].clearance_sigma = 0.05e-3;
    scenario.touches[0].depth_sigma = 0.2e-3;
    let simulated = sim::simulate(&scenario, 6).unwrap();
    let Truth { clearance, depth, .. } = &simulated.truth;
    let wider = hole(&scenario).hole().offset_mitred(clearance[0]).unwrap();
    let believed = hole(&scenario);
    let deep = believed.depth() + depth[0];
    let parts = PrismPair::new(believed.peg().clone(), believed.length(), wider, deep).unwrap();
    for row in simulated.logs[0].truth.iter().filter(|row| row.force > 1.0) {
        assert!(parts.gap(&row.fixture_from_tool).value.abs() < 1e-6);
    }
    assert!(clearance[0].abs() > 1e-6 && depth[0].abs() > 1e-5);
    // What is drawn of the rest is the same without.
    let exact = sim::simulate(&Scenario { contact_sigma: 0.0, ..paper(300) }, 6).unwrap();
    assert_eq!(exact.truth.errors, simulated.truth.errors);
    assert_eq!((exact.truth.clearance[0], exact.truth.depth[0]), (0.0, 0.0));
}

#[test]
fn a_hole_wider_in_one_direction_is_felt_as_drawn() {
    let mut scenario = Scenario { contact_sigma: 0.0, ..paper(300) };
    scenario.touches[0].unequal_clearance_sigma = 0.05e-3;
    let simulated = sim::simulate(&scenario, 6).unwrap();
    let [x, y] = simulated.truth.unequal_clearance[0];
    let believed = hole(&scenario);
    // Walls across x are moved by x, those across y by y, and each vertex with both of its walls.
    let vertices = believed.hole().vertices();
    let normal = |i: usize| {
        let along = vertices[(i + 1) % vertices.len()] - vertices[i % vertices.len()];
        Vector2::new(along.y, -along.x).normalize()
    };
    let moved = (0..vertices.len()).map(|i| {
        let (before, after) = (normal(i + vertices.len() - 1), normal(i));
        let offset = |n: Vector2<f64>| x * n.x * n.x + y * n.y * n.y;
        let walls = Matrix2::from_rows(&[before.transpose(), after.transpose()]);
        vertices[i] + walls.try_inverse().unwrap() * Vector2::new(offset(before), offset(after))
    });
    let outline = Polygon::new(moved.collect()).unwrap();
    let parts = PrismPair::new(believed.peg().clone(), believed.length(), outline, believed.depth()).unwrap();
    for row in simulated.logs[0].truth.iter().filter(|row| row.force > 1.0) {
        assert!(parts.gap(&row.fixture_from_tool).value.abs() < 1e-6);
    }
    assert!(x.abs() > 1e-6 && y.abs() > 1e-6 && (x - y).abs() > 1e-6);
    let exact = sim::simulate(&Scenario { contact_sigma: 0.0, ..paper(300) }, 6).unwrap();
    assert_eq!(exact.truth.errors, simulated.truth.errors);
}

/// Contacts with worn edges fit the round shapes, and penetrate the sharp ones: below the mouth,
/// where a tilted edge touches a wall, by up to a fifth of the radius.
#[test]
fn worn_edges_are_felt() {
    let mut scenario = Scenario { contact_sigma: 0.0, ..paper(300) };
    scenario.touches[0].edge_wear = 0.2e-3;
    let simulated = sim::simulate(&scenario, 6).unwrap();
    let sharp = hole(&scenario);
    let worn = sharp.with_edge_radii(EdgeRadii { peg: 0.2e-3, hole: 0.2e-3 }).unwrap();
    let pressed = || simulated.logs[0].truth.iter().filter(|row| row.force > 1.0);
    assert!(pressed().all(|row| worn.gap(&row.fixture_from_tool).value.abs() < 1e-6));
    let inside = pressed().filter(|row| row.fixture_from_tool.translation.z < -1e-3);
    let deepest = inside.map(|row| sharp.gap(&row.fixture_from_tool).value).fold(0.0, f64::min);
    assert!((-40e-6..-5e-6).contains(&deepest), "{deepest}");
}

/// Each edge of the moved outline lies on the line at the distance of its normal, with slanted
/// edges and with a vertex on one of them.
#[test]
fn edges_move_by_the_distances_of_their_normals() {
    let third = Point2::new(0.01 - 0.02 / 3.0, 0.014 / 3.0);
    let corners = [Point2::new(-0.01, -0.002), Point2::new(0.01, 0.0), third, Point2::new(-0.01, 0.014)];
    let outline = Polygon::new(corners.to_vec()).unwrap();
    let distance = |normal: &Vector2<f64>| 1e-4 * normal.x.powi(2) - 5e-5 * normal.y.powi(2);
    let moved = outline.offset_mitred_by(distance).unwrap();
    for i in 0..corners.len() {
        let next = (i + 1) % corners.len();
        let along = outline.vertices()[next] - outline.vertices()[i];
        let normal = Vector2::new(along.y, -along.x).normalize();
        for vertex in [i, next] {
            let out = normal.dot(&(moved.vertices()[vertex] - outline.vertices()[i]));
            assert!((out - distance(&normal)).abs() < 1e-15, "{i}: {out:e}");
        }
    }
}
