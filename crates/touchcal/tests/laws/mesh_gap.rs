//! The gap between bodies of any shape: that of the outlines where they are straight, parry's
//! distance where they are apart, and a gradient that is its derivative.

use crate::support::parts::{block, block_with, lofted, peg, polygon, round_block, round_peg, rounded, solid};
use nalgebra::{Point3, Translation3, Vector3};
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::TriMesh;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::geometry::{GapQuery, MeshPair, Polygon, PrismPair, TriangleMesh};
use touchcal::se3::{Pose, Twist, exp, twist};

const LENGTH: f64 = 0.04;
const DEPTH: f64 = 0.03;
/// Temperature of blends (m).
const TEMPERATURE: f64 = 25e-6;
/// How far the meshes may be from the outlines (m).
const AGREEMENT: f64 = 5e-6;

fn draw(chance: &mut Pcg64, xy: f64, z: (f64, f64), angle: f64) -> Pose {
    let mut each = |most: f64| most * chance.random_range(-1.0..=1.0);
    let turn = Vector3::new(each(angle), each(angle), each(angle));
    let (x, y) = (each(xy), each(xy));
    let mut pose = exp(&twist(&Vector3::zeros(), &turn));
    pose.translation.vector = Vector3::new(x, y, chance.random_range(z.0..z.1));
    pose
}

/// Pushed along a random direction until the gap of the outlines is nothing, then somewhat on or
/// back.
fn at_contact(chance: &mut Pcg64, straight: &PrismPair, angle: f64) -> Pose {
    loop {
        let mut pose = draw(chance, 0.4e-3, (-0.028, -0.004), angle);
        let direction = Vector3::from_fn(|_, _| chance.random_range(-1.0..=1.0)).normalize();
        if straight.gap(&pose).value <= 0.0 {
            continue;
        }
        for _ in 0..100 {
            pose = Translation3::from(direction * straight.gap(&pose).value) * pose;
        }
        if straight.gap(&pose).value.abs() < 1e-6 {
            return Translation3::from(direction * chance.random_range(-60e-6..=60e-6)) * pose;
        }
    }
}

/// Straight parts, as outlines and as meshes.
fn pairs() -> Vec<(&'static str, PrismPair, MeshPair)> {
    let pair = |outline: Polygon, hole: Polygon, peg_mesh: TriangleMesh, hole_mesh: TriangleMesh| {
        (PrismPair::new(outline, LENGTH, hole, DEPTH).unwrap(), MeshPair::new(peg_mesh, hole_mesh))
    };
    let slot = Polygon::extrusion25();
    let slot_hole = slot.offset_mitred(0.5e-3).unwrap();
    let square =
        Polygon::new([(-0.01, -0.01), (0.01, -0.01), (0.01, 0.01), (-0.01, 0.01)].map(|(x, y)| [x, y].into()).to_vec());
    let square = square.unwrap();
    let square_hole = square.offset_mitred(0.2e-3).unwrap();
    let meshes = |outline: &Polygon, hole: &Polygon| (solid(&peg(outline, LENGTH)), solid(&block(hole, DEPTH)));
    let (slot_meshes, square_meshes) = (meshes(&slot, &slot_hole), meshes(&square, &square_hole));
    let slot = pair(slot, slot_hole, slot_meshes.0, slot_meshes.1);
    let square = pair(square, square_hole, square_meshes.0, square_meshes.1);
    let round = pair(
        polygon(0.01, 40),
        polygon(0.0105, 40),
        solid(&round_peg(0.01, LENGTH, 0.0, 40)),
        solid(&round_block(0.0105, DEPTH, 40)),
    );
    vec![("T-slot", slot.0, slot.1), ("square", square.0, square.1), ("40 sides", round.0, round.1)]
}

