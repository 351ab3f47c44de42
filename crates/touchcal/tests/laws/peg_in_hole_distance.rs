//! The gap against an independent reference: distances between boxes by GJK (parry3d).

use crate::support::{report, spread};
use nalgebra::{Point2, Vector3};
use parry3d_f64::glamx::{DPose3, DQuat, DVec3};
use parry3d_f64::query;
use parry3d_f64::shape::Cuboid;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use touchcal::geometry::{EdgeRadii, Polygon, PrismPair, nearest_feature};
use touchcal::se3::{Pose, exp, twist};

const LENGTH: f64 = 0.04;
const DEPTH: f64 = 0.03;
/// Greatest error (m) where parts are apart: rounding.
const LIMIT: f64 = 1e-12;
/// Gap (m) below which parts may count as touching or not.
const TOUCHING: f64 = 1e-6;

/// Boxes `[x0, x1] × [y0, y1] × [z0, z1]`, in metres.
type Boxes = Vec<(DVec3, DVec3)>;

/// Bodies made of boxes that are dilated by a ball of `edge_radius` (m).
struct Reference {
    peg: Boxes,
    hole: Boxes,
    edge_radius: f64,
}

/// The four turns by 90° of a rectangle of the plane, given in mm.
fn turned(quarter: &[[f64; 4]], z: (f64, f64)) -> Boxes {
    let mut boxes = Vec::new();
    for &[x0, x1, y0, y1] in quarter {
        for (c, s) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
            let (ax, ay, bx, by) = (c * x0 - s * y0, s * x0 + c * y0, c * x1 - s * y1, s * x1 + c * y1);
            let low = DVec3::new(ax.min(bx) * 1e-3, ay.min(by) * 1e-3, z.0);
            let high = DVec3::new(ax.max(bx) * 1e-3, ay.max(by) * 1e-3, z.1);
            boxes.push((low, high));
        }
    }
    boxes
}

impl Reference {
    fn square() -> Self {
        let mut hole = turned(&[[13.0, 300.0, -300.0, 300.0]], (-DEPTH, 0.0));
        hole.push(floor());
        Reference { peg: turned(&[[-12.5, 12.5, -12.5, 12.5]], (0.0, LENGTH)), hole, edge_radius: 0.0 }
    }

    fn extrusion25() -> Self {
        let peg = turned(
            &[[-6.0, 6.0, -6.0, 6.0], [5.5, 12.5, 5.5, 12.5], [3.5, 5.5, 10.5, 12.5], [10.5, 12.5, 3.5, 5.5]],
            (0.0, LENGTH),
        );
        let mut hole =
            turned(&[[13.0, 300.0, -300.0, 300.0], [10.0, 13.0, -3.0, 3.0], [6.5, 10.0, -5.0, 5.0]], (-DEPTH, 0.0));
        hole.push(floor());
        Reference { peg, hole, edge_radius: 0.0 }
    }

    /// The same with edges of 0.2 mm: each face is 0.2 mm further inside before dilation.
    fn extrusion25_with_round_edges() -> Self {
        let r = 0.2;
        let peg = turned(
            &[[-5.8, 5.8, -5.8, 5.8], [5.7, 12.3, 5.7, 12.3], [3.7, 5.7, 10.7, 12.3], [10.7, 12.3, 3.7, 5.7]],
            (1e-3 * r, LENGTH - 1e-3 * r),
        );
        let mut hole = turned(
            &[[13.2, 300.0, -300.0, 300.0], [9.8, 13.2, -2.8, 2.8], [6.7, 9.8, -4.8, 4.8]],
            (-DEPTH - 1e-3 * r, -1e-3 * r),
        );
        hole.push((DVec3::new(-0.3, -0.3, -0.3), DVec3::new(0.3, 0.3, -DEPTH - 1e-3 * r)));
        Reference { peg, hole, edge_radius: 1e-3 * r }
    }

    fn small_square_in_slots() -> Self {
        let peg = turned(&[[-4.0, 4.0, -4.0, 4.0]], (0.0, LENGTH));
        Reference { peg, ..Reference::extrusion25() }
    }

    /// Signed distance between peg and hole: exact where their boxes are apart, minus twice the
    /// edge radius where these overlap.
    fn distance(&self, hole_from_peg: &Pose) -> f64 {
        let q = hole_from_peg.rotation.coords;
        let t = hole_from_peg.translation.vector;
        let rotation = DQuat::from_xyzw(q.x, q.y, q.z, q.w);
        let translation = DVec3::new(t.x, t.y, t.z);
        let mut least = f64::INFINITY;
        for &(p0, p1) in &self.peg {
            let peg_pose = DPose3::from_parts(translation + rotation * ((p0 + p1) * 0.5), rotation);
            for &(h0, h1) in &self.hole {
                let hole_pose = DPose3::from_translation((h0 + h1) * 0.5);
                let (peg, hole) = (Cuboid::new((p1 - p0) * 0.5), Cuboid::new((h1 - h0) * 0.5));
                least = least.min(query::distance(&hole_pose, &hole, &peg_pose, &peg).unwrap().distance);
            }
        }
        least - 2.0 * self.edge_radius
    }
}

