//! Rows of a log that are grossly wrong.

use crate::support::solve;
use touchcal::contact::ContactLog;
use touchcal::estimate::Verdict;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

/// Contacts, joints and errors (rad): two rows that are decimetres off, one in which a joint reads
/// zero, and one in which it is nearly turned round: that row pulls the coarse stage so far that
/// its distance there stands out little.
const GLITCHES: [&[(usize, usize, f64)]; 3] = [&[(200, 2, -0.3), (400, 5, -1.0)], &[(238, 4, 1.5)], &[(212, 2, 4.2)]];

/// Glitches of encoders put one or two of 600 contacts decimetres off. They are rejected, the arm
/// is that without them, and the search is as short. With these rows in the coarse stage the search
/// would end at another minimum, and more searches from other starts would follow.
#[test]
fn glitches_of_encoders_are_rejected() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Paper.scenario(robot).expect("parts");
    scenario.contacts = 600;
    for (seed, glitches) in [1, 2, 3].into_iter().flat_map(|seed| GLITCHES.map(|glitches| (seed, glitches))) {
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let right = experiment::problem(&scenario, &simulated);
        let mut wrong = right.clone();
        wrong.contacts = ContactLog::new(right.contacts.dof());
        for i in 0..right.contacts.len() {
            let mut q = right.contacts.q(i).to_vec();
            glitches.iter().filter(|(of, ..)| *of == i).for_each(|(_, joint, off)| q[*joint] += off);
            wrong.contacts.push(&q, right.contacts.fixture(i), right.contacts.source(i));
            right.contacts.known_load(i).iter().for_each(|load| wrong.contacts.set_load(*load));
        }
        let (right, wrong) = (solve(&right), solve(&wrong));
        println!("seed {seed}: {} and {} steps", right.termination.iterations, wrong.termination.iterations);
        assert!(wrong.status.is_usable(), "seed {seed}: {:?}", wrong.warnings);
        assert!(wrong.termination.iterations < 2 * right.termination.iterations, "seed {seed}");
        for &(i, ..) in glitches {
            assert!(matches!(wrong.verdicts[i], Verdict::Rejected { .. }), "seed {seed}: {:?}", wrong.verdicts[i]);
        }
        for (with, without) in wrong.parameters.iter().zip(&right.parameters) {
            let off = (with.value - without.value) / without.sigma.expect("known");
            assert!(off.abs() < 0.5, "seed {seed}: {} off by {off} standard deviations", with.parameter.name);
        }
    }
}
