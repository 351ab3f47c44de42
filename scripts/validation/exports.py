"""Files for other programs against pinocchio on calibrated.urdf: DH parameters and joint origins of Universal Robots
multiplied out, a cell expanded by xacro, and joints behind transmissions of ros2_control."""

import json
import re
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import xacro
import yaml

from .commands import DATA, touchcal
from .kinematics import BUILTIN
from .report import Table, within

UR = DATA / "ur10" / "ur10.urdf"
ARMS = [BUILTIN / "iiwa14.urdf", BUILTIN / "panda.urdf", UR]
# Keys of `kinematics` in the order in which `ur_description` chains them, each with the joint of that origin.
UR_LINKS = {
    "shoulder": "shoulder_pan_joint",
    "upper_arm": "shoulder_lift_joint",
    "forearm": "elbow_joint",
    "wrist_1": "wrist_1_joint",
    "wrist_2": "wrist_2_joint",
    "wrist_3": "wrist_3_joint",
}
ROWS = 1000
CONTACTS = 100
# Newton's steps to the socket, and the longest of them (rad).
STEPS, LONGEST_STEP = 20, 0.5
# Standard deviation of joint origins (m, rad).
ORIGIN = 2e-3
# A point on the tip, and the socket in the base (m).
TOOL, SOCKET = np.array([0.05, 0.0, 0.1]), np.array([0.5, 0.2, 0.4])
SIDES = ("left_", "right_")
PROBLEM = """
[robot]
urdf = "{0}"
[tool]
kind = "point"
free = true
[[fixture]]
name = "socket"
kind = "socket"
free = true
[[contacts]]
file = "log.csv"
fixture = "socket"
[estimate]
parameters = ["joint_origin"]
"""


def in_socket(path, random):
    """Joint positions of an arm with wrong joint origins, at which a point beside its tip is in one socket."""
    model = pin.buildModelFromUrdf(str(path))
    for joint in range(1, model.njoints):
        model.jointPlacements[joint] = model.jointPlacements[joint] * pin.exp6(random.normal(0, ORIGIN, 6))
    data, tip, rows = model.createData(), model.nframes - 1, []

    tip_from_tool = pin.SE3(np.eye(3), TOOL)
    while len(rows) < CONTACTS:
        q = random.uniform(-2, 2, model.nq)
        for _ in range(STEPS):
            jacobian = tip_from_tool.toActionMatrixInverse() @ pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL)
            pin.framesForwardKinematics(model, data, q)
            base_from_tool = data.oMf[tip] * tip_from_tool
            gap = base_from_tool.actInv(SOCKET)
            step = np.linalg.pinv(jacobian[:3], rcond=1e-2) @ gap
            q = q + step / max(1.0, np.linalg.norm(step) / LONGEST_STEP)
        if np.linalg.norm(gap) < 1e-9:
            rows.append(q)
    return np.array(rows)


def with_transmissions(path, random):
    """The text of a description with transmissions of ros2_control for its moving joints."""
    joints = [joint.get("name") for joint in ET.parse(path).getroot().findall("joint") if joint.get("type") != "fixed"]
    transmission = (
        '<transmission name="{0}_t"><plugin>transmission_interface/SimpleTransmission</plugin><joint name="{0}" role="joint1">'
        "<mechanical_reduction>{1}</mechanical_reduction><offset>{2}</offset></joint></transmission>"
    )
    each = [transmission.format(joint, random.uniform(-100, 100), random.uniform(-1, 1)) for joint in joints]
    system = f'<ros2_control name="arm" type="system">{"".join(each)}</ros2_control>'
    return path.read_text().replace("</robot>", system + "</robot>")


def calibrated(path, random, folder):
    """The folder of a calibration, and its parameters."""
    np.savetxt(folder / "log.csv", in_socket(path, random), delimiter=",", fmt="%.9f")
    (folder / "arm.urdf").write_text(with_transmissions(path, random))
    (folder / "problem.toml").write_text(PROBLEM.format("arm.urdf"))
    touchcal("calibrate", folder / "problem.toml", "--out", folder / "out", "--export", "dh,xacro,ros2_control" + (",ur" if path == UR else ""))
    file = json.loads((folder / "out/dh.json").read_text())
    return folder / "out", file


