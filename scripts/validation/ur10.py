"""The UR10 of data/ur10 by numpy and scipy alone: its kinematics, least-squares fits, and distances from the tracker's points.

A fit has the pose of the arm's base in the tracker's frame, the place of the target on the flange, and the parameters of its
blocks: six numbers of each joint origin, a compliance of each joint, harmonics of each encoder. Their priors are `SCALE`; the
loss is soft-L1 of each point's distance in `NOISE`, by reweighting. Scores fit base and target again.
"""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from .commands import DATA

FOLDER = DATA / "ur10"
GRAVITY = np.array([0, 0, -9.80665])
# Standard deviations of priors: m and rad of an origin, rad/(N m), rad.
SCALE = {"origin": [1e-3] * 3 + [1e-3] * 3, "compliance": [1e-4], "harmonic": [5e-4] * 4}
# Of a measured point (m), and its multiple from which the loss grows linearly.
NOISE, LINEAR = 2e-4, 2.0
REWEIGHTINGS = 12


@dataclass
class Series:
    q: np.ndarray
    points: np.ndarray

    def rows(self, chosen):
        return Series(self.q[chosen], self.points[chosen])


def series(name):
    table = np.genfromtxt(FOLDER / f"series_{name}.csv", delimiter=",", names=True)
    columns = lambda names: np.array([table[name] for name in names]).T
    return Series(columns(table.dtype.names[:6]), columns(["x_mm", "y_mm", "z_mm"]) / 1e3)


def training_rows():
    return np.loadtxt(FOLDER / "series_b_training_rows.txt", dtype=int)


@dataclass
class Arm:
    """A chain of revolute joints about z, with what follows the last as one fixed joint, and corrections of its positions."""

    translations: np.ndarray
    rotations: np.ndarray
    masses: np.ndarray
    centers: np.ndarray
    compliance: np.ndarray = field(default_factory=lambda: np.zeros(6))
    # Sine and cosine of once and twice a turn of each joint.
    harmonics: np.ndarray = field(default_factory=lambda: np.zeros((6, 4)))
    gear_ratio: np.ndarray = field(default_factory=lambda: np.zeros(6))

    @staticmethod
    def read(path):
        root = ElementTree.parse(path).getroot()
        numbers = lambda element, key: np.array([float(number) for number in (element.get(key) or "0 0 0").split()])
        inertial = {link.get("name"): link.find("inertial") for link in root.findall("link")}
        joints = root.findall("joint")
        assert [joint.get("type") for joint in joints] == ["revolute"] * 6 + ["fixed"], path
        assert all((numbers(joint.find("axis"), "xyz") == [0, 0, 1]).all() for joint in joints[:6]), path
        origins = [joint.find("origin") for joint in joints]
        moved = [inertial[joint.find("child").get("link")] for joint in joints]
        return Arm(
            translations=np.array([numbers(origin, "xyz") for origin in origins]),
            rotations=np.array([Rotation.from_euler("xyz", numbers(origin, "rpy")).as_matrix() for origin in origins]),
            masses=np.array([float(part.find("mass").get("value")) for part in moved]),
            centers=np.array([numbers(part.find("origin"), "xyz") for part in moved]),
        )

    def corrected_by(self, content):
        """With the corrections of a `correction.json`."""
        joints = content["joints"]
        for joint, entry in enumerate(joints):
            for harmonic in entry["harmonics"]:
                first = 2 * int(harmonic["order"]) - 2
                self.harmonics[joint, first : first + 2] = harmonic["sin"], harmonic["cos"]
        self.compliance = np.array([entry["compliance_rad_per_nm"] for entry in joints])
        self.gear_ratio = np.array([entry["gear_ratio"] for entry in joints])
        return self

    def frames(self, q):
        """Rotation and origin of each link, and of the flange, in base: shapes (N, 3, 3), (N, 3)."""
        rotation, origin, frames = np.broadcast_to(np.eye(3), (len(q), 3, 3)), np.zeros((len(q), 3)), []
        for joint in range(7):
            origin = origin + rotation @ self.translations[joint]
            rotation = rotation @ self.rotations[joint]
            if joint < 6:
                rotation = rotation @ Rotation.from_euler("z", q[:, [joint]]).as_matrix()
            frames.append((rotation, origin))
        return frames

    def torques(self, q):
        """Of gravity about each joint (N m), shape (N, 6)."""
        frames = self.frames(q)
        centers = [origin + rotation @ center for (rotation, origin), center in zip(frames, self.centers)]
        torques = np.zeros_like(q)
        for joint in range(6):
            rotation, origin = frames[joint]
            moments = (np.cross(centers[k] - origin, self.masses[k] * GRAVITY) for k in range(joint, 7))
            torques[:, joint] = np.einsum("ni,ni->n", rotation[:, :, 2], sum(moments))
        return torques

    def flange(self, measured):
        """Rotation and origin of the flange at measured positions."""
        once, twice = measured, 2 * measured
        waves = np.stack([np.sin(once), np.cos(once), np.sin(twice), np.cos(twice)], axis=-1)
        stiff = measured - np.einsum("njk,jk->nj", waves, self.harmonics) + self.gear_ratio * measured
        q = stiff
        if self.compliance.any():
            for _ in range(3):
                q = stiff + self.compliance * self.torques(q)
        return self.frames(q)[-1]


