//! Why a simulation ends without a result.

/// Why a simulation ended without a result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The arm does not reach a fixture: no joint positions were found for a row's tool pose.
    #[error(
        "the arm cannot reach `{fixture}`: no joint positions put the tool there from the posture given, {time:.2} s after the start"
    )]
    OutOfReach {
        /// Name of the fixture.
        fixture: String,
        /// Time since the start of this fixture's log (s).
        time: f64,
    },
    /// The exploration touches a fixture too rarely: the contacts wanted were not found in 20 times
    /// as many rows (at least 2000).
    #[error(
        "expected contacts with `{fixture}`, found only {found} in {rows} rows: widen the exploration or lower the force threshold"
    )]
    NoContact {
        /// Name of the fixture.
        fixture: String,
        /// Number of contacts found with this fixture.
        found: usize,
        /// Number of rows simulated at this fixture.
        rows: usize,
    },
    /// The search for the pose at which the tool rests did not end.
    #[error(
        "the tool comes to no rest at `{fixture}`, {time:.2} s after the start: slow the exploration or lower the friction"
    )]
    NoRest {
        /// Name of the fixture.
        fixture: String,
        /// Time since the start of this fixture's log (s).
        time: f64,
    },
    /// The observer of [`run`](super::run) ended the simulation.
    #[error("the simulation was broken off")]
    Interrupted,
    /// A hole that is not valid after the changes of width and depth drawn for it.
    #[error(
        "`{fixture}` cannot be {wider_mm:+.3} mm wider and {deeper_mm:+.3} mm deeper with edges worn by {worn_mm:.3} mm: lower its clearance_sigma, depth_sigma, unequal_clearance_sigma, edge_wear or edge_radius_sigma"
    )]
    Shape {
        /// Name of the fixture.
        fixture: String,
        /// How much wider the hole was to be (mm per side), negative for a narrower one.
        wider_mm: f64,
        /// How much deeper (mm), negative for a shallower one.
        deeper_mm: f64,
        /// Radius by which its edges and the peg's were to be worn (mm).
        worn_mm: f64,
    },
    /// A distance that is measured as 0 or less.
    #[error(
        "the distance of `{first}` and `{second}` is measured as {measured_mm:.3} mm: place them farther apart or lower its sigma_mm"
    )]
    Distance {
        /// Name of one fixture.
        first: String,
        /// Name of the other.
        second: String,
        /// The measured distance (mm).
        measured_mm: f64,
    },
}
