"""Calibrate a robot arm by touch.

A robot's description, a log of joint positions in contact, and what was touched go in; a calibrated description, the
uncertainty of every number, and what the data cannot determine come out::

    problem = touchcal.Problem.from_toml("problem.toml")
    calibration = touchcal.calibrate(problem)
    calibration.save("out")

Lengths are metres, angles radians, forces newtons. Poses are seven numbers x, y, z, qw, qx, qy, qz, or 4 x 4 matrices;
``a_from_b`` is the pose of frame b in frame a. Arrays that are returned cannot be written to.
"""

from touchcal._bar import bar
from touchcal._touchcal import (
    Acceptance,
    Calibration,
    Campaign,
    ContactLog,
    EffectTest,
    Error,
    Evaluation,
    Expected,
    FileError,
    Fixture,
    FixtureDistance,
    InputError,
    Inspection,
    JointRange,
    Manifold,
    NullDirection,
    Parameter,
    PredictiveCheck,
    Problem,
    Progress,
    Robot,
    Scatter,
    Score,
    Simulation,
    SimulationError,
    Spread,
    Termination,
    Tool,
    Warning,
    __version__,
    calibrate,
    evaluate,
    extrusion25,
    inspect,
    offset_outline,
    pose,
    project,
    read_outline,
    simulate,
)

__all__ = [
    "Acceptance",
    "Calibration",
    "Campaign",
    "ContactLog",
    "EffectTest",
    "Error",
    "Evaluation",
    "Expected",
    "FileError",
    "Fixture",
    "FixtureDistance",
    "InputError",
    "Inspection",
    "JointRange",
    "Manifold",
    "NullDirection",
    "Parameter",
    "PredictiveCheck",
    "Problem",
    "Progress",
    "Robot",
    "Scatter",
    "Score",
    "Simulation",
    "SimulationError",
    "Spread",
    "Termination",
    "Tool",
    "Warning",
    "__version__",
    "bar",
    "calibrate",
    "evaluate",
    "extrusion25",
    "inspect",
    "offset_outline",
    "pose",
    "project",
    "read_outline",
    "simulate",
]
