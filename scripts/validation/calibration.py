"""Whole calibrations against scipy on the same cost, with pinocchio's kinematics.

The cost is `Σ ‖W r(θ)‖² + Σ (θₖ/σₖ)² + Σ ((dᵢⱼ − d̂ᵢⱼ)/σᵢⱼ)²`: squared loss, noise and priors fixed. `W` whitens encoder and contact noise; it is held while scipy
minimises, and renewed until nothing changes, which is the equation that touchcal solves.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

from .commands import DATA, touchcal
from .kinematics import BUILTIN, Arm
from .report import Table, within

DEG, MM = np.pi / 180, 1e-3
ENCODER, CONTACT = 0.01 * DEG, 0.2 * MM
BALL_SIGMA, SPACING, SPACING_SIGMA = 2 * MM, 50 * MM, 0.05 * MM
ORIGIN_SIGMA = {"x": 0.5 * MM, "y": 0.5 * MM, "z": 0.5 * MM, "rx": 0.2 * DEG, "ry": 0.2 * DEG, "rz": 0.2 * DEG}
ARMS = [("kuka_14", "iiwa14.urdf"), ("panda_1", "panda.urdf"), ("panda_3", "panda.urdf"), ("dinova_2", "gen3lite.urdf")]
# Roll and pitch (deg) of a plane, a point of it (mm).
PLANES = {"floor": (0, 0, (500, 0, 100)), "left": (90, 0, (500, 350, 300)), "front": (0, -90, (750, 0, 300))}
# Warnings that contacts contradict the model, which widens standard deviations beyond those of the model.
WIDENING = ("omitted_effect", "prediction_contradicted")
REFERENCE = "scipy.optimize.least_squares, kinematics by pinocchio"


class Contacts:
    """Joint positions that touch a fixture."""

    def __init__(self, name, file, q):
        self.name, self.file, self.q = name, file, q


class Sockets:
    """A real arm's ball in free sockets, in pairs of a known distance."""

    def __init__(self, robot, urdf):
        folder = DATA / "mukca" / robot
        self.what, self.urdf, self.tool = robot, DATA / "mukca" / urdf, np.zeros(3)
        paths = sorted(folder.glob("*/hole_*.csv"))
        name = lambda path: f"{path.parent.name}/{path.stem.removeprefix('hole_')}"
        self.contacts = [Contacts(name(path), path, np.loadtxt(path, delimiter=",")) for path in paths]
        pairs = zip(self.contacts, self.contacts[1:])
        self.distances = [(a.name, b.name) for a, b in pairs if a.name.split("/")[0] == b.name.split("/")[0]]
        arm = Arm(self.urdf)
        self.places = {c.name: np.mean([arm.pose(q).translation for q in c.q], axis=0) for c in self.contacts}

    def toml(self):
        fixtures = [f'[[fixture]]\nname = "{c.name}"\nkind = "socket"\nfree = true\n' for c in self.contacts]
        between = [
            f'[[distance]]\nbetween = ["{a}", "{b}"]\nmm = {SPACING / MM}\nsigma_mm = {SPACING_SIGMA / MM}\n'
            for a, b in self.distances
        ]
        return f'[tool]\nkind = "ball"\nradius_mm = 5\nsigma_mm = {BALL_SIGMA / MM}\n' + "".join(fixtures + between)

    def rows(self, contacts, place, values):
        """Residual (m) and its derivative by the ball's place."""
        moved = [values[f"fixture.{contacts.name}.{axis}"] for axis in "xyz"]
        return place - self.places[contacts.name] - moved, np.eye(3)

    def known(self, values):
        """Whitened rows beside the contacts': distances, and the priors of the ball's place."""
        place = lambda name: self.places[name] + [values[f"fixture.{name}.{axis}"] for axis in "xyz"]
        lengths = np.array([np.linalg.norm(place(a) - place(b)) for a, b in self.distances])
        ball = [values[f"tool.{axis}"] / BALL_SIGMA for axis in "xyz"]
        return np.concatenate([(lengths - SPACING) / SPACING_SIGMA, ball])


