//! Whether an arm meets the fixtures of its problem.

use serde::{Deserialize, Serialize};

/// Whether the contacts of an arm are where its fixtures are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ArmFit {
    /// Contacts are as near to their manifolds as noise and tolerances allow.
    Met,
    /// Contacts are on the surfaces of a fixture that is elsewhere than declared, within what its
    /// declaration allows, by more than the 0.5 mm or 0.1° that a calibrated arm may be off: poses
    /// in the fixture are relative to the declared place.
    Displaced(FixtureDisplacement),
    /// Contacts are on the surfaces of a fixture that cannot be where they put it: the arm is not
    /// calibrated, or the fixture is not where it is declared.
    Elsewhere(FixtureDisplacement),
    /// The arm misses a fixture wherever that is: it is not calibrated, or the problem does not
    /// describe what it touched.
    Missed {
        /// Index of the fixture in [`Problem::fixtures`](crate::estimate::Problem::fixtures), the
        /// one that is missed most.
        fixture: usize,
        /// Root mean square distance of its contacts from its manifold (m), with tool and fixture
        /// where their declarations and the contacts put them.
        found: f64,
        /// Distance that noise and the tolerance of the shapes allow (m).
        allowed: f64,
    },
    /// No fixture with contacts has a known shape at a bounded place, or distances from it are not
    /// finite.
    Unknown,
}

/// By how much a fixture is found, as the tool sees it, from where it is declared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixtureDisplacement {
    /// Index of the fixture in [`Problem::fixtures`](crate::estimate::Problem::fixtures).
    pub fixture: usize,
    /// Root mean square distance (m) over contacts between the tool's positions in the fixture,
    /// with tool and fixture where they are declared and where contacts put them.
    pub distance: f64,
    /// Root mean square angle (rad) between the tool's orientations there.
    pub angle: f64,
    /// Probability (0 to 1) that by chance the places of tool and fixture are so far from the
    /// declared ones.
    pub p_value: f64,
}
