"""Gaps between peg and hole and their gradients, against coal (in Python) and parry (in a test)."""

import io

import coal
import numpy as np
import pinocchio as pin

from .commands import example, test, test_command
from .report import Row, Table, quantiles, within

POSES = 4000
PARRY_POSES = 30_000
# Distance (m) below which parts may count as touching or not.
TOUCHING = 1e-6
# Gap beyond which coal's nearest points say the gradient to the tolerance: their directions err by its precision over the distance.
CLEAR = 1e-4
PRECISION = 1e-9
LENGTH, DEPTH, FAR = 40.0, 30.0, 300.0

# Rectangles x0, x1, y0, y1 (mm) that, turned by 90° four times, are the parts' outlines; drawn by hand from the profiles' vertices.
PEGS = {
    "square": [(-12.5, 12.5, -12.5, 12.5)],
    "extrusion25": [(-6, 6, -6, 6), (5.5, 12.5, 5.5, 12.5), (3.5, 12.5, 10.5, 12.5), (10.5, 12.5, 3.5, 12.5)],
}
HOLES = {
    "square": [(13, FAR, -FAR, FAR)],
    "extrusion25": [(13, FAR, -FAR, FAR), (10, 13, -3, 3), (6.5, 10, -5, 5)],
}


def boxes(rectangles, low, high):
    """Boxes (coal's, in metres) with their centres: the four turns of each rectangle, between two heights (mm)."""
    found = []
    for x0, x1, y0, y1 in rectangles:
        for cosine, sine in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            turn = np.array([[cosine, -sine], [sine, cosine]])
            corners = (turn @ np.array([[x0, x1], [y0, y1]])) * 1e-3
            sides = np.ptp(corners, axis=1)
            centre = np.append(corners.mean(axis=1), (low + high) / 2 * 1e-3)
            found.append((coal.Box(*sides, (high - low) * 1e-3), centre))
    return found


class Parts:
    def __init__(self, name):
        self.peg = boxes(PEGS[name], 0, LENGTH)
        self.hole = boxes(HOLES[name], -DEPTH, 0) + boxes([(-FAR, FAR, -FAR, FAR)], -FAR, -DEPTH)[:1]
        self.request = coal.DistanceRequest()
        self.request.gjk_tolerance = self.request.epa_tolerance = PRECISION
        self.request.gjk_max_iterations = self.request.epa_max_iterations = 1000

    def gap(self, hole_from_peg):
        """Distance (not above 0 where parts overlap) and its derivatives by a twist of the peg in its frame."""
        least, gradient = np.inf, None
        for box, centre in self.peg:
            place = coal.Transform3s(hole_from_peg.rotation, hole_from_peg.act(centre))
            for block, middle in self.hole:
                result = coal.DistanceResult()
                distance = coal.distance(block, coal.Transform3s(np.eye(3), middle), box, place, self.request, result)
                if distance < least:
                    least, points = distance, (result.getNearestPoint1(), result.getNearestPoint2())
        if least > CLEAR:
            on_hole, on_peg = points
            normal = hole_from_peg.rotation.T @ (on_peg - on_hole) / np.linalg.norm(on_peg - on_hole)
            gradient = np.concatenate([normal, np.cross(hole_from_peg.actInv(on_peg), normal)])
        return least, gradient


def draw(random):
    """Seated, at the rim and above, tilted: offsets (mm), height (mm), tilt and turn (rad)."""
    xy, low, high, tilt, turn = [
        (0.5, -30, -5, 0.015, 0.02),
        (1.0, -30, -1, 0.03, 0.05),
        (1.0, -2, 2, 0.05, 0.05),
        (20.0, -2, 10, 0.3, 3.0),
        (30.0, -20, 60, 2.2, 2.2),
    ][random.integers(5)]
    place = [random.uniform(-xy, xy), random.uniform(-xy, xy), random.uniform(low, high)]
    rotation = [random.uniform(-tilt, tilt), random.uniform(-tilt, tilt), random.uniform(-turn, turn)]
    return pin.SE3(pin.exp3(np.array(rotation)), np.array(place) * 1e-3)


def against_coal(name):
    random = np.random.default_rng(11)
    poses = [draw(random) for _ in range(POSES)]
    text = io.StringIO()
    for pose in poses:
        x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
        print(*map(repr, map(float, [*pose.translation, w, x, y, z])), sep=",", file=text)
    rows = np.loadtxt(io.StringIO(example("gaps", name, input=text.getvalue())), delimiter=",")
    parts = Parts(name)
    errors, slopes, signs = [], [], 0
    for pose, (found, *gradient) in zip(poses, rows):
        distance, expected = parts.gap(pose)
        if distance > TOUCHING:
            errors.append(found - distance)
        signs += abs(found) > TOUCHING and (distance <= 0) != (found < 0)
        if expected is not None:
            slopes.append(np.abs(gradient - expected).max())
    name = f"{name}, {len(errors)} of {POSES} poses apart"
    reference = "coal, distances between convex parts"
    row = lambda what, why: {"what": what, "reference": reference, "why": why, "command": "`scripts/validate --only gaps`"}
    return [
        within(row(f"gap of {name} (m)", "the precision that coal is asked for"), errors, PRECISION),
        within(
            row(
                f"its derivatives by the peg's motion (1, m/rad), {len(slopes)} poses beyond 0.1 mm",
                "nearest points good to 1e-10 m, as seen above, 1e-4 m apart",
            ),
            slopes,
            1e-6,
        ),
        count("its signs that differ", reference, signs, POSES, "`scripts/validate --only gaps`"),
    ]


def count(what, reference, failures, of, command):
    figures = {"q75": "–", "q99": "–", "max": f"{failures} of {of}"}
    return Row(what, figures, reference, "0", "a peg is in the wall or it is not", command, bool(failures))


def against_parry():
    rows = []
    arguments = ("--test", "laws", "peg_in_hole_distance")
    command = test_command(*arguments)
    reports, _ = test(*arguments)
    reference = "parry3d, distances between boxes"
    for name in ("square", "extrusion25", "small square"):
        found = reports[name]
        what = f"gap of {name}, {found['apart']:.0f} of {PARRY_POSES} poses apart (m)"
        row = {"what": what, "reference": reference, "why": "rounding", "command": command}
        rows.append(quantiles(row, (found["q75"], found["q99"], found["max"]), found["limit"]))
        rows.append(count("its signs that differ", reference, int(found["signs"]), PARRY_POSES, command))
    return rows


def tables(_options):
    coal_rows = [row for name in PEGS for row in against_coal(name)]
    return [Table(coal_rows, "By coal."), Table(against_parry(), "By parry.")]
