"""A real arm: bits as by the command line, scored where it was not fitted."""

import json
from pathlib import Path

import pytest

import touchcal

DATA = Path(__file__).parents[2] / "data/mukca"
LOGS, URDF = DATA / "kuka_14", DATA / "iiwa14.urdf"


def test_a_real_arm(run, tmp_path: Path) -> None:
    run("new", "sockets", "--from", LOGS, "--urdf", URDF, "--out", tmp_path)
    run("calibrate", tmp_path / "problem.toml", "--only", "front", "--out", tmp_path)
    nominal = touchcal.Robot.from_urdf(URDF)
    calibration = touchcal.calibrate(touchcal.Problem.from_mukca(LOGS, nominal, only=["front"]))
    theirs = json.loads((tmp_path / "estimate.json").read_text())
    ours = json.loads(calibration.to_json())
    for key in ("status", "parameters", "covariance", "residuals", "contacts", "null_space"):
        assert ours[key] == theirs[key], key
    assert calibration.calibrated_urdf() == (tmp_path / "calibrated.urdf").read_text()

    held_out = touchcal.Problem.from_mukca(LOGS, nominal, leave_out=["front"])
    before, after = touchcal.evaluate(held_out), touchcal.evaluate(held_out, calibration)
    assert after.all.mean <= 0.15e-3 and before.all.mean > 0.5e-3
    # The tool's place is in the URDF, as the tip that moved.
    carried = touchcal.Problem.from_mukca(LOGS, calibration.robot, leave_out=["front"])
    assert touchcal.evaluate(carried).all.mean == pytest.approx(after.all.mean, rel=1e-6)


PROBLEM = """
[robot]
urdf = "{urdf}"
[tool]
kind = "ball"
sigma_mm = 2
[[fixture]]
name = "front/0"
kind = "socket"
free = true
[[fixture]]
name = "front/1"
kind = "socket"
free = true
[[distance]]
between = ["front/0", "front/1"]
mm = 50
sigma_mm = 0.05
[[contacts]]
file = "{logs}/front/hole_0.csv"
fixture = "front/0"
[[contacts]]
file = "{logs}/front/hole_1.csv"
fixture = "front/1"
[estimate]
parameters = ["joint_origin"]
"""


def test_a_tool_that_is_the_tip_moves_once(run, tmp_path: Path) -> None:
    """Where the URDF carries the tool's place, estimate.json does not move it again."""
    path = tmp_path / "problem.toml"
    path.write_text(PROBLEM.format(urdf=URDF, logs=LOGS))
    problem = touchcal.Problem.from_toml(path)
    calibration = touchcal.calibrate(problem)
    urdf, estimate, _ = calibration.save(tmp_path)
    moved = calibration.tip_from_tool[:3]
    assert max(abs(moved)) > 0.3e-3
    expected = pytest.approx(calibration.postfit.all.mean, rel=1e-6)
    assert touchcal.evaluate(problem, calibration).all.mean == expected
    assert touchcal.evaluate(problem, urdf=urdf, estimate=estimate).all.mean == expected
    told = json.loads(run("evaluate", path, "--urdf", urdf, "--estimate", estimate, "--json"))
    assert 1e-3 * told["mean_mm"] == expected
