"""Robots and logs: kinematics against an independent walk along the URDF, and arrays understood as files are."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import touchcal


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def walk(robot: touchcal.Robot, q: np.ndarray) -> np.ndarray:
    """base_from_tip as a matrix, from the URDF's text."""
    joints = {joint.find("child").get("link"): joint for joint in ElementTree.fromstring(robot.urdf).iter("joint")}
    chain, link = [], robot.tip
    while link != robot.base:
        chain.insert(0, joints[link])
        link = joints[link].find("parent").get("link")
    pose, positions = np.eye(4), iter(q)
    for joint in chain:
        origin, step = joint.find("origin"), np.eye(4)
        if origin is not None:
            roll, pitch, yaw = map(float, origin.get("rpy", "0 0 0").split())
            step[:3, :3] = rotation(np.array([0, 0, 1]), yaw) @ rotation(np.array([0, 1, 0]), pitch)
            step[:3, :3] = step[:3, :3] @ rotation(np.array([1, 0, 0]), roll)
            step[:3, 3] = list(map(float, origin.get("xyz", "0 0 0").split()))
        if joint.get("type") in ("revolute", "continuous"):
            turn = np.eye(4)
            turn[:3, :3] = rotation(np.array(list(map(float, joint.find("axis").get("xyz").split()))), next(positions))
            step = step @ turn
        pose = pose @ step
    return pose


def matrix(pose: np.ndarray) -> np.ndarray:
    """A pose of seven numbers as a matrix."""
    x, y, z, qw, *v = pose
    full = np.eye(4)
    full[:3, 3] = x, y, z
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    full[:3, :3] = np.eye(3) + 2 * qw * cross + 2 * cross @ cross
    return full


@pytest.mark.parametrize("name", touchcal.Robot.builtins())
def test_kinematics(name: str) -> None:
    robot = touchcal.Robot.from_urdf(name)
    limits = robot.limits
    q = np.random.default_rng(5).uniform(limits[:, 0], limits[:, 1], (20, robot.dof))
    poses = robot.base_from_tip(q)
    assert poses.shape == (20, 7)
    for pose, positions in zip(poses, q, strict=True):
        assert np.allclose(matrix(pose), walk(robot, positions), atol=1e-12)
    assert np.array_equal(robot.base_from_tip(q[3]), poses[3:4])
    assert np.array_equal(robot.base_from_tip(np.asfortranarray(q)[::2]), poses[::2])


def test_an_arm_stands_as_its_maker_says() -> None:
    robot = touchcal.Robot.from_urdf("iiwa14")
    assert robot.base_from_tip(np.zeros(7))[0, :3] == pytest.approx([0, 0, 0.36 + 0.42 + 0.4 + 0.126])
    assert robot.joints == [f"joint_a{k}" for k in range(1, 8)]
    assert (robot.name, robot.base, robot.tip, robot.dof) == ("iiwa14", "base_link", "flange", 7)
    assert robot.gravity.tolist() == [0, 0, -9.81]
    assert touchcal.Robot.from_urdf("iiwa14", gravity=(0, 0, 0)).gravity.tolist() == [0, 0, 0]
    with pytest.raises(touchcal.InputError, match=r"q: expected shape \(N, 7\), found shape \[6\]"):
        robot.base_from_tip(np.zeros(6))


def test_poses_are_seven_numbers_or_matrices() -> None:
    pose = touchcal.pose((0.1, 0.2, 0.3), rpy=(0.4, -0.5, 0.6))
    roll, pitch, yaw = (
        rotation(axis, angle) for axis, angle in zip(np.eye(3), (0.4, -0.5, 0.6), strict=True)
    )
    assert np.allclose(matrix(pose)[:3, :3], yaw @ pitch @ roll, atol=1e-15)
    ball = touchcal.Manifold.ball_in_socket()
    assert ball.distance([matrix(pose)]) == pytest.approx(ball.distance([pose]), abs=1e-15)
    for bad in (np.ones((4, 4)), np.ones(7), np.full(7, np.nan), np.zeros(6), np.diag([1.0, 1, -1, 1])):
        with pytest.raises(touchcal.InputError, match="^tip_from_tool: expected"):
            touchcal.Tool(bad)