class Planes:
    """A simulated arm's ball on three known planes."""

    RADIUS = 8 * MM
    TOOL = np.array([0.02, -0.03, 0.12])

    def __init__(self, folder):
        self.what, self.urdf, self.tool = "three planes", BUILTIN / "iiwa14.urdf", self.TOOL
        random = np.random.default_rng(5)
        arm = Arm(self.urdf)
        errors = {"strain": 0.02, **{f"joint_offset.{name}": random.uniform(-2, 2) * DEG for name in arm.names}}
        arm.set(with_tool(errors, self.TOOL))
        self.frames = {
            name: pin.SE3(pin.rpy.rpyToMatrix(roll * DEG, pitch * DEG, 0), np.array(place) * MM)
            for name, (roll, pitch, place) in PLANES.items()
        }
        self.contacts = []
        for name, frame in self.frames.items():
            q = np.array([self.touching(arm, frame, random) for _ in range(150)]) + random.normal(
                0, ENCODER, (150, len(arm.names))
            )
            path = folder / f"{name}.csv"
            np.savetxt(path, q, "%.17g", ",")
            self.contacts.append(Contacts(name, path, q))

    def touching(self, arm, frame, random):
        """Joint positions, drawn and then moved until the ball rests on the plane."""
        q = np.array([0.1, 0.7, 0.2, -1.5, -0.2, 0.9, 0.1]) + random.uniform(-0.5, 0.5, len(arm.names))
        height = random.normal(0, CONTACT)
        for _ in range(20):
            pose = arm.pose(q)
            slope = frame.rotation[:, 2] @ pose.rotation @ arm.jacobian(q)[:3]
            q = q - slope * (frame.actInv(pose.translation)[2] - self.RADIUS - height) / (slope @ slope)
        return q

    def toml(self):
        tool = f'[tool]\nkind = "ball"\nradius_mm = {self.RADIUS / MM}\ntip_from_tool = {{ xyz_mm = {list(map(float, self.TOOL / MM))} }}\nexact = true\n'
        plane = lambda name, roll, pitch, place: (
            f'[[fixture]]\nname = "{name}"\nkind = "plane"\nbase_from_fixture = {{ xyz_mm = {list(place)}, rpy_deg = [{roll}, {pitch}, 0] }}\nexact = true\n'
        )
        return tool + "".join(plane(name, *where) for name, where in PLANES.items())

    def rows(self, contacts, place, _values):
        frame = self.frames[contacts.name]
        return frame.actInv(place)[2:] - self.RADIUS, frame.rotation[:, 2:].T

    def known(self, _values):
        return np.zeros(0)


def with_tool(values, tool):
    """The parameters, the tool's place on the tip among them."""
    return {**values, **{f"tool.{axis}": values.get(f"tool.{axis}", 0.0) + at for axis, at in zip("xyz", tool)}}


def calibrated(problem, estimate, folder):
    """touchcal's estimate of a problem with an `[estimate]` table."""
    contacts = "".join(f'[[contacts]]\nfile = "{c.file}"\nfixture = "{c.name}"\n' for c in problem.contacts)
    noise = f"[noise]\nencoder_deg = {ENCODER / DEG}\ncontact_mm = {CONTACT / MM}\nencoder_trend_deg = 0\n"
    text = f'[robot]\nurdf = "{problem.urdf}"\n{problem.toml()}{contacts}{noise}[estimate]\nloss = "squared"\nunseen_effects = "ignore"\n{estimate}'
    (folder / "problem.toml").write_text(text)
    touchcal("calibrate", folder / "problem.toml", "--out", folder / "out")
    return json.loads((folder / "out/estimate.json").read_text())


