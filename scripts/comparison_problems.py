"""The problems that `compare_builds.py` gives to both builds: a problem file each, with the files it names."""

import math
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import mukca

DATA = Path(__file__).resolve().parents[1] / "data"
SQUARE_MM = 12.5
PEG = """
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
tip_from_tool = {{ xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }}
{tool}
exact = true
[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = {{ xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }}
depth_mm = 30
{hole}
{exact}
[[contacts]]
file = "contact.csv.gz"
fixture = "hole"
[noise]
encoder_deg = 0.002
contact_mm = 0.02
encoder_trend_deg = 0
[estimate]
parameters = ["strain", "joint_offset"]
"""


@dataclass
class Problem:
    """`write(folder)` writes the problem into a folder, and is its path; none is the demonstration."""

    name: str
    write: Callable | None


def recorded(trial, tool, hole, files=(), exact="exact = true"):
    """A log of data/mujoco_iiwa14; `exact` is a line of its own, which programs of 0.2.0 and before do not know."""

    def write(folder):
        shutil.copy(DATA / "mujoco_iiwa14" / trial / "contact.csv.gz", folder)
        for name, content in files:
            (folder / name).write_text(content)
        path = folder / "problem.toml"
        path.write_text(PEG.format(tool=tool, hole=hole, exact=exact))
        return path

    return write


def sockets(robot, parameters=mukca.FULL_MODEL):
    """A real arm of data/mukca, all its placements."""

    def write(folder):
        shutil.copytree(mukca.MUKCA / robot, folder / robot)
        shutil.copy(mukca.MUKCA / mukca.URDFS[robot], folder)
        path = folder / "problem.toml"
        path.write_text(mukca.problem(robot, parameters=parameters, base=Path()))
        return path

    return write


def turned(profile, sides):
    """An STL text: a line of (radius, height) in mm turned about z, from axis to axis."""
    angle = lambda k: 2 * math.pi * (k + 0.5) / sides
    ring = lambda r, z: [(r * math.cos(angle(k)), r * math.sin(angle(k)), z) for k in range(sides)]
    lines = ["solid part"]
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        low, high = ring(r0, z0), ring(r1, z1)
        for k in range(sides):
            a, b, c, d = low[k], low[k - sides + 1], high[k - sides + 1], high[k]
            for corners in ((a, b, c), (a, c, d)):
                if len(set(corners)) == 3:
                    vertices = [f"vertex {x!r} {y!r} {z!r}" for x, y, z in corners]
                    lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part\n"])


def square_parts(chamfer_mm):
    """Peg and hole of the square logs; with a chamfer they are not straight."""
    corner = math.sqrt(2.0)
    peg, hole = SQUARE_MM * corner, (SQUARE_MM + 0.5) * corner
    chamfer = chamfer_mm * corner
    tip = [(peg - chamfer, 0.0), (peg, chamfer_mm)] if chamfer_mm else [(peg, 0.0)]
    rim = [(hole + chamfer, 0.0), (hole, -chamfer_mm)] if chamfer_mm else [(hole, 0.0)]
    block = [(0.0, -40.0), (40.0 * corner, -40.0), (40.0 * corner, 0.0), *rim, (hole, -30.0), (0.0, -30.0)]
    return [("peg.stl", turned([(0.0, 0.0), *tip, (peg, 40.0), (0.0, 40.0)], 4)), ("hole.stl", turned(block, 4))]


def all_problems():
    slot = ('builtin = "extrusion25"\nlength_mm = 40', "outline_offset_mm = 0.5")
    square = ('outline = "square.csv"\nlength_mm = 40', "outline_offset_mm = 0.5")
    square_file = [("square.csv", "-12.5,-12.5\n12.5,-12.5\n12.5,12.5\n-12.5,12.5\n")]
    meshes = ('mesh = "peg.stl"', 'mesh = "hole.stl"')
    log = lambda trial, parts, files=(): recorded(trial, *parts, files)
    return [
        Problem("demonstration", None),
        Problem("recorded extrusion/paper/trial_00", log("extrusion/paper/trial_00", slot)),
        Problem("recorded extrusion/rich/trial_01", log("extrusion/rich/trial_01", slot)),
        Problem("recorded extrusion/paper/trial_28, free hole", recorded("extrusion/paper/trial_28", slot[0], f"{slot[1]}\nfree = true", exact='exact = ["clearance", "depth"]')),
        Problem("recorded square/paper/trial_00", log("square/paper/trial_00", square, square_file)),
        *(Problem(f"real arm {robot}", sockets(robot)) for robot in mukca.URDFS),
        Problem("real arm panda_3, compliances", sockets("panda_3", mukca.FULL_MODEL + mukca.COMPLIANCE)),
        Problem("straight meshes", log("square/rich/trial_00", meshes, square_parts(0.0))),
        Problem("chamfered meshes", log("square/paper/trial_00", meshes, square_parts(0.3))),
    ]