#[test]
fn straight_meshes_agree_with_their_outlines() {
    let mut chance = Pcg64::seed_from_u64(1);
    for (name, straight, meshes) in pairs() {
        let mut worst = [0.0_f64; 4];
        let mut compare = |k: usize, outline: f64, mesh: f64| worst[k] = worst[k].max((outline - mesh).abs());
        for _ in 0..1500 {
            let touching = at_contact(&mut chance, &straight, 0.015);
            compare(0, straight.gap(&touching).value, meshes.gap(&touching).value);
            compare(1, straight.blended_gap(&touching, TEMPERATURE).0, meshes.blended_gap(&touching, TEMPERATURE).0);
            let near = draw(&mut chance, 0.3e-3, (-0.028, -0.004), 0.01);
            compare(2, straight.gap(&near).value, meshes.gap(&near).value);
            let at_rim = draw(&mut chance, 0.3e-3, (-0.004, 0.001), 0.015);
            let gap = straight.gap(&at_rim).value;
            if gap > -100e-6 {
                compare(3, gap, meshes.gap(&at_rim).value);
            }
        }
        let [contact, blended, near, at_rim] = worst;
        println!(
            "mesh against outline, {name} | {contact:e} m at contact, {blended:e} m blended, {near:e} m near it, {at_rim:e} m at the rim"
        );
        assert!(contact.max(near).max(at_rim) < AGREEMENT, "{name}");
        // A mean over what is near, of which there are somewhat other pieces.
        assert!(blended < 0.5 * TEMPERATURE, "{name}: {blended:e}");
    }
}

fn parry(solid: &TriangleMesh) -> TriMesh {
    let vertices = solid.vertices().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    TriMesh::new(vertices, solid.triangles().to_vec()).unwrap()
}

fn parry_pose(pose: &Pose) -> ParryPose {
    let q = pose.rotation.quaternion();
    let t = pose.translation.vector;
    ParryPose::from_parts(Vector::new(t.x, t.y, t.z), Rotation::from_xyzw(q.i, q.j, q.k, q.w))
}

/// Chamfered pegs, which no outline describes, in and above a hole.
#[test]
fn gaps_of_bodies_apart_are_parrys_distances() {
    let mut chance = Pcg64::seed_from_u64(2);
    let bodies = MeshPair::new(solid(&round_peg(0.01, LENGTH, 1e-3, 24)), solid(&round_block(0.0105, DEPTH, 24)));
    let (tool, fixture) = (parry(bodies.tool()), parry(bodies.fixture()));
    let (mut apart, mut overlapping, mut worst) = (0, 0, 0.0_f64);
    for k in 0..600 {
        let wide = if k % 2 == 0 { 1.0 } else { 8.0 };
        let pose = draw(&mut chance, wide * 0.4e-3, (-0.031, 0.01), wide * 0.02);
        let gap = bodies.gap(&pose).value;
        let place = parry_pose(&pose);
        if query::intersection_test(&place, &tool, &ParryPose::IDENTITY, &fixture).unwrap().intersecting {
            overlapping += 1;
            assert!(gap < 1e-9, "{k}: {gap:e} where the surfaces meet");
        } else {
            apart += 1;
            let distance = query::distance(&place, &tool, &ParryPose::IDENTITY, &fixture).unwrap().distance;
            worst = worst.max((gap - distance).abs());
            assert!((gap - distance).abs() < 1e-9, "{k}: {gap:e} {distance:e}");
        }
    }
    println!("mesh against parry, {apart} poses apart | {worst:e} m");
    assert!(apart > 150 && overlapping > 150, "{apart} {overlapping}");
}

#[test]
fn gradients_are_derivatives() {
    let mut chance = Pcg64::seed_from_u64(3);
    for (name, straight, meshes) in pairs() {
        let mut checked = 0;
        for _ in 0..100 {
            let pose = at_contact(&mut chance, &straight, 0.015);
            let gap = meshes.gap(&pose);
            for k in 0..6 {
                let mut step = Twist::zeros();
                step[k] = 1e-8;
                let [after, before] = [step, -step].map(|step| meshes.gap(&(pose * exp(&step))));
                // Not where another feature takes over.
                if (after.normal_in_fixture - before.normal_in_fixture).norm() > 1e-6
                    || (after.point_in_fixture - before.point_in_fixture).norm() > 1e-6
                {
                    continue;
                }
                checked += 1;
                let slope = (after.value - before.value) / 2e-8;
                assert!((slope - gap.gradient[k]).abs() < 1e-6, "{name} {k}: {slope} {}", gap.gradient[k]);
            }
        }
        assert!(checked > 300, "{name}: {checked}");
    }
}