@pytest.fixture(scope="module")
def robot() -> touchcal.Robot:
    return touchcal.Robot.from_urdf("iiwa14")


def test_arrays_frames_and_files_are_one_log(robot: touchcal.Robot, workcell: Path) -> None:
    path = workcell / "hole.csv"
    frame = pd.read_csv(path)
    q = frame[robot.joints].to_numpy()
    wrench = frame[["fx", "fy", "fz", "tx", "ty", "tz"]].to_numpy()
    file = touchcal.ContactLog.from_file(robot, path, force_threshold=3)
    assert 0 < len(file) < file.rows_read == len(frame)
    arrays = touchcal.ContactLog.from_numpy(robot, q, wrench=wrench, force_threshold=3)
    frames = touchcal.ContactLog.from_pandas(robot, frame, force_threshold=3)
    for log in (arrays, frames):
        assert np.array_equal(log.q, file.q)
        assert np.array_equal(log.lines + 1, file.lines)
        assert log.rows_read == file.rows_read
    force = np.linalg.norm(wrench[:, :3], axis=1)
    assert np.array_equal(file.q, q[force > 3])
    assert not file.loads.any()


def test_a_wrench_is_a_load_on_the_tool(robot: touchcal.Robot, workcell: Path) -> None:
    path = workcell / "hole.csv"
    frame = pd.read_csv(path)
    q = frame[robot.joints].to_numpy()
    wrench = frame[["fx", "fy", "fz", "tx", "ty", "tz"]].to_numpy()
    file = touchcal.ContactLog.from_file(robot, path, load_on="tool")
    assert file.loads.shape == (len(file), 6)
    assert np.array_equal(file.loads, wrench[file.lines - 2])
    arrays = touchcal.ContactLog.from_numpy(robot, q, wrench=-wrench, contact=frame["contact"], load_on="fixture")
    assert np.array_equal(arrays.loads, file.loads)
    turns = np.array([walk(robot, positions)[:3, :3] for positions in q])
    in_base = np.hstack([np.einsum("nij,nj->ni", turns, part) for part in (wrench[:, :3], wrench[:, 3:])])
    frame[["fx", "fy", "fz", "tx", "ty", "tz"]] = in_base
    frames = touchcal.ContactLog.from_pandas(robot, frame, load_on="tool", load_frame="base")
    np.testing.assert_allclose(frames.loads, file.loads, atol=1e-12)
    lagging = touchcal.ContactLog.from_file(robot, path, load_on="tool", load_lag=2)
    change = wrench - np.vstack([wrench[:1], wrench[:-1]])
    np.testing.assert_allclose(lagging.loads, (wrench + 2 * change)[file.lines - 2], atol=1e-9)


def test_measured_joint_torques_are_those_of_the_load(robot: touchcal.Robot, tmp_path: Path) -> None:
    chance = np.random.default_rng(5)
    q, torques = chance.uniform(-1, 1, (30, 7)), chance.uniform(-50, 50, (30, 7))
    arrays = touchcal.ContactLog.from_numpy(robot, q, joint_torques=torques, tau_joint="load")
    assert np.array_equal(arrays.joint_torques, torques)
    names = [*robot.joints, *(f"tau_{joint}" for joint in robot.joints)]
    frame = pd.DataFrame(np.hstack([q, -torques]), columns=names)
    frames = touchcal.ContactLog.from_pandas(robot, frame, tau_joint="motor")
    frame.to_csv(tmp_path / "log.csv", index=False)
    file = touchcal.ContactLog.from_file(robot, tmp_path / "log.csv", tau_joint="motor")
    for log in (frames, file):
        np.testing.assert_allclose(log.joint_torques, torques, rtol=1e-15)
    assert np.isnan(touchcal.ContactLog.from_pandas(robot, frame).joint_torques).all()
    for problem, arguments in [
        ("`tau_joint` or `load_on`, found both", {"tau_joint": "load", "load_on": "tool"}),
        ('"load" or "motor"', {"tau_joint": "arm"}),
        ("one without the other", {"tau_joint": "load"}),
        ("one without the other", {"joint_torques": torques}),
    ]:
        with pytest.raises(touchcal.InputError, match=problem):
            touchcal.ContactLog.from_numpy(robot, q, **arguments)


