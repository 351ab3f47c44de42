//! What is declared as uncertain, and has a default.

/// What a problem declares as uncertain, with its default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Poses of all fixtures in base: `PlacePrior::DEFAULT_FIXTURE`.
    FixturePlaces,
    /// The tool's pose on the tip link: `PlacePrior::DEFAULT_TOOL`.
    ToolPlace,
    /// Clearance, depth and edges: `ShapeTolerance::DEFAULT`.
    Shapes,
    /// Distances between fixtures: `DEFAULT_DISTANCE_SIGMA`; 0.01 mm where they are exact.
    Distances,
    /// Bias and scale of the wrench: `WrenchTolerance::DEFAULT`.
    Wrench,
    /// Errors of the arm that are not estimated: `UnseenEffects::Widen`.
    UnseenEffects,
    /// Trends of the encoder offsets, where offsets are estimated: `joint_trend`.
    Trends,
}
