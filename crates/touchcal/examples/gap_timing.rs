//! How long gaps take at contact and at near-seated poses, in microseconds. For a profiler: a
//! number of rounds as the only argument times contact alone.
use nalgebra::{Translation3, Vector3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use touchcal::geometry::{GapQuery, Polygon, PrismPair};
use touchcal::se3::{Pose, exp, twist};

const POSES: usize = 3_000;
/// Rounds unless given.
const ROUNDS: usize = 20;
/// Temperature of the blends (m).
const TEMPERATURE: f64 = 25e-6;

/// A pose at the given greatest offset (m, each way) and rotation (rad, about each axis).
fn draw_pose(rng: &mut StdRng, xy: f64, z: (f64, f64), angle: f64) -> Pose {
    let mut draw = |s: f64| s * rng.random_range(-1.0..=1.0);
    let mut pose = exp(&twist(&Vector3::zeros(), &Vector3::new(draw(angle), draw(angle), draw(angle))));
    pose.translation.vector = Vector3::new(draw(xy), draw(xy), (z.0 + z.1) / 2.0 + draw((z.1 - z.0) / 2.0));
    pose
}

/// A free pose pushed along a random direction until the gap is within 20 µm of nothing.
fn draw_contact(rng: &mut StdRng, model: &PrismPair) -> Pose {
    loop {
        let mut pose = draw_pose(rng, 0.5e-3, (-0.028, 0.0), 0.019);
        let direction = Vector3::from_fn(|_, _| rng.random_range(-1.0..=1.0)).normalize();
        if model.gap(&pose).value <= 0.0 {
            continue;
        }
        for _ in 0..200 {
            pose = Translation3::from(direction * model.gap(&pose).value) * pose;
        }
        pose = Translation3::from(direction * rng.random_range(-20e-6..=20e-6)) * pose;
        if model.gap(&pose).value.abs() <= 20e-6 {
            return pose;
        }
    }
}

/// Microseconds a call, the best of several rounds.
fn time(rounds: usize, poses: &[Pose], call: impl Fn(&Pose) -> f64) -> f64 {
    let mut sum = 0.0;
    let round = |_| {
        let start = std::time::Instant::now();
        sum += poses.iter().map(&call).sum::<f64>();
        start.elapsed().as_secs_f64() / poses.len() as f64 * 1e6
    };
    let best = (0..rounds).map(round).fold(f64::INFINITY, f64::min);
    std::hint::black_box(sum);
    best
}

#[allow(clippy::print_stdout, reason = "an example prints")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given = std::env::args().nth(1).map(|rounds| rounds.parse()).transpose()?;
    let rounds = given.unwrap_or(ROUNDS);
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5e-3)?;
    let model = PrismPair::new(peg, 0.04, hole, 0.03)?;
    let mut rng = StdRng::seed_from_u64(1);
    let contacts: Vec<Pose> = (0..POSES).map(|_| draw_contact(&mut rng, &model)).collect();
    let mut cases = vec![("at contact", contacts)];
    for (name, xy, angle) in [("0.3 mm, 0.3°", 0.3e-3, 0.005), ("1 mm, 1.7°", 1e-3, 0.03), ("10 mm, 30°", 10e-3, 0.5)]
    {
        cases.push((name, (0..POSES).map(|_| draw_pose(&mut rng, xy, (-0.027, -0.003), angle)).collect()));
    }
    if given.is_some() {
        cases.truncate(1);
    }
    for (name, poses) in &cases {
        let gap = time(rounds, poses, |pose| {
            let gap = model.gap(pose);
            gap.value + gap.gradient[3]
        });
        let blend = time(rounds, poses, |pose| {
            let (value, gradient) = model.blended_gap(pose, TEMPERATURE);
            value + gradient[3]
        });
        println!("{name}: gap {gap:.2} µs, blended gap {blend:.2} µs");
    }
    Ok(())
}