def test_temperatures_are_those_of_the_named_column(robot: touchcal.Robot, tmp_path: Path) -> None:
    q = np.random.default_rng(2).uniform(-1, 1, (30, 7))
    celsius = np.linspace(20, 32, 30)
    frame = pd.DataFrame(q, columns=robot.joints).assign(warm=celsius)
    frame.to_csv(tmp_path / "log.csv", index=False)
    arrays = touchcal.ContactLog.from_numpy(robot, q, temperature=celsius)
    frames = touchcal.ContactLog.from_pandas(robot, frame, temperature="warm")
    file = touchcal.ContactLog.from_file(robot, tmp_path / "log.csv", temperature="warm")
    for log in (arrays, frames, file):
        np.testing.assert_allclose(log.temperature, celsius, rtol=1e-12)
    assert np.isnan(touchcal.ContactLog.from_numpy(robot, q).temperature).all()
    with pytest.raises(touchcal.InputError, match="column `cold`"):
        touchcal.ContactLog.from_pandas(robot, frame, temperature="cold")


def test_any_layout_and_type_of_array(robot: touchcal.Robot) -> None:
    q = np.random.default_rng(1).uniform(-1, 1, (30, 7))
    plain = touchcal.ContactLog.from_numpy(robot, q)
    assert np.array_equal(plain.q, q) and not plain.q.flags.writeable
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, np.asfortranarray(q)).q, q)
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, np.repeat(q, 2, axis=0)[::2]).q, q)
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, q.tolist()).q, q)
    held = np.repeat(q, 3, axis=0)
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, held, apart=0.01).q, q)
    with pytest.warns(UserWarning, match="in 60 of 90 contacts no joint has moved by 0.01 deg"):
        assert len(touchcal.ContactLog.from_numpy(robot, held)) == 90
    single = q.astype(np.float32)
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, single).q, single.astype(np.float64))
    flags = q[:, 0] > 0
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, q, contact=flags).q, q[flags])
    degrees = touchcal.ContactLog.from_numpy(robot, np.degrees(q), unit="deg")
    assert np.allclose(degrees.q, q, rtol=1e-15)
    order = [6, 5, 4, 3, 2, 1, 0]
    reversed_names = [robot.joints[k] for k in order]
    assert np.array_equal(touchcal.ContactLog.from_numpy(robot, q[:, order], joints=reversed_names).q, q)


def test_columns_by_joint_name_or_another(robot: touchcal.Robot) -> None:
    q = np.random.default_rng(1).uniform(-1, 1, (5, 7))
    frame = pd.DataFrame(q, columns=robot.joints).assign(note="text", when=pd.Timestamp("2026-01-01"))
    assert np.array_equal(touchcal.ContactLog.from_pandas(robot, frame).q, q)
    renamed = frame.rename(columns={"joint_a1": "shoulder"})
    columns = {"joint_a1": "shoulder"}
    assert np.array_equal(touchcal.ContactLog.from_pandas(robot, renamed, columns=columns).q, q)
    with pytest.raises(touchcal.InputError, match="expected a column for every joint: `joint_a1` or `q1`"):
        touchcal.ContactLog.from_pandas(robot, renamed)
    with pytest.raises(touchcal.InputError, match="DataFrame:1, column joint_a3: expected a number in radians, found NaN"):
        touchcal.ContactLog.from_pandas(robot, frame.assign(joint_a3="much"))
    typed = frame.astype({"joint_a3": object})
    assert np.array_equal(touchcal.ContactLog.from_pandas(robot, typed).q, q)
    typed.loc[2, "joint_a3"] = "much"
    with pytest.raises(touchcal.InputError, match="DataFrame:3, column joint_a3: expected a number in radians, found NaN"):
        touchcal.ContactLog.from_pandas(robot, typed)
    with pytest.raises(TypeError, match="argument 'robot': expected a Robot, such as"):
        touchcal.ContactLog.from_pandas("iiwa14", frame)  # type: ignore[arg-type]


