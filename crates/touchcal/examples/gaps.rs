//! Gaps between peg and hole, for comparison with other programs.
//!
//! `cargo run -p touchcal --example gaps -- extrusion25|square < poses.csv`: rows x,y,z (m),
//! qw,qx,qy,qz of the peg in the hole, no header; prints the gap (m) of a peg of 25 mm width and 40
//! mm length in a hole 0.5 mm wider on each side and 30 mm deep, and its six derivatives by a twist
//! of the peg in its frame.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "an example ends by panicking"
)]

use nalgebra::{Point2, Quaternion, Translation3, UnitQuaternion};
use touchcal::geometry::{GapQuery, Polygon, PrismPair};
use touchcal::se3::Pose;

fn outline(name: &str) -> Polygon {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    match name {
        "extrusion25" => Polygon::extrusion25(),
        "square" => Polygon::new(corners.map(|(x, y)| Point2::new(12.5e-3 * x, 12.5e-3 * y)).to_vec()).unwrap(),
        _ => panic!("expected extrusion25 or square, found {name}"),
    }
}

fn main() {
    let peg = outline(&std::env::args().nth(1).expect("a peg"));
    let hole = peg.offset_mitred(0.5e-3).unwrap();
    let parts = PrismPair::new(peg, 0.04, hole, 0.03).unwrap();
    for line in std::io::stdin().lines() {
        let numbers: Vec<f64> = line.unwrap().split(',').map(|number| number.trim().parse().unwrap()).collect();
        let [x, y, z, qw, qx, qy, qz] = numbers.try_into().expect("seven numbers");
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
        let gap = parts.gap(&Pose::from_parts(Translation3::new(x, y, z), turn));
        let numbers = std::iter::once(gap.value).chain(gap.gradient.iter().copied());
        println!("{}", numbers.map(|number| format!("{number:.17e}")).collect::<Vec<_>>().join(","));
    }
}
