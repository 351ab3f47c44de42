//! An arm of two joints, for tests of logs.

use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Robot;

/// A joint that turns, `sh`, within ±2 rad, and one that slides, `sl`.
pub const ARM: &str = "<robot><link name='b'/><link name='l'/><link name='t'/>\
  <joint name='sh' type='revolute'><parent link='b'/><child link='l'/><limit lower='-2' upper='2'/></joint>\
  <joint name='sl' type='prismatic'><parent link='l'/><child link='t'/></joint></robot>";

pub fn arm() -> Robot {
    urdf::read(ARM, "arm.urdf", Ends::default()).unwrap()
}