def test_what_is_guessed_is_said(robot: touchcal.Robot, tmp_path: Path) -> None:
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (30, 7))
    recorded = pd.DataFrame(np.degrees(q), columns=[f"axisQMsr_LBR_iiwa_14_R820_1[{k}]" for k in range(7)])
    recorded.to_csv(tmp_path / "kuka.csv", index=False)
    with pytest.warns(UserWarning, match="taken as DEGREES"):
        log = touchcal.ContactLog.from_file(robot, tmp_path / "kuka.csv")
    with pytest.warns(UserWarning, match="taken as DEGREES"):
        frame = touchcal.ContactLog.from_pandas(robot, recorded)
    for read in (log, frame):
        assert np.allclose(read.q, q) and "taken as DEGREES" in read.notes[0]
    declared = touchcal.ContactLog.from_file(robot, tmp_path / "kuka.csv", unit="deg")
    assert np.array_equal(declared.q, log.q) and declared.notes == []


def test_what_arrays_are_refused_for(robot: touchcal.Robot) -> None:
    q = np.random.default_rng(1).uniform(-1, 1, (30, 7))

    def refused(words: str, **arguments: object) -> None:
        with pytest.raises(touchcal.InputError, match=words):
            touchcal.ContactLog.from_numpy(**{"robot": robot, "q": q, "name": "rows", **arguments})  # type: ignore[arg-type]

    spoilt = q.copy()
    spoilt[3, 2] = np.inf
    refused("rows:4, column q3: expected a number in radians, found inf", q=spoilt)
    refused("looks like degrees; declare unit = \"deg\"", q=np.degrees(q) * 4)
    refused(r"q: expected shape \(N, 7\), found shape \[30, 6\]", q=q[:, :6])
    refused(r"wrench: expected shape \(30, 6\), found shape \[29, 6\]", wrench=np.zeros((29, 6)))
    refused(r"contact: expected shape \(30,\), found shape \[30, 2\]", contact=np.zeros((30, 2)))
    refused("expected 0, 1, true or false, found 0.5", contact=np.full(30, 0.5))
    refused("columns fx, fy and fz, which a force threshold needs", force_threshold=3)
    refused("apart: expected a positive number, found -1", apart=-1)
    refused("apart: expected at most 0.35 rad or m; of degrees, math.radians", apart=1)
    refused("release: expected at most force_threshold", force_threshold=3, release=4, wrench=np.zeros((30, 6)))
    refused("expected `force_threshold`, found `release` or `debounce` without it", release=4)
    refused("columns fx, fy, fz, tx, ty and tz, which a load needs", load_on="tool")
    refused("expected `load_on`, found `load_frame` without it", load_frame="base")
    refused("expected `load_on`, found `load_lag` without it", load_lag=1)
    refused("load_lag: expected a number of rows, at least 0, found -1", load_on="tool", load_lag=-1)
    refused("load_on: expected \"tool\" or \"fixture\", found \"tip\"", load_on="tip")
    refused("load_frame: expected \"tip\" or \"base\", found \"flange\"", load_on="tool", load_frame="flange")
    refused("unit: expected \"rad\" or \"deg\", found \"grad\"", unit="grad")
    refused("did you mean `joint_a1`", joints=["joint_b1", *robot.joints[1:]])
    refused("names of columns belong in `columns`", joints=["shoulder", *robot.joints[1:]])
    refused(r"all 7 moving joints \(.*\); names of columns belong in `columns`, found 6", joints=robot.joints[1:])
    refused("which a force threshold needs, or their names in `columns`", force_threshold=3)
    refused("expected rows of joint positions, found none", q=q[:0])
    with pytest.raises(ValueError, match="could not convert"):
        touchcal.ContactLog.from_numpy(robot, "some")
