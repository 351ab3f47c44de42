"""A peg in a hole, put together in code: from joint positions and wrenches to a calibrated URDF and a report.

The log comes from the simulator, so that the truth is known; with a robot of yours it comes from its recorder.
"""

import sys
from pathlib import Path

import touchcal

out = Path(sys.argv[1] if len(sys.argv) > 1 else "peg_in_hole")

# What was recorded: joint positions (rad), shape (N, 7), and wrenches (N, N m), shape (N, 6).
simulation = touchcal.simulate("paper", seed=1)
recorded = simulation.log("hole")

# What is known of the cell, in metres and radians.
robot = touchcal.Robot.from_urdf("iiwa14")  # or the path of a URDF
peg = touchcal.extrusion25()  # or vertices x, y of your outline
hole = touchcal.Manifold.peg_in_hole(peg, touchcal.offset_outline(peg, 0.0005), length=0.04, depth=0.03)
problem = touchcal.Problem(
    robot,
    # In a simulation everything is exact; measure yours, and declare how well: sigma, sigma_angle, clearance_sigma.
    touchcal.Tool(touchcal.pose((0, 0, 0.15), quat_wxyz=(0, 0, 1, 0)), exact=True),
    [
        touchcal.Fixture(
            "hole",
            hole,
            touchcal.pose((0.6, 0.1, 0.15), quat_wxyz=(0.984807753012, 0, 0, 0.173648177667)),
            exact=True,
        )
    ],
    {"hole": touchcal.ContactLog.from_numpy(robot, recorded["q"], wrench=recorded["wrench"], force_threshold=3)},
    parameters=["strain", "joint_offset"],
    noise={"encoder_deg": 0.002, "contact_mm": 0.005, "encoder_trend_deg": 0},
)

calibration = touchcal.calibrate(problem)
print(calibration.to_pandas().to_string(index=False))
print(f"contacts are {1e3 * calibration.prefit.all.rms:.2f} mm off before, {1e3 * calibration.postfit.all.rms:.3f} mm after")
for warning in calibration.warnings:
    print(f"{warning.message}\n  -> {warning.advice}")
for test in calibration.effect_tests[:3]:
    print(f"left out: {test.description}, p = {test.p_value:.2g}")
print("written:", *calibration.save(out), sep="\n  ")

# The simulator knows the truth.
truth = simulation.truth["parameters"]
assert calibration.usable
assert abs(calibration["strain"].value - truth["strain"]) < 2e-4
assert all(
    abs(p.value - truth[p.name]) < 2e-3 for p in calibration.parameters if p.block == "joint_offset"
), "radians"
