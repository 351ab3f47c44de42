//! Meshes of straight parts are told from others, and have the outlines that they were made of.

use crate::support::parts;
use crate::support::parts::{
    Mesh, block, block_around, cells, lofted, peg, polygon, round_block, round_peg, rounded, stl,
};
use nalgebra::{Point2, Translation3};
use touchcal::geometry::{GapQuery, MeshPair, Polygon, PrismPair, prisms_of};
use touchcal::io::mesh;
use touchcal::manifold::peg_in_hole;

const LENGTH: f64 = 0.04;
const DEPTH: f64 = 0.03;
/// What STL's digits do to parts of 60 mm (m).
const DIGITS: f64 = 1e-8;

/// Both by way of STL files.
fn read(peg: &Mesh, hole: &Mesh) -> MeshPair {
    let read = |mesh: &Mesh| mesh::read(&stl(mesh), "part.stl", 1e-3).unwrap();
    MeshPair::new(read(peg), read(hole))
}

fn found(peg: &Mesh, hole: &Mesh) -> Option<PrismPair> {
    prisms_of(&read(peg, hole), DEPTH)
}

/// Whether two outlines are the same points in the same order, from wherever.
fn assert_same(found: &Polygon, expected: &Polygon) {
    assert_eq!(found.len(), expected.len());
    let apart = |a: &Point2<f64>, b: &Point2<f64>| (a - b).norm();
    let (n, first) = (found.len(), expected.vertices()[0]);
    let nearest = |best: usize, i: usize| {
        if apart(&found.vertices()[i], &first) < apart(&found.vertices()[best], &first) { i } else { best }
    };
    let begin = (0..n).fold(0, nearest);
    for (k, vertex) in expected.vertices().iter().enumerate() {
        let other = &found.vertices()[(begin + k) % n];
        assert!(apart(vertex, other) < DIGITS, "{k}: {vertex} {other}");
    }
}

fn slot() -> (Polygon, Polygon) {
    (Polygon::extrusion25(), Polygon::extrusion25().offset_mitred(0.5e-3).unwrap())
}

#[test]
fn straight_parts_have_their_outlines() {
    let (slot, slot_hole) = slot();
    let (round, round_hole) = (rounded(&slot, 0.4e-3, 7), rounded(&slot_hole, 0.4e-3, 7));
    let deep = DEPTH + 0.01;
    let cases = [
        // Cut up into more triangles than it needs, on its faces and along its edges.
        (&slot, &slot_hole, peg(&slot, LENGTH), block(&slot_hole, DEPTH), DEPTH),
        (
            &round,
            &round_hole,
            lofted(&[(&round, 0.0), (&round, LENGTH)]),
            block_around(&round_hole, DEPTH, deep),
            DEPTH,
        ),
        // Through the block: no floor that the peg could touch.
        (
            &round,
            &round_hole,
            lofted(&[(&round, 0.0), (&round, LENGTH)]),
            block_around(&round_hole, deep, deep),
            deep + LENGTH,
        ),
        (
            &polygon(0.01, 200),
            &polygon(0.0105, 200),
            round_peg(0.01, LENGTH, 0.0, 200),
            round_block(0.0105, DEPTH, 200),
            DEPTH,
        ),
    ];
    for (outline, hole, peg_mesh, hole_mesh, depth) in cases {
        let found = found(&peg_mesh, &hole_mesh).unwrap();
        assert_same(found.peg(), outline);
        assert_same(found.hole(), hole);
        assert!(
            (found.length() - LENGTH).abs() < DIGITS && (found.depth() - depth).abs() < DIGITS,
            "{}",
            found.depth()
        );
    }
}

