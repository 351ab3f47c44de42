//! Where the arm puts its tool in contact.

use nalgebra::DVector;

use super::problem::Problem;
use super::system::System;
use crate::se3::Pose;

/// `fixture_from_tool` of each contact with fixture number `fixture`, by the problem's arm as it is, in the order of the log.
///
/// Of an arm that is calibrated these are samples of the fixture's contact manifold.
pub fn contact_poses(problem: &Problem, fixture: usize) -> Vec<Pose> {
    let system = System::new(problem);
    let at = system.at(&DVector::zeros(system.parameters.len()));
    let contacts = (0..problem.contacts.len()).filter(|&i| problem.contacts.fixture(i) == fixture);
    contacts.map(|i| at.fixture_from_tool(i)).collect()
}