def with_errors(nominal, blocks, values):
    """The nominal arm with the values of blocks, those of one after the other."""
    arm = Arm(nominal.translations.copy(), nominal.rotations.copy(), nominal.masses, nominal.centers)
    for block in blocks:
        of_block, values = np.split(values, [6 * len(SCALE[block])])
        of_block = of_block.reshape(6, -1)
        if block == "origin":
            arm.translations[:6] += np.einsum("jik,jk->ji", nominal.rotations[:6], of_block[:, :3])
            arm.rotations[:6] = nominal.rotations[:6] @ Rotation.from_rotvec(of_block[:, 3:]).as_matrix()
        elif block == "compliance":
            arm.compliance = of_block[:, 0]
        else:
            arm.harmonics = of_block
    return arm


def placed(rotation, origin, points):
    """Base in the frame of the tracker (rotation, translation) and target on the flange, by least squares in turns."""
    target = np.zeros(3)
    for _ in range(200):
        found = origin + rotation @ target
        middle, of_points = found.mean(0), points.mean(0)
        turn, _ = Rotation.align_vectors(points - of_points, found - middle)
        turn = turn.as_matrix()
        shift = of_points - turn @ middle
        rows = (turn @ rotation).reshape(-1, 3)
        better = np.linalg.lstsq(rows, (points - shift - origin @ turn.T).ravel(), rcond=None)[0]
        if np.linalg.norm(better - target) < 1e-9:
            break
        target = better
    return turn, shift, target


def mean_distance(arm, measured):
    """Of the target from the tracker's points (mm), base and target fitted to them."""
    rotation, origin = arm.flange(measured.q)
    turn, shift, target = placed(rotation, origin, measured.points)
    found = (origin + rotation @ target) @ turn.T + shift
    return 1e3 * np.linalg.norm(found - measured.points, axis=1).mean()


def fitted(nominal, blocks, measured):
    """The arm with the values of blocks that fit best."""
    scale = np.concatenate([np.tile(SCALE[block], 6) for block in blocks])
    turn, shift, target = placed(*nominal.flange(measured.q), measured.points)

    def points(x):
        """In units of the noise, a row a measured point."""
        arm = with_errors(nominal, blocks, x[: scale.size] * scale)
        move, spin, at = np.split(x[scale.size :], 3)
        rotation, origin = arm.flange(measured.q)
        base = turn @ Rotation.from_rotvec(spin).as_matrix()
        return ((origin + rotation @ at) @ base.T + shift + move - measured.points) / NOISE

    steps = np.concatenate([np.full(scale.size, 1e-4), np.full(9, 1e-7)])
    x = np.concatenate([np.zeros(scale.size + 6), target])
    for _ in range(REWEIGHTINGS):
        weights = (1 + (np.linalg.norm(points(x), axis=1) / LINEAR) ** 2) ** -0.25
        residuals = lambda x: np.concatenate([(weights[:, None] * points(x)).ravel(), x[: scale.size]])
        slope = lambda x, k: (residuals(x + steps[k] * np.eye(x.size)[k]) - residuals(x - steps[k] * np.eye(x.size)[k])) / (2 * steps[k])
        jacobian = lambda x: np.stack([slope(x, k) for k in range(x.size)], axis=1)
        better = least_squares(residuals, x, jac=jacobian, x_scale="jac", max_nfev=10).x
        change, x = np.abs(better - x)[: scale.size].max(), better
        if change < 1e-3:
            break
    return with_errors(nominal, blocks, x[: scale.size] * scale)
