//! Contact from force.

use crate::se3::Wrench;

/// Thresholds of contact detection by force, see [`Detector`]. Magnitudes are those of the force of
/// a row's wrench, whatever its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Magnitude of the force above which contact begins (N, not negative).
    pub threshold: f64,
    /// Magnitude of the force below which contact ends (N, positive: with 0 it never ends); above
    /// `threshold` it counts as `threshold`.
    pub release: f64,
    /// Number of consecutive rows for which the force must be beyond either threshold; 0 counts as
    /// 1.
    pub debounce: usize,
}

/// Turns the wrenches of successive rows into contact flags, with hysteresis and debounce.
///
/// Contact begins when |F| > `threshold` and ends when |F| < `release` (N); either takes effect
/// after it has held for `debounce` rows in a row, and then only from there on, so a spike shorter
/// than that changes nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Detector {
    threshold: f64,
    release: f64,
    debounce: usize,
    touching: bool,
    pending: usize,
}

impl Detector {
    /// A detector, not yet in contact, with force threshold and release (N) and debounce (rows; 0
    /// counts as 1). A release above the threshold is taken as the threshold: then there is no
    /// hysteresis.
    pub fn new(threshold: f64, release: f64, debounce: usize) -> Self {
        Detector { threshold, release: release.min(threshold), debounce: debounce.max(1), touching: false, pending: 0 }
    }

    /// Takes the wrench `[f; τ]` (N, N m) of the next row, in any frame; returns whether the tool
    /// touches there. The torque has no effect; a force of NaN changes nothing and counts as a row
    /// between the thresholds.
    pub fn update(&mut self, wrench: &Wrench) -> bool {
        let force = (wrench[0].powi(2) + wrench[1].powi(2) + wrench[2].powi(2)).sqrt();
        let changes = if self.touching { force < self.release } else { force > self.threshold };
        self.pending = if changes { self.pending + 1 } else { 0 };
        if self.pending >= self.debounce {
            self.touching = !self.touching;
            self.pending = 0;
        }
        self.touching
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flags(detector: &mut Detector, forces: &[f64]) -> Vec<bool> {
        forces.iter().map(|&f| detector.update(&[0.0, f, 0.0, 9.0, 9.0, 9.0])).collect()
    }

    #[test]
    fn threshold_is_exclusive_and_torque_is_ignored() {
        assert_eq!(flags(&mut Detector::new(3.0, 3.0, 1), &[0.0, 3.0, 3.1, 2.9]), [false, false, true, false]);
    }

    #[test]
    fn hysteresis_holds_contact_between_release_and_threshold() {
        let seen = flags(&mut Detector::new(3.0, 2.0, 1), &[2.5, 3.5, 2.5, 2.0, 1.9, 2.5]);
        assert_eq!(seen, [false, true, true, true, false, false]);
    }

    #[test]
    fn debounce_ignores_short_spikes_either_way() {
        let seen = flags(&mut Detector::new(3.0, 2.0, 2), &[4.0, 0.0, 4.0, 4.0, 0.0, 4.0, 0.0, 0.0]);
        assert_eq!(seen, [false, false, false, true, true, true, true, false]);
    }
}
