"""Mistakes in the logs of real arms: joints exchanged, in the opposite order, in another unit, with the opposite sign.

Each must give a result that is not usable, or none, unless it changes nothing: a joint on whose axis the ball lies, so that
the log without the motion of that joint gives a usable result too.
"""

import itertools
import json
import math
import shutil
import subprocess
from pathlib import Path

DATA = Path(__file__).resolve().parent.parent.parent / "data/mukca"
URDFS = {"kuka_14": "iiwa14.urdf", "panda_1": "panda.urdf", "panda_3": "panda.urdf", "dinova_2": "gen3lite.urdf"}
NEEDED = 300


def mistakes(joints):
    """Names of mistakes, what each makes of the positions of a row, and the joint that has another sign."""

    def exchanged(i, j):
        return lambda q: [q[{i: j, j: i}.get(k, k)] for k in range(len(q))]

    def opposite(i):
        return lambda q: [-x if k == i else x for k, x in enumerate(q)]

    for i, j in itertools.combinations(range(joints), 2):
        yield f"joints {i + 1} and {j + 1} exchanged", exchanged(i, j), None
    for i in range(joints):
        yield f"joint {i + 1} with the opposite sign", opposite(i), i
    yield "joints in the opposite order", lambda q: q[::-1], None
    yield "in degrees, taken as radians", lambda q: [math.degrees(x) for x in q], None


def read(path):
    return [[float(x) for x in row.split(",")] for row in path.read_text().splitlines()]


class Arm:
    """Calibrations of one arm from its logs with a mistake."""

    def __init__(self, program, work, name):
        self.program, self.work, self.name = program, work, name
        self.logs = {path.relative_to(DATA / name): read(path) for path in sorted((DATA / name).rglob("*.csv"))}

    def run(self, *arguments):
        return subprocess.run([self.program, *map(str, arguments)], cwd=self.work, capture_output=True, text=True, timeout=NEEDED)

    def calibrated(self, change):
        """Exit code, and the estimate if there is one."""
        shutil.rmtree(self.work, ignore_errors=True)
        for path, rows in self.logs.items():
            log = self.work / "logs" / path
            log.parent.mkdir(parents=True, exist_ok=True)
            log.write_text("".join(",".join(f"{x:.12f}" for x in change(row)) + "\n" for row in rows))
        new = self.run("new", "sockets", "--from", "logs", "--urdf", DATA / URDFS[self.name], "--out", "sockets")
        if new.returncode != 0:
            return new.returncode, None
        done = self.run("calibrate", "sockets/problem.toml", "--out", "out")
        found = self.work / "out/estimate.json"
        return done.returncode, json.loads(found.read_text()) if found.exists() else None


    def is_seen(self, joint):
        """Whether contacts show the motion of a joint."""
        code, _ = self.calibrated(lambda q: [0.0 if k == joint else x for k, x in enumerate(q)])
        return code != 0


def rms(estimate):
    return estimate["residuals"]["postfit"]["rms_mm"]


def run(program, folder, names):
    """Number of mistakes that gave a result that may be used."""
    wrong = 0
    for name in names or URDFS:
        arm = Arm(program, folder / "arm", name)
        code, right = arm.calibrated(lambda q: q)
        assert code == 0, f"{name} as recorded: exit code {code}"
        joints = len(next(iter(arm.logs.values()))[0])
        tried = faults = unseen = 0
        for what, change, joint in mistakes(joints):
            code, found = arm.calibrated(change)
            tried += 1
            if code not in (1, 3):
                if joint is not None and not arm.is_seen(joint):
                    unseen += 1
                    continue
                faults += 1
                figures = f"exit code {code}, {rms(found):.3f} mm left, {rms(right):.3f} mm without it" if found else f"exit code {code}"
                print(f"{name}, {what}: {figures}", flush=True)
        wrong += faults
        print(f"{name}: {tried} mistakes, {unseen} of which change nothing; {faults} others with a result that may be used", flush=True)
    return wrong
