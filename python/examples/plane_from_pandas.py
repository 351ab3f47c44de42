"""A point on three planes, from a DataFrame in degrees, with progress shown and Ctrl-C heeded.

A scenario of the simulator stands for the recorder; its description is that of `touchcal simulate`.
"""

import tempfile
from pathlib import Path

import numpy as np

import touchcal

PLANES = {
    "table": touchcal.pose((0.55, 0.0, 0.1)),
    "wall": touchcal.pose((0.75, 0.0, 0.3), rpy=(0, -np.pi / 2, 0)),
    "side": touchcal.pose((0.55, 0.3, 0.3), rpy=(np.pi / 2, 0, 0)),
}
POSTURES = {
    "table": [[0, 35, 0, -90, 0, 55, 0], [25, 40, -20, -80, 20, 60, 30]],
    "wall": [[0, 40, 0, -75, 0, 65, 0], [15, 45, 20, -70, -20, 60, -30]],
    "side": [[25, 35, 0, -85, 0, 60, 0], [40, 40, -25, -80, 15, 55, 45]],
}
SCENARIO = """
contacts = 150
[errors]
joint_offset_deg = 0.5
[tool]
kind = "point"
tip_from_tool = { xyz_mm = [0, 0, 100], quat_wxyz = [0, 0, 1, 0] }
"""


def described(name: str) -> str:
    """A plane as scenario.toml has it."""
    x, y, z, *quaternion = PLANES[name].tolist()
    return f"""
[[fixture]]
name = "{name}"
kind = "plane"
base_from_fixture = {{ xyz_mm = {[1e3 * x, 1e3 * y, 1e3 * z]}, quat_wxyz = {quaternion} }}
postures_deg = {POSTURES[name]}
"""


with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "scenario.toml"
    path.write_text(SCENARIO + "".join(map(described, PLANES)))
    simulation = touchcal.simulate(path, seed=4)

robot = touchcal.Robot.from_urdf("iiwa14")
logs = {}
for name in PLANES:
    frame = simulation.to_pandas(name)
    frame[robot.joints] = np.degrees(frame[robot.joints])
    logs[name] = touchcal.ContactLog.from_pandas(robot, frame, unit="deg", force_threshold=3)
    print(name, logs[name])

problem = touchcal.Problem(
    robot,
    touchcal.Tool(touchcal.pose((0, 0, 0.1), quat_wxyz=(0, 0, 1, 0)), exact=True),
    [touchcal.Fixture(name, touchcal.Manifold.plane(), place, exact=True) for name, place in PLANES.items()],
    logs,
    parameters=["joint_offset"],
)
with touchcal.bar() as progress:
    calibration = touchcal.calibrate(problem, progress)
print(calibration)
print(calibration.to_pandas().to_string(index=False))

# The simulator knows the truth.
truth = simulation.truth["parameters"]
known = [p for p in calibration.parameters if p.block == "joint_offset" and p.sigma is not None]
assert len(known) >= 5
assert all(abs(p.value - truth[p.name]) < 5 * p.sigma for p in known if p.sigma)