#[test]
fn signed_distances_are_those_of_the_shape() {
    let slot = Polygon::extrusion25();
    let body = solid(&peg(&slot, LENGTH));
    let mut chance = Pcg64::seed_from_u64(4);
    for _ in 0..2000 {
        let point = Point3::from(Vector3::from_fn(|_, _| chance.random_range(-0.02..0.02)) + Vector3::z() * 0.02);
        let (across, along) = (slot.signed_distance(&point.xy()), (0.5 * LENGTH - point.z).abs() - 0.5 * LENGTH);
        let expected = if across > 0.0 && along > 0.0 { across.hypot(along) } else { across.max(along) };
        let (distance, foot) = body.signed_distance(&point);
        assert!((distance - expected).abs() < 1e-12, "{point}: {distance} {expected}");
        assert!(((point - foot).norm() - distance.abs()).abs() < 1e-12);
    }
    assert!((body.volume() - slot.area() * LENGTH).abs() < 1e-15);
}

/// However deep, an overlap is negative.
#[test]
fn deep_overlaps_are_negative() {
    let mut chance = Pcg64::seed_from_u64(5);
    for (name, straight, meshes) in pairs() {
        let mut overlaps = 0;
        for _ in 0..400 {
            let pose = draw(&mut chance, 8e-3, (-0.028, -0.01), 0.05);
            if straight.gap(&pose).value < 0.0 {
                overlaps += 1;
                assert!(
                    meshes.gap(&pose).value < 0.0,
                    "{name}: {} {}",
                    straight.gap(&pose).value,
                    meshes.gap(&pose).value
                );
            }
        }
        assert!(overlaps > 300);
    }
}

/// A T-slot and its hole with corners rounded by seven points, both chamfered: no outline describes
/// them.
fn chamfered_and_rounded() -> MeshPair {
    let slot = Polygon::extrusion25();
    let at = |distance: f64, radius: f64| rounded(&slot.offset_mitred(distance).unwrap(), radius, 7);
    let peg = lofted(&[(&at(-0.2e-3, 0.2e-3), 0.0), (&at(0.0, 0.4e-3), 0.4e-3), (&at(0.0, 0.4e-3), LENGTH)]);
    let (mouth, wall) = (at(0.8e-3, 0.5e-3), at(0.5e-3, 0.4e-3));
    MeshPair::new(solid(&peg), solid(&block_with(&[(&mouth, 0.0), (&wall, -0.3e-3), (&wall, -DEPTH)], DEPTH + 0.01)))
}

/// Straight parts, and others.
fn all_pairs() -> Vec<(&'static str, MeshPair)> {
    let round = MeshPair::new(solid(&round_peg(0.0125, LENGTH, 1e-3, 60)), solid(&round_block(0.013, DEPTH, 60)));
    let straight = pairs().into_iter().map(|(name, _, meshes)| (name, meshes));
    straight.chain([("chamfered", chamfered_and_rounded()), ("chamfered round", round)]).collect()
}

