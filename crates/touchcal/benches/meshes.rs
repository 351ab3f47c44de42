//! Calibrations with pegs and holes of any shape, as meshes of a thousand triangles, beside the
//! outlines that the contacts were made with; on one core. `cargo bench -p touchcal --bench meshes`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a bench prints its figures"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use support::parts::{block_with, lofted, polygon, rounded, solid};
use support::{simulated, timed};
use touchcal::geometry::{MeshPair, Polygon, PrismPair};
use touchcal::manifold::PegInHole;

const LENGTH: f64 = 0.04;
const DEPTH: f64 = 0.03;
const SEEDS: [u64; 3] = [1, 2, 3];

/// A peg and a blind hole between outlines at heights.
fn chamfered(peg: &[(&Polygon, f64)], hole: &[(&Polygon, f64)]) -> MeshPair {
    MeshPair::new(solid(&lofted(peg)), solid(&block_with(hole, DEPTH + 0.01)))
}

fn main() {
    let slot = Polygon::extrusion25();
    let at = |distance: f64| slot.offset_mitred(distance).unwrap();
    let hole = at(0.5e-3);
    let layers: Vec<f64> = (0..14).map(|k| 0.3e-3 + (LENGTH - 0.3e-3) * f64::from(k) / 13.0).collect();
    let tip = at(-0.2e-3);
    let sections: Vec<(&Polygon, f64)> = [(&tip, 0.0)].into_iter().chain(layers.iter().map(|&z| (&slot, z))).collect();
    let slots = chamfered(&sections, &[(&at(0.8e-3), 0.0), (&hole, -0.3e-3), (&hole, -DEPTH)]);

    let rounded_slots = |points: usize| {
        let round = |distance: f64, radius: f64| rounded(&at(distance), radius, points);
        let (peg, hole) = (round(0.0, 0.4e-3), round(0.5e-3, 0.4e-3));
        let meshes = chamfered(
            &[(&round(-0.2e-3, 0.2e-3), 0.0), (&peg, 0.4e-3), (&peg, LENGTH)],
            &[(&round(0.8e-3, 0.5e-3), 0.0), (&hole, -0.3e-3), (&hole, -DEPTH)],
        );
        ((peg, hole), meshes)
    };
    let [five, seven] = [5, 7].map(rounded_slots);

    let circle = |radius: f64| polygon(radius, 166);
    let (pin, bore) = (circle(12.5e-3), circle(13e-3));
    let pins = chamfered(
        &[(&circle(11.5e-3), 0.0), (&pin, 1e-3), (&pin, LENGTH)],
        &[(&circle(14e-3), 0.0), (&bore, -1e-3), (&bore, -DEPTH)],
    );

    println!("peg, chamfered | triangles | seed | as outlines | as meshes");
    for (name, (peg, hole), meshes) in [
        ("T-slot", (slot, hole), slots),
        ("T-slot, corners rounded by five points", five.0, five.1),
        ("T-slot, corners rounded by seven points", seven.0, seven.1),
        ("cylinder of 166 sides", (pin, bore), pins),
    ] {
        let outlines = PrismPair::new(peg, LENGTH, hole, DEPTH).unwrap();
        for seed in SEEDS {
            let (trial, search) = simulated(&outlines, seed);
            let (_, straight_s) = timed(&trial.problem(Box::new(PegInHole::new(outlines.clone())), search));
            let (estimate, mesh_s) =
                timed(&trial.problem(Box::new(PegInHole::with_depth(meshes.clone(), DEPTH)), search));
            let (triangles, reason) = (meshes.tool().triangle_count(), estimate.termination.reason);
            println!("{name} | {triangles} | {seed} | {straight_s:.2} s | {mesh_s:.2} s, {reason:?}");
        }
    }
}
