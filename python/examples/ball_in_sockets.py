"""A ball in pairs of sockets, 50 mm apart, on a block that stood at three unknown places: nothing else is known.

Calibrates on two placements and scores on the third, which the fit never saw.
"""

import touchcal

simulation = touchcal.simulate("mukca", seed=2, contacts=100)
robot = touchcal.Robot.from_urdf("iiwa14")


def problem(placements: list[str]) -> touchcal.Problem:
    """The problem of the contacts of some placements."""
    names = [f"{placement}/{number}" for placement in placements for number in (0, 1)]
    logs = {name: simulation.log(name) for name in names}
    return touchcal.Problem(
        robot,
        # Where the ball sits on the flange, to 2 mm.
        touchcal.Tool(touchcal.pose((0, 0, 0.15), quat_wxyz=(0, 0, 1, 0)), sigma=0.002),
        [touchcal.Fixture(name, touchcal.Manifold.ball_in_socket(), free=True) for name in names],
        {name: touchcal.ContactLog.from_numpy(robot, log["q"], contact=log["contact"]) for name, log in logs.items()},
        distances=[(f"{placement}/0", f"{placement}/1", 0.05, 1e-5) for placement in placements],
        parameters=["joint_origin"],
    )


fit, held_out = problem(["front", "left"]), problem(["right"])

# What can these contacts determine? Ask before you trust, or record more.
inspection = touchcal.inspect(fit)
print(inspection, *(null.description for null in inspection.null_space[:3]), sep="\n  ")

calibration = touchcal.calibrate(fit)
before, after = touchcal.evaluate(held_out), touchcal.evaluate(held_out, calibration)
print(f"{calibration.status}: held-out contacts {1e3 * before.all.rms:.2f} mm before, {1e3 * after.all.rms:.2f} mm after")
print(after.to_pandas().to_string(index=False))

assert calibration.usable
assert after.all.rms < 0.5 * before.all.rms