class Poses:
    """Poses of one link in another by pinocchio."""

    def __init__(self, model, base, tip):
        self.model, self.data = model, model.createData()
        self.base, self.tip = model.getFrameId(base), model.getFrameId(tip)

    def at(self, positions):
        """With joint positions by name; the others are neutral."""
        q = pin.neutral(self.model)
        for name, position in positions.items():
            joint = self.model.joints[self.model.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = [position] if joint.nq == 1 else [np.cos(position), np.sin(position)]
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip])


def cell(folder, file):
    """Pinocchio's model of two of these arms beside each other, of a description that xacro expands."""
    name = re.search(r'<xacro:macro name="(\w+)"', (folder / "calibrated.xacro").read_text())[1]
    arm = (
        '<xacro:{0} prefix="{1}"/><joint name="to_{1}" type="fixed"><origin xyz="1 2 3" rpy="1 2 3"/>'
        '<parent link="world"/><child link="{1}{2}"/></joint>'
    )
    path = folder / "cell.xacro"
    path.write_text(
        '<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="world"/>'
        f'<xacro:include filename="{folder / "calibrated.xacro"}"/>'
        + "".join(arm.format(name, side, file["base"]) for side in SIDES)
        + "</robot>"
    )
    return pin.buildModelFromXML(xacro.process_file(str(path)).toxml())


def transform(entry):
    angles = np.radians(entry["roll_pitch_yaw_deg"])
    return pin.SE3(pin.rpy.rpyToMatrix(*angles), 1e-3 * np.array(entry["xyz_mm"]))


def multiplied(file, convention, positions):
    """The tip's pose of the parameters."""
    about = lambda axis, degrees: pin.SE3(pin.AngleAxis(np.radians(degrees), np.eye(3)[axis]).matrix(), np.zeros(3))
    along = lambda axis, millimetres: pin.SE3(np.eye(3), 1e-3 * millimetres * np.eye(3)[axis])
    pose = transform(file["base_from_dh_base"])
    for row in file[convention]:
        theta, d, position = row["theta_offset_deg"], row["d_offset_mm"], positions[row["joint"]]
        theta, d = (theta, d + 1e3 * position) if row["kind"] == "prismatic" else (theta + np.degrees(position), d)
        about_z = about(2, theta) * along(2, d)
        about_x = along(0, row["a_mm"]) * about(0, row["alpha_deg"]) * about(1, row["beta_deg"])
        pose = pose * about_z * about_x if convention == "standard" else pose * about_x * about_z
    return pose * transform(file["dh_last_from_tip"])


def about_axis(axis, angle):
    """A rotation about x, y or z as a 4 × 4 matrix."""
    matrix, first, second = np.eye(4), (axis + 1) % 3, (axis + 2) % 3
    matrix[first, first] = matrix[second, second] = np.cos(angle)
    matrix[second, first] = np.sin(angle)
    matrix[first, second] = -matrix[second, first]
    return matrix


def chained(kinematics, positions):
    """The pose of `wrist_3_link` of joint origins, of which roll, pitch and yaw are about fixed axes in this order."""
    pose = np.eye(4)
    for link, joint in UR_LINKS.items():
        origin = kinematics[link]
        place = np.eye(4)
        place[:3, 3] = [origin[key] for key in "xyz"]
        turn = about_axis(2, origin["yaw"]) @ about_axis(1, origin["pitch"]) @ about_axis(0, origin["roll"])
        pose = pose @ place @ turn @ about_axis(2, positions[joint])
    return pin.SE3(pose)