/// What is near is kept from pose to pose, however far they go and however far is asked: what is
/// visited is what a new search finds.
#[test]
fn what_is_kept_is_what_is_found() {
    let mut chance = Pcg64::seed_from_u64(7);
    for (name, meshes) in all_pairs() {
        let (mut visited, mut compared) = (0, 0);
        for _ in 0..40 {
            // Down to the floor, if there is one.
            let mut pose = draw(&mut chance, 0.5e-3, (-DEPTH - 0.1e-3, -0.004), 0.01);
            let mut neighbors = None;
            for _ in 0..25 {
                // From a tenth of a micrometre to a millimetre.
                let size = 10.0_f64.powf(chance.random_range(-7.0..-3.0));
                let step =
                    Twist::from_fn(|k, _| size * chance.random_range(-1.0..=1.0) / if k < 3 { 1.0 } else { 0.01 });
                pose *= exp(&step);
                let reach = 0.2e-3 * chance.random_range(0.3..1.0);
                let below = |neighbors: &mut _| {
                    let mut found = Vec::new();
                    meshes.visit_below(&pose, reach, neighbors, &mut |gap| found.push(gap.clone()));
                    found
                };
                let (kept, found) = (below(&mut neighbors), below(&mut None));
                assert_eq!(kept, found, "{name}");
                visited += found.len();
                // The least of it is the gap, for which trees are searched as far as they must be.
                let gap = meshes.gap(&pose).value;
                let least = found.iter().map(|gap| gap.value).fold(f64::INFINITY, f64::min);
                if gap < reach {
                    compared += 1;
                    assert!((least - gap).abs() < 1e-15, "{name}: {least:e} {gap:e}");
                } else {
                    assert!(found.is_empty(), "{name}: {least:e} {gap:e}");
                }
            }
        }
        println!("{name} | {visited} visited, {compared} of 1000 least ones compared");
        assert!(visited > 5000 && compared > 300, "{name}: {visited} {compared}");
    }
}

/// However straight parts are cut into triangles, a corner of the tip that is just above the floor
/// and inside a wall is told of both.
#[test]
fn a_corner_in_a_hollow_corner_is_told_of_both() {
    let slot = Polygon::extrusion25();
    let hole = slot.offset_mitred(0.5e-3).unwrap();
    let meshes = MeshPair::new(solid(&peg(&slot, LENGTH)), solid(&block(&hole, DEPTH)));
    let mut chance = Pcg64::seed_from_u64(8);
    for _ in 0..200 {
        // Against a wall in x or y, 20 µm into it, anywhere along.
        let (into, along) = (0.52e-3, 0.4e-3 * chance.random_range(-1.0..=1.0));
        let (side, height) = (chance.random_range(0..4), 10e-6 * chance.random_range(0.2..1.0));
        let (x, y) = [(into, along), (-into, along), (along, into), (along, -into)][side];
        let pose = Pose::translation(x, y, height - DEPTH);
        let (mut wall, mut floor) = (0, 0);
        meshes.visit_below(&pose, 0.1e-3, &mut None, &mut |gap| {
            wall += usize::from((gap.value + 20e-6).abs() < 1e-12);
            floor += usize::from((gap.value - height).abs() < 1e-12 && gap.normal_in_fixture.z > 0.999);
        });
        assert!(wall > 0 && floor >= 36, "{x} {y} {height}: {wall} {floor}");
    }
}

/// No overlap is deeper than the way to where the peg is free. Where corners are rounded by many
/// edges, most overlaps of a millimetre once were forty deep, between edges on opposite sides.
#[test]
fn overlaps_are_no_deeper_than_the_way_back() {
    let mut chance = Pcg64::seed_from_u64(6);
    for (name, meshes) in all_pairs() {
        let (mut overlaps, mut deepest) = (0, 0.0_f64);
        for k in 0..200 {
            let wide = if k % 2 == 0 { 1.5e-3 } else { 6e-3 };
            let pose = draw(&mut chance, wide, (-0.028, -0.004), 20.0 * wide);
            let free = Pose::from_parts(Translation3::new(0.0, 0.0, pose.translation.z), Default::default());
            assert!(meshes.gap(&free).value > 0.0, "{name}");
            let way = meshes.tool().vertices().map(|v| (pose * v - free * v).norm()).fold(0.0, f64::max);
            let gap = meshes.gap(&pose).value;
            overlaps += usize::from(gap < 0.0);
            deepest = deepest.max(-gap / way);
            assert!(gap > -way, "{name}, {k}: {gap} where {way} leads back");
            let (blended, _) = meshes.blended_gap(&pose, TEMPERATURE);
            assert!((blended - gap).abs() < 4.0 * TEMPERATURE, "{name}, {k}: {gap} {blended}");
        }
        println!("{name} | {overlaps} overlaps, at most {deepest:.2} of the way back");
        assert!(overlaps > 100, "{name}: {overlaps}");
    }
}