fn floor() -> (DVec3, DVec3) {
    (DVec3::new(-0.3, -0.3, -0.3), DVec3::new(0.3, 0.3, -DEPTH))
}

fn model(outline: Polygon) -> PrismPair {
    let hole = outline.offset_mitred(0.5e-3).unwrap();
    PrismPair::new(outline, LENGTH, hole, DEPTH).unwrap()
}

fn square(half: f64) -> Polygon {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Polygon::new(corners.iter().map(|&(x, y)| Point2::new(half * x, half * y)).collect()).unwrap()
}

/// A region of poses: translation and rotation vector drawn uniformly within ± `spread` of
/// `centre`.
struct Region {
    name: &'static str,
    centre: [f64; 6],
    spread: [f64; 6],
}

const fn region(name: &'static str, z: (f64, f64), xy: f64, tilt: f64, yaw: f64) -> Region {
    Region {
        name,
        centre: [0.0, 0.0, (z.0 + z.1) / 2.0, 0.0, 0.0, 0.0],
        spread: [xy, xy, (z.1 - z.0) / 2.0, tilt, tilt, yaw],
    }
}

const REGIONS: [Region; 10] = [
    region("inside, loose", (-0.03, -0.005), 3e-3, 0.1, 3.0),
    region("seated", (-0.03, -0.005), 0.4e-3, 0.015, 0.02),
    region("near seated, wider", (-0.03, -0.001), 1e-3, 0.03, 0.05),
    region("at the rim", (-0.002, 0.002), 1e-3, 0.05, 0.05),
    region("resting on the top", (-0.0002, 0.0005), 8e-3, 0.01, 0.3),
    region("beside and above", (-0.002, 0.01), 20e-3, 0.3, 3.0),
    region("above, tilted", (0.0, 0.02), 10e-3, 0.7, 3.0),
    region("anywhere, any rotation", (-0.02, 0.06), 30e-3, 2.2, 2.2),
    region("aligned", (-0.03, 0.002), 0.6e-3, 0.0, 0.0),
    region("on its side", (0.0, 0.04), 20e-3, 1.8, 0.1),
];

impl Region {
    fn sample(&self, rng: &mut StdRng) -> Pose {
        let mut x = self.centre;
        for (x, spread) in x.iter_mut().zip(self.spread) {
            *x += spread * rng.random_range(-1.0..=1.0);
        }
        let mut pose = exp(&twist(&Vector3::zeros(), &Vector3::new(x[3], x[4], x[5])));
        pose.translation.vector = Vector3::new(x[0], x[1], x[2]);
        pose
    }
}

/// Compares and prints, by region; returns how many poses disagree.
fn compare(name: &str, model: &PrismPair, reference: &Reference, poses: usize) -> usize {
    let mut rng = StdRng::seed_from_u64(7);
    let mut failures = 0;
    let mut errors = Vec::new();
    let mut all_signs = 0;
    for region in &REGIONS {
        let (mut free, mut worst, mut off, mut signs) = (0, 0.0_f64, 0, 0);
        for _ in 0..poses {
            let pose = region.sample(&mut rng);
            let (gap, feature) = nearest_feature(model, &pose);
            let distance = reference.distance(&pose);
            if distance + 2.0 * reference.edge_radius > 1e-5 {
                free += 1;
                let error = (gap.value - distance).abs();
                worst = worst.max(error);
                errors.push(error);
                if error > LIMIT {
                    off += 1;
                    if off < 4 {
                        println!(
                            "  gap {:.9} reference {distance:.9} {:?} at {:?}",
                            gap.value,
                            feature,
                            touchcal::se3::log(&pose).as_slice()
                        );
                    }
                }
            }
            if gap.value.abs() > TOUCHING && (distance <= 0.0) != (gap.value < 0.0) {
                signs += 1;
                if signs < 4 {
                    println!(
                        "  sign: gap {:.9} reference {distance:.9} {:?} at {:?}",
                        gap.value,
                        feature,
                        touchcal::se3::log(&pose).as_slice()
                    );
                }
            }
        }
        println!(
            "{name}, {}: {poses} poses, {free} free, worst error {worst:.1e} m, {off} beyond {LIMIT:e}, {signs} signs differ",
            region.name
        );
        failures += off + signs;
        all_signs += signs;
    }
    let counts = [("apart", errors.len() as f64), ("signs", all_signs as f64), ("limit", LIMIT)];
    report(name, &[spread(errors).as_slice(), &counts].concat());
    failures
}