class Peer:
    """The same cost, for scipy."""

    def __init__(self, problem, parameters):
        self.problem, self.arm = problem, Arm(problem.urdf)
        self.names = [entry["name"] for entry in parameters]
        self.of_arm = [k for k, entry in enumerate(parameters) if entry["block"] not in ("tool", "fixture")]
        self.sigma = np.array([prior(self.names[k]) for k in self.of_arm])

    def contacts(self, x, whiteners=None):
        """Whitened rows of all contacts, and what whitens them."""
        values = dict(zip(self.names, x))
        self.arm.set(with_tool(values, self.problem.tool))
        rows, whitening = [], []
        for contacts in self.problem.contacts:
            for q in contacts.q:
                pose = self.arm.pose(q)
                residual, slope = self.problem.rows(contacts, pose.translation, values)
                if whiteners is None:
                    by_joint = slope @ pose.rotation @ self.arm.jacobian(q)[:3] * ENCODER
                    covariance = by_joint @ by_joint.T + CONTACT**2 * np.eye(len(residual))
                    whitening.append(np.linalg.inv(np.linalg.cholesky(covariance)))
                rows.append((whitening if whiteners is None else whiteners)[len(rows)] @ residual)
        return np.concatenate(rows), whitening

    def known(self, x):
        finite = np.isfinite(self.sigma)
        priors = x[self.of_arm][finite] / self.sigma[finite]
        return np.concatenate([self.problem.known(dict(zip(self.names, x))), priors])

    def solve(self):
        """Estimate and standard deviations: noise above the declared one widens them."""
        x = np.zeros(len(self.names))
        scale = np.array([1e-3 if not name.endswith(("rx", "ry", "rz")) else 1e-2 for name in self.names])
        for _ in range(20):
            _, whiteners = self.contacts(x)
            cost = lambda x: np.concatenate([self.contacts(x, whiteners)[0], self.known(x)])
            found = least_squares(cost, x, jac="3-point", x_scale=scale, xtol=1e-15, ftol=1e-15, gtol=1e-15)
            rows = sum(len(whitener) for whitener in whiteners)
            contacts, known = found.jac[:rows], found.jac[rows:]
            factor = max(1.0, np.sqrt(np.mean(found.fun[:rows] ** 2)))
            sigma = np.sqrt(np.diag(np.linalg.inv(contacts.T @ contacts / factor**2 + known.T @ known)))
            moved, x = np.abs((found.x - x) / sigma).max(), found.x
            if moved < 1e-7:
                return x, sigma
        raise SystemExit(f"{self.problem.what}: scipy does not settle")


def prior(name):
    """Standard deviation of an arm's parameter; infinite where it has none."""
    return ORIGIN_SIGMA[name.rsplit(".", 1)[1]] if name.startswith("joint_origin") else np.inf


def compare(problem, what, estimate, folder):
    found = calibrated(problem, estimate, folder)
    parameters = found["parameters"]
    x, sigma = Peer(problem, parameters).solve()
    count = sum(len(contacts.q) for contacts in problem.contacts)
    text = f"{problem.what}, {count} contacts, {what}, {len(parameters)} parameters"
    values = np.array([entry["value"] for entry in parameters])
    known = [k for k, entry in enumerate(parameters) if entry["sigma"] is not None]
    ratios = np.array([parameters[k]["sigma"] / sigma[k] - 1 for k in known])
    is_wider = any(warning["kind"] in WIDENING for warning in found["warnings"])
    row = lambda what, why: {
        "what": f"{text}: {what}",
        "reference": REFERENCE,
        "why": why,
        "command": "`scripts/validate --only calibration`",
    }
    return [
        within(
            row("estimates, in standard deviations", "a tenth of what a last step of 0.1 standard deviations may leave"),
            (values - x) / sigma,
            0.01,
        ),
        within(
            row("standard deviations, relatively" + is_wider * ", how much narrower", "they change by as little with the estimate"),
            np.minimum(ratios, 0) if is_wider else ratios,
            1e-3,
        ),
    ]


def tables(_options):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        origins = f'parameters = ["joint_origin"]\nprior = {{ joint_origin_mm = {ORIGIN_SIGMA["x"] / MM}, joint_origin_deg = {ORIGIN_SIGMA["rx"] / DEG} }}\n'
        for robot, urdf in ARMS:
            rows += compare(Sockets(robot, urdf), "`joint_origin` with priors", origins, folder)
        rows += compare(Planes(folder), "`strain` and `joint_offset`", 'parameters = ["strain", "joint_offset"]\n', folder)
    return [Table(rows)]
