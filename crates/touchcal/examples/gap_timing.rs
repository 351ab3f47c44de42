//! How long a gap with its gradient takes at near-seated poses, in microseconds.
use nalgebra::Vector3;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use touchcal::geometry::extrusion::PegAndHole;
use touchcal::geometry::profile::Profile;
use touchcal::se3::{exp, twist};

#[allow(clippy::print_stdout)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let peg = Profile::extrusion25();
    let hole = peg.offset_mitred(0.5e-3)?;
    let model = PegAndHole::new(peg, 0.04, hole, 0.03)?;
    for (xy, angle) in [(0.3e-3, 0.005), (1.0e-3, 0.03), (1.0e-3, 0.052), (10e-3, 0.5)] {
        let mut rng = StdRng::seed_from_u64(1);
        let mut draw = |s: f64| s * rng.random_range(-1.0..=1.0);
        let poses: Vec<_> = (0..10_000)
            .map(|_| {
                let mut pose = exp(&twist(&Vector3::zeros(), &Vector3::new(draw(angle), draw(angle), draw(angle))));
                pose.translation.vector = Vector3::new(draw(xy), draw(xy), -0.015 + draw(0.012));
                pose
            })
            .collect();
        let start = std::time::Instant::now();
        let mut sum = 0.0;
        for _ in 0..20 {
            for pose in &poses {
                let gap = model.gap(pose);
                sum += gap.value + gap.gradient[3];
            }
        }
        let each = start.elapsed().as_secs_f64() / 200_000.0 * 1e6;
        println!("offsets to {} mm, {angle} rad: {each:.2} µs a gap (checksum {sum:.3})", xy * 1e3);
    }
    Ok(())
}
