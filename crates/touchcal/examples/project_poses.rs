//! Where a learned projection puts poses, for comparison with other programs that run the same
//! network.
//!
//! `cargo run -p touchcal --example project_poses -- weights.safetensors < poses.csv`: rows x,y,z
//! (m), roll,pitch,yaw (rad), no header; prints theirs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, reason = "an example ends by panicking")]

use std::path::Path;

use touchcal::io::weights_file::WeightsFile;
use touchcal::manifold::Projection;
use touchcal::manifold::coordinates::Coordinates;

fn main() {
    let path = std::env::args().nth(1).expect("a weights file");
    let (weights, _) = WeightsFile::read_file(Path::new(&path)).unwrap();
    let rows = std::io::stdin().lines().map(|line| -> Coordinates {
        let numbers: Vec<f64> = line.unwrap().split(',').map(|number| number.trim().parse().unwrap()).collect();
        numbers.try_into().expect("six numbers")
    });
    let poses: Vec<Coordinates> = rows.collect();
    let mut projected = Vec::new();
    weights.projection.project(&poses, &mut projected);
    for row in projected {
        println!("{}", row.map(|value| format!("{value:.12e}")).join(","));
    }
}
