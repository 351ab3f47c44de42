//! The gap against an independent reference: distances between boxes by GJK (parry3d).

use crate::support::{report, spread};
use nalgebra::{Point2, Vector3};
use parry3d_f64::glamx::{DPose3, DQuat, DVec3};
use parry3d_f64::query;
use parry3d_f64::shape::Cuboid;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use touchcal::geometry::{Polygon, PrismPair, nearest_feature};
use touchcal::se3::{Pose, exp, twist};

const LENGTH: f64 = 0.04;
const DEPTH: f64 = 0.03;
/// Greatest error (m) where parts are apart: rounding.
const LIMIT: f64 = 1e-12;
/// Gap (m) below which parts may count as touching or not.
const TOUCHING: f64 = 1e-6;

/// Boxes `[x0, x1] × [y0, y1] × [z0, z1]`, in metres.
type Boxes = Vec<(DVec3, DVec3)>;

struct Reference {
    peg: Boxes,
    hole: Boxes,
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
        Reference { peg: turned(&[[-12.5, 12.5, -12.5, 12.5]], (0.0, LENGTH)), hole }
    }

    fn extrusion25() -> Self {
        let peg = turned(
            &[[-6.0, 6.0, -6.0, 6.0], [5.5, 12.5, 5.5, 12.5], [3.5, 5.5, 10.5, 12.5], [10.5, 12.5, 3.5, 5.5]],
            (0.0, LENGTH),
        );
        let mut hole =
            turned(&[[13.0, 300.0, -300.0, 300.0], [10.0, 13.0, -3.0, 3.0], [6.5, 10.0, -5.0, 5.0]], (-DEPTH, 0.0));
        hole.push(floor());
        Reference { peg, hole }
    }

    fn small_square_in_slots() -> Self {
        Reference { peg: turned(&[[-4.0, 4.0, -4.0, 4.0]], (0.0, LENGTH)), hole: Reference::extrusion25().hole }
    }

    /// Distance between peg and hole, 0 where they overlap.
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
        least
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
            if distance > 1e-5 {
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
