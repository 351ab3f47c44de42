"""Forward kinematics and all Jacobians against pinocchio."""

import io
import xml.etree.ElementTree as xml

import numpy as np
import pinocchio as pin

from .commands import DATA, ROOT, example
from .report import Table, within

BUILTIN = ROOT / "crates/touchcal/src/robot/builtin"
ARMS = [
    BUILTIN / "iiwa14.urdf",
    BUILTIN / "panda.urdf",
    *(DATA / "mukca" / name for name in ("iiwa14.urdf", "panda.urdf", "gen3lite.urdf")),
]
ROWS = 2000
STEP = 1e-3
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


class Joint:
    """A joint of a URDF, as written there."""

    def __init__(self, element):
        def read(tag, key):
            found = element.find(tag)
            return [float(word) for word in (found.get(key, "0 0 0") if found is not None else "0 0 0").split()]

        self.name, self.kind = element.get("name"), element.get("type")
        self.parent, self.child = element.find("parent").get("link"), element.find("child").get("link")
        self.origin = pin.SE3(pin.rpy.rpyToMatrix(*read("origin", "rpy")), np.array(read("origin", "xyz")))


class Arm:
    """Pinocchio's model of a URDF's chain, its placements moved by touchcal's parameters."""

    def __init__(self, path):
        joints = {joint.parent: joint for joint in map(Joint, xml.parse(path).getroot().findall("joint"))}
        link = (set(joints) - {joint.child for joint in joints.values()}).pop()
        self.chain = []
        while link in joints:
            self.chain.append(joints[link])
            link = joints[link].child
        self.model = pin.buildModelFromUrdf(str(path))
        self.names = list(self.model.names)[1:]
        self.tip = self.model.getFrameId(link)
        self.tool = self.model.addFrame(pin.Frame("touchcal_tool", len(self.names), pin.SE3.Identity(), pin.FrameType.OP_FRAME))
        self.read = [placement.copy() for placement in self.model.jointPlacements][1:] + [
            self.model.frames[self.tip].placement.copy()
        ]
        self.set({})

    def set(self, values):
        """Takes over parameters by name. Masses are a kilogram in the middle of each link and one at the tip."""
        value = lambda name: values.get(name, 0.0)
        twist = lambda prefix: pin.exp6(np.array([value(f"{prefix}.{component}") for component in COMPONENTS]))
        placements, origin = [], pin.SE3.Identity()
        strains = self.strains(values)
        for joint in self.chain:
            step = joint.origin.copy()
            step.translation *= 1 + value("strain") + strains[joint.name]
            origin = origin * step
            if joint.kind != "fixed":
                placements.append(origin * twist(f"joint_origin.{joint.name}"))
                origin = pin.SE3.Identity()
        for index, placement in enumerate(placements):
            self.model.jointPlacements[index + 1] = placement
        self.placements = [*placements, origin]
        self.model.frames[self.tool].placement = origin * twist("tool")
        for index, placement in enumerate(self.placements[1:]):
            self.model.inertias[index + 1] = pin.Inertia(1.0, placement.translation / 2, np.zeros((3, 3)))
        self.model.inertias[len(placements)] += pin.Inertia(1.0, origin.translation, np.zeros((3, 3)))
        self.offsets = np.array([value(f"joint_offset.{name}") for name in self.names])
        self.data = self.model.createData()

    def strains(self, values):
        """Strain of each joint's origin by its segment, `segment_strain.FIRST..LAST`."""
        names = [joint.name for joint in self.chain]
        strains = dict.fromkeys(names, 0.0)
        for key in values:
            if key.startswith("segment_strain."):
                ends = key.removeprefix("segment_strain.").split("..")
                for name in names[names.index(ends[0]) : names.index(ends[-1]) + 1]:
                    strains[name] = values[key]
        return strains

    def configuration(self, q):
        """Pinocchio's positions; a joint without limits has cosine and sine."""
        positions = (q - self.offsets).tolist()
        sizes = [self.model.joints[index + 1].nq for index in range(len(positions))]
        return np.concatenate(
            [[position] if size == 1 else [np.cos(position), np.sin(position)] for position, size in zip(positions, sizes)]
        )

    def pose(self, q):
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return self.data.oMf[self.tool].copy()

    def jacobian(self, q):
        return pin.computeFrameJacobian(self.model, self.data, self.configuration(q), self.tool, pin.LOCAL)

    def torques(self, q):
        """Torques of gravity about the joints."""
        return -pin.computeGeneralizedGravity(self.model, self.data, self.configuration(q))