#[test]
fn parts_that_are_not_straight_are_none() {
    let (slot, slot_hole) = slot();
    let (round, smaller) = (polygon(0.01, 24), polygon(0.0099, 24));
    let (straight, pocket) = (round_peg(0.01, LENGTH, 0.0, 24), round_block(0.0105, DEPTH, 24));
    assert!(found(&straight, &pocket).is_some());
    let chamfered = round_peg(0.01, LENGTH, 1e-3, 24);
    let cone = lofted(&[(&smaller, 0.0), (&round, LENGTH)]);
    let above = lofted(&[(&round, 1e-5), (&round, LENGTH)]);
    let step = |narrow: f64, at: f64, wide: f64| {
        let xs = [-wide, -narrow, narrow, wide];
        cells([&xs, &xs, &[0.0, at, LENGTH]], |p| p.z > at || (p.x.abs() < narrow && p.y.abs() < narrow))
    };
    // A hundredth of a millimetre is no rounding.
    for (name, peg) in
        [("chamfer", &chamfered), ("cone", &cone), ("not at z = 0", &above), ("step", &step(0.00699, 1e-3, 0.007))]
    {
        assert!(found(peg, &pocket).is_none(), "{name}");
    }
    let widening = |wide: f64| {
        let hole =
            [(0.0, -DEPTH - 0.01), (0.03, -DEPTH - 0.01), (0.03, 0.0), (wide, 0.0), (0.0105, -DEPTH), (0.0, -DEPTH)];
        parts::turned(&hole, 24)
    };
    let stepped = |depth: f64| {
        let line = [
            (0.0, -0.05),
            (0.03, -0.05),
            (0.03, 0.0),
            (0.0105, 0.0),
            (0.0105, -depth),
            (0.008, -depth),
            (0.008, -0.04),
            (0.0, -0.04),
        ];
        parts::turned(&line, 24)
    };
    // As deep as the peg goes, its lower edge is within reach.
    let through = block_around(&polygon(0.0105, 24), DEPTH, DEPTH);
    let [xs, ys] = parts::lines(&slot_hole, &[-0.03, 0.02, 0.03]);
    let two = cells([&xs, &ys, &[-0.04, -DEPTH, 0.0]], |p| {
        p.z < -DEPTH || !(slot_hole.contains(&p.xy()) || (p.x > 0.02 && p.y.abs() < 0.01))
    });
    // A ledge beside the block, as large as the hole and as deep as a floor would be.
    let xs = [-0.03, -0.01, 0.01, 0.03, 0.05];
    let ledge = cells([&xs, &[-0.03, -0.01, 0.01, 0.03], &[-0.05, -DEPTH, 0.0]], |p| {
        let is_hole = p.x.abs() < 0.01 && p.y.abs() < 0.01;
        let is_beside = p.x > 0.03;
        !is_hole && (!is_beside || (p.z < -DEPTH && p.y.abs() < 0.01))
    });
    assert!(found(&straight, &ledge).is_none());
    for (name, hole) in
        [("funnel", &widening(0.01051)), ("two steps", &stepped(0.01)), ("through", &through), ("open side", &two)]
    {
        assert!(found(&straight, hole).is_none(), "{name}");
    }
    let without = cells([&[-0.03, 0.03], &[-0.03, 0.03], &[-0.03, 0.0]], |_| true);
    assert!(found(&peg(&slot, LENGTH), &without).is_none());
}

#[test]
fn contact_is_that_of_outlines_where_parts_are_straight() {
    let (slot, slot_hole) = slot();
    let straight = peg_in_hole(read(&peg(&slot, LENGTH), &block(&slot_hole, DEPTH)), DEPTH).unwrap();
    let chamfered =
        peg_in_hole(read(&round_peg(0.01, LENGTH, 1e-3, 24), &round_block(0.0105, DEPTH, 24)), DEPTH).unwrap();
    assert_eq!([straight.name(), chamfered.name()], ["peg in hole", "peg in hole, round, not straight"]);
    let outlines = PrismPair::new(slot, LENGTH, slot_hole, DEPTH).unwrap();
    for (x, z) in [(0.0, -0.01), (0.3e-3, -0.02), (0.5e-3, -0.015), (0.52e-3, -0.025)] {
        let pose = Translation3::new(x, 0.0, z).into();
        let mut rows = touchcal::manifold::Residual::new();
        straight.residual(&pose, 0.0, &mut rows);
        let gap = outlines.gap(&pose).value;
        assert!((rows.values()[0] - gap).abs() < DIGITS, "{x}: {} {gap}", rows.values()[0]);
    }
}