#[test]
fn extrusion25_agrees_with_boxes() {
    assert_eq!(compare("extrusion25", &model(Polygon::extrusion25()), &Reference::extrusion25(), 3000), 0);
}

#[test]
fn square_agrees_with_boxes() {
    assert_eq!(compare("square", &model(square(12.5e-3)), &Reference::square(), 3000), 0);
}

/// A peg that can turn in its hole: corner against corner, longitudinal edges against wall corners.
#[test]
fn small_square_in_slots_agrees_with_boxes() {
    let hole = Polygon::extrusion25().offset_mitred(0.5e-3).unwrap();
    let model = PrismPair::new(square(4e-3), LENGTH, hole, DEPTH).unwrap();
    assert_eq!(compare("small square", &model, &Reference::small_square_in_slots(), 3000), 0);
}

/// Edges round, apart and in penetration up to twice their radius.
#[test]
fn extrusion25_with_round_edges_agrees_with_boxes() {
    let radii = EdgeRadii { peg: 0.2e-3, hole: 0.2e-3 };
    let model = model(Polygon::extrusion25()).with_edge_radii(radii).unwrap();
    assert_eq!(compare("round edges", &model, &Reference::extrusion25_with_round_edges(), 3000), 0);
}

/// Where only one of the parts has round edges, a tilted peg in a wide hole is as far from the
/// wall, the rim or the floor as a circle of that radius is.
#[test]
fn round_edges_of_one_part_touch_as_circles_do() {
    let (half, tilt, r): (f64, f64, f64) = (12.5e-3, 0.1, 0.4e-3);
    let (sine, cosine) = tilt.sin_cos();
    let sharp = PrismPair::new(square(half), LENGTH, square(half + 3e-3), DEPTH).unwrap();
    let of = |peg: f64, hole: f64| sharp.with_edge_radii(EdgeRadii { peg, hole }).unwrap();
    // From a right corner to the arc that replaces it, along a normal at `tilt` to one side.
    let recess = r * (sine + cosine - 1.0);
    let tilted = |x: f64, z: f64| {
        let mut pose = exp(&twist(&Vector3::zeros(), &Vector3::new(0.0, tilt, 0.0)));
        pose.translation.vector = Vector3::new(x, 0.0, z);
        pose
    };
    // The tip's edge against the wall at −x, the peg's side against the rim at +x, the tip's edge
    // against the floor.
    let cases = [
        (tilted(-2e-3, -0.02), of(r, 0.0), "CornerWall"),
        (tilted(0.4e-3, -0.02), of(0.0, r), "Rim"),
        (tilted(-1e-3, -DEPTH + 1.3e-3), of(r, 0.0), "CornerFloor"),
    ];
    for (pose, rounded, expected) in cases {
        let ((before, feature), (after, _)) = (nearest_feature(&sharp, &pose), nearest_feature(&rounded, &pose));
        assert!(format!("{feature:?}").contains(expected), "{feature:?}");
        assert!((after.value - before.value - recess).abs() < LIMIT, "{} {}", after.value - before.value, recess);
    }
}

#[test]
fn edge_radii_that_parts_cannot_have_are_refused() {
    let sharp = model(Polygon::extrusion25());
    let refused = [(-1e-4, 0.0), (f64::NAN, 0.0), (0.3e-3, 0.0), (0.0, -1e-4), (0.0, 2.0e-3), (0.0, f64::INFINITY)];
    for (peg, hole) in refused {
        assert!(sharp.with_edge_radii(EdgeRadii { peg, hole }).is_err(), "{peg} {hole}");
    }
    // A step of 0.1 mm has no room for the round of its convex corner, and a hole of 30 mm none for
    // a rim of that radius.
    let step = [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (1.0, 5.0), (1.0, 5.1), (-5.0, 5.1)];
    let step = Polygon::new(step.iter().map(|&(x, y)| Point2::new(1e-3 * x, 1e-3 * y)).collect()).unwrap();
    let stepped = PrismPair::new(step, LENGTH, square(6e-3), DEPTH).unwrap();
    assert!(stepped.with_edge_radii(EdgeRadii { peg: 0.2e-3, hole: 0.0 }).is_err());
    assert!(stepped.with_edge_radii(EdgeRadii { peg: 0.05e-3, hole: 0.0 }).is_ok());
    assert!(stepped.with_edge_radii(EdgeRadii { peg: 0.0, hole: DEPTH }).is_err());
    let rounded = sharp.with_edge_radii(EdgeRadii { peg: 0.2e-3, hole: 0.1e-3 }).unwrap();
    assert_eq!((rounded.peg(), rounded.hole()), (sharp.peg(), sharp.hole()));
    assert_eq!((rounded.length(), rounded.depth()), (LENGTH, DEPTH));
}