class Errors:
    """touchcal's numbers of an arm less pinocchio's."""

    def __init__(self, path, seed):
        text = example("kinematics", path, ROWS, seed)
        names, rest = text.split("\n", 1)
        self.names = names.split(",")
        numbers = rest.split("\n", 1)
        self.theta = dict(zip(self.names, map(float, numbers[0].split(","))))
        self.arm = Arm(path)
        read = zip(self.arm.read, self.arm.placements)
        self.origins = [np.abs(ours.homogeneous - theirs.homogeneous).max() for ours, theirs in read]
        rows = np.loadtxt(io.StringIO(numbers[1]), delimiter=",")
        n = len(self.arm.names)
        self.q, poses, twists = rows[:, :n], rows[:, n : n + 7], rows[:, n + 7 :].reshape(len(rows), -1, 6)
        self.poses = [pin.SE3(pin.Quaternion(*pose[3:]), pose[:3]) for pose in poses]
        self.joints, self.columns = twists[:, :n], dict(zip(self.names, twists[:, n:].transpose(1, 0, 2)))

    def place_and_rotation(self):
        self.arm.set(self.theta)
        differences = [self.arm.pose(q).actInv(pose) for q, pose in zip(self.q, self.poses)]
        return [np.linalg.norm(d.translation) for d in differences], [np.linalg.norm(pin.log3(d.rotation)) for d in differences]

    def by_joint(self):
        """Of the twists by joints, by offsets and by compliances."""
        self.arm.set(self.theta)
        jacobians = np.array([self.arm.jacobian(q).T for q in self.q])
        torques = np.array([self.arm.torques(q) for q in self.q])
        columns = lambda block: np.array([self.columns[f"{block}.{name}"] for name in self.arm.names]).transpose(1, 0, 2)
        bent = jacobians * torques[:, :, None]
        return self.joints - jacobians, columns("joint_offset") + jacobians, columns("joint_compliance") - bent

    def by_parameter(self, block):
        """Of the twists by a block's parameters, against central differences, extrapolated."""
        errors = []
        for name in (name for name in self.names if name.split(".")[0] == block):
            moved = {}
            for steps in (-2, -1, 1, 2):
                self.arm.set({**self.theta, name: self.theta[name] + steps * STEP})
                moved[steps] = [self.arm.pose(q) for q in self.q]
            slope = lambda k, row: pin.log6(moved[-k][row].actInv(moved[k][row])).vector
            for row, found in enumerate(self.columns[name]):
                # log(T(−h)⁻¹ T(h)) is twice the step about the middle to third order.
                errors.append(np.abs((8 * slope(1, row) - slope(2, row)) / (12 * STEP) - found).max())
        return errors


def tables(_options):
    arms = [Errors(path, seed) for seed, path in enumerate(ARMS, 1)]
    place, rotation = zip(*(arm.place_and_rotation() for arm in arms))
    joints, offsets, compliances = (
        np.concatenate([np.ravel(e) for e in each]) for each in zip(*(arm.by_joint() for arm in arms))
    )
    blocks = lambda *names: np.concatenate([arm.by_parameter(name) for arm in arms for name in names])
    rounding = "rounding: tens of sums and products of numbers about 1"
    extrapolated = "central differences of step 1e-3, extrapolated: its fourth power, and rounding over it"
    row = lambda what, why=rounding: {"what": what, "reference": "", "why": why, "command": ""}
    rows = [
        within(
            row("joints' origins read from the URDF (m, and rotation matrices)"),
            np.concatenate([arm.origins for arm in arms]),
            1e-14,
        ),
        within(row("place of the tool (m)"), np.concatenate(place), 2e-14),
        within(row("rotation of the tool (rad)"), np.concatenate(rotation), 2e-14),
        within(row("derivatives by joint positions (m/rad, 1)"), joints, 2e-14),
        within(row("by `joint_offset` (minus the derivatives by positions)"), offsets, 2e-14),
        within(row("by `joint_compliance` (times pinocchio's torques of gravity, N m)"), compliances, 1e-12),
        within(row("by `strain` and `segment_strain` (m)", extrapolated), blocks("strain", "segment_strain"), 1e-11),
        within(row("by `joint_origin` (m, m/rad, 1)", extrapolated), blocks("joint_origin"), 1e-11),
        within(row("by `tool`", extrapolated), blocks("tool"), 1e-11),
    ]
    for line in rows:
        line.reference = f"pinocchio on the same URDF: {len(ARMS)} URDFs, {ROWS} random positions of each, all other parameters random within their plausible size"
        line.command = "`scripts/validate --only kinematics`"
    return [Table(rows)]
