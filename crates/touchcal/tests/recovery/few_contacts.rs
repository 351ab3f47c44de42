//! So few contacts that they hardly say how unequal the clearances of a hole are.

use crate::support::solve;
use touchcal::estimate::Status;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::Block;
use touchcal::sim::{self, Preset};

/// In these trials 100 contacts do not contradict equal clearances, and clearances are unequal: an
/// encoder offset is 4.0 to 4.8 standard deviations off. The verdict says that contacts are few.
#[test]
fn few_contacts_make_a_result_doubtful() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    for (contacts, seed) in [(100, 128), (100, 145), (100, 225), (100, 254), (100, 287), (300, 128), (300, 145)] {
        scenario.contacts = contacts;
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let estimate = solve(&experiment::problem(&scenario, &simulated));
        let offsets = estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == Block::JointOffset);
        let deviations = offsets.map(|entry| {
            ((entry.value - simulated.truth.value(entry.parameter.id)) / entry.sigma.expect("known")).abs()
        });
        let largest = deviations.fold(0.0, f64::max);
        let is_warned = estimate.warnings.iter().any(|warning| warning.kind() == "few_contacts");
        assert_eq!(is_warned, contacts < 300, "{contacts} contacts, seed {seed}: {:?}", estimate.warnings);
        assert!(largest < 3.9 || estimate.status != Status::Usable, "{contacts} contacts, seed {seed}: {largest}");
    }
}