def ur_errors(folder, random):
    """Distance and angle of `wrist_3_link` by `ur_kinematics.yaml` to that of calibrated.urdf."""
    kinematics = yaml.safe_load((folder / "ur_kinematics.yaml").read_text())["kinematics"]
    model = pin.buildModelFromUrdf(str(folder / "calibrated.urdf"))
    wrist_3 = model.frames[model.getFrameId("wrist_3_joint")]
    link = next(frame.name for frame in model.frames if frame.parentJoint == wrist_3.parentJoint and frame.type == pin.BODY)
    arm, found = Poses(model, "base_link", link), []
    for _ in range(ROWS):
        positions = {joint: random.uniform(-np.pi, np.pi) for joint in UR_LINKS.values()}
        found.append(np.abs(pin.log6(arm.at(positions).actInv(chained(kinematics, positions))).vector).max())
    return found


def transmissions(path):
    """Reduction and offset of each joint."""
    joints = ET.parse(path).getroot().iterfind("ros2_control/transmission/joint")
    return {joint.get("name"): [float(joint.find(key).text) for key in ("mechanical_reduction", "offset")] for joint in joints}


def behind(before, after, positions):
    """Joint positions where actuators stand as they do at `positions` with other transmissions."""
    actuators = {name: (position - before[name][1]) * before[name][0] for name, position in positions.items()}
    return {name: actuator / after[name][0] + after[name][1] for name, actuator in actuators.items()}


def errors(path, seed):
    """Distance and angle of each file's poses to those of calibrated.urdf, by file."""
    random = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        folder, file = calibrated(path, random, Path(folder))
        model = pin.buildModelFromUrdf(str(folder / "calibrated.urdf"))
        two = cell(folder, file)
        other = pin.buildModelFromUrdf(str(folder / "ros2_control.urdf"))
        before, after = (transmissions(folder / name) for name in ("calibrated.urdf", "ros2_control.urdf"))
        of_ur = ur_errors(folder, random) if path == UR else []
    arm = Poses(model, file["base"], file["tip"])
    with_offsets = Poses(other, file["base"], file["tip"])
    sides = {side: Poses(two, side + file["base"], side + file["tip"]) for side in SIDES}
    found = {"standard": [], "modified": [], "ros2_control": [], **{side: [] for side in SIDES}, "ur": of_ur}
    names = [row["joint"] for row in file["standard"]]
    for _ in range(ROWS):
        positions = dict(zip(names, random.uniform(-np.pi, np.pi, len(names))))
        poses = {convention: multiplied(file, convention, positions) for convention in ("standard", "modified")}
        poses["ros2_control"] = with_offsets.at(behind(before, after, positions))
        for side in SIDES:
            poses[side] = sides[side].at({side + name: position for name, position in positions.items()})
        expected = arm.at(positions)
        for name, pose in poses.items():
            found[name].append(np.abs(pin.log6(expected.actInv(pose)).vector).max())
    return found


def tables(_options):
    found = [errors(path, seed) for seed, path in enumerate(ARMS, 1)]
    of = lambda name: np.concatenate([each[name] for each in found])
    row = lambda what, why, arms=f"{len(ARMS)} arms": {
        "what": what,
        "reference": f"pinocchio on calibrated.urdf: {arms}, {ROWS} random positions of each",
        "why": why,
        "command": "`scripts/validate --only exports`",
    }
    rounded = "numbers of the file are rounded to 1e-10 mm and 1e-10°"
    return [
        Table(
            [
                within(row("`dh.json`, standard (m, rad)", rounded), of("standard"), 1e-10),
                within(row("`dh.json`, modified (m, rad)", rounded), of("modified"), 1e-10),
                within(
                    row("`ros2_control.urdf`, at the same positions of actuators (m, rad)", "rounding"), of("ros2_control"), 1e-12
                ),
                within(
                    row("`calibrated.xacro`, two arms in a cell that xacro expands (m, rad)", "rounding"),
                    np.concatenate([of(side) for side in SIDES]),
                    1e-13,
                ),
            ]
        ),
        Table([within(row("`ur_kinematics.yaml`, `wrist_3_link` (m, rad)", "rounding", "a UR10"), of("ur"), 1e-12)]),
    ]
