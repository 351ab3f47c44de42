"""What is sent to other processes is there what it was here."""

import copyreg
import json
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import joblib
import numpy as np
import pytest

import touchcal
from touchcal import Fixture, Manifold, Problem, Tool

PRESETS = ["paper", "workcell", "mukca"]


def sent(thing):
    return pickle.loads(pickle.dumps(thing))


def text(calibration: touchcal.Calibration) -> dict[str, object]:
    """estimate.json but for the clock."""
    content = json.loads(calibration.to_json())
    return {key: value for key, value in content.items() if key not in ("created", "seconds")}


def same(left: touchcal.Calibration, right: touchcal.Calibration) -> bool:
    return text(left) == text(right) and left.covariance.tobytes() == right.covariance.tobytes()


def built() -> Problem:
    """A problem of its parts, with one of everything."""
    robot = touchcal.Robot.from_urdf("iiwa14", gravity=(0, 0, 9.81))
    simulation = touchcal.simulate("workcell", 5, contacts=100)
    frame = simulation.to_pandas("hole")
    log = touchcal.ContactLog.from_pandas(robot, frame, force_threshold=3, load_on="tool", name="hole.csv")
    peg = touchcal.extrusion25()
    hole = Manifold.peg_in_hole(peg, touchcal.offset_outline(peg, 0.0005), length=0.04, depth=0.03)
    place = touchcal.pose((0.6, 0.1, 0.15), rpy=(0, 0, 0.35))
    fixture = Fixture("hole", hole, place, sigma=1e-3, sigma_angle=5e-3, clearance_sigma=2e-5, depth_sigma=5e-5, edge_radius_sigma=5e-5)
    return Problem(
        robot,
        Tool(touchcal.pose((0, 0, 0.15)), sigma=2e-4, sigma_angle=2e-3),
        [fixture],
        {"hole": [log]},
        parameters=["strain", "joint_offset", "joint_compliance"],
        noise={"force_bias_n": 0.5, "torque_bias_nm": 0.05, "force_noise_n": 0.1, "torque_noise_nm": 0.005, "wrench_scale": 0.02},
        estimate={"prior": {"joint_compliance_rad_per_nm": 1e-5}},
        accept={"tolerance_mm": 1, "joints_deg": [[-10, 10]] * 7},
    )


@pytest.fixture(scope="module")
def problem() -> Problem:
    # Sending it warns no more: warnings are errors.
    with pytest.warns(UserWarning, match="the URDF lacks masses"):
        return built()


def test_processes_give_the_bits_of_a_loop() -> None:
    problems = [touchcal.simulate(PRESETS[seed % 3], seed, contacts=60).problem() for seed in range(20)]
    alone = [touchcal.calibrate(problem) for problem in problems]
    by_joblib = joblib.Parallel(n_jobs=2)(joblib.delayed(touchcal.calibrate)(problem) for problem in problems)
    # A process that was forked from one that has calibrated has none of its threads.
    with ProcessPoolExecutor(2, mp_context=get_context("fork")) as processes:
        by_fork = list(processes.map(touchcal.calibrate, problems[:3], timeout=60))
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        by_futures = list(processes.map(touchcal.calibrate, problems[:3]))
    assert len(by_joblib) == 20 and len(by_futures) == 3
    assert all(map(same, alone, by_joblib)) and all(map(same, alone, by_futures))
    assert len(by_fork) == 3 and all(map(same, alone, by_fork))
    # Results that are all alike would be the same whatever is sent.
    assert len({calibration.covariance.tobytes() for calibration in alone}) == 20


def test_a_problem_of_parts_is_the_same(problem: Problem, tmp_path: Path) -> None:
    other = sent(problem)
    assert other.inputs == problem.inputs and other.notes == problem.notes
    assert np.array_equal(other.robot.gravity, [0, 0, 9.81]) and other.q.tobytes() == problem.q.tobytes()
    calibration = touchcal.calibrate(problem)
    assert same(calibration, touchcal.calibrate(other))
    # Its arguments came along.
    fewer = {"parameters": ["strain"], "noise": None}
    assert same(touchcal.calibrate(other.with_(**fewer)), touchcal.calibrate(problem.with_(**fewer)))


def test_a_calibration_is_the_same(problem: Problem, tmp_path: Path) -> None:
    calibration = touchcal.calibrate(problem, free_suspects=False)
    other = sent(calibration)
    assert (other.to_json(), other.to_html()) == (calibration.to_json(), calibration.to_html())
    assert (other.summary(), other._repr_html_()) == (calibration.summary(), calibration._repr_html_())
    for each in ("parameters", "null_space", "prefit", "postfit", "warnings", "effect_tests", "prior_tests", "untested", "acceptance", "termination", "steps", "competing_minima", "predictive_check", "workspace_uncertainty", "seconds"):
        assert getattr(other, each) == getattr(calibration, each), each
    assert other.contacts_to_pandas().equals(calibration.contacts_to_pandas())
    for folder, result in (("here", calibration), ("there", other)):
        result.save(tmp_path / folder, export=["dh", "xacro"])
    names = sorted(path.name for path in (tmp_path / "here").iterdir())
    assert names == sorted(path.name for path in (tmp_path / "there").iterdir())
    assert len(names) == 7 and "correction.json" in names
    for name in names:
        assert (tmp_path / "here" / name).read_bytes() == (tmp_path / "there" / name).read_bytes(), name
    assert repr(touchcal.evaluate(problem, other)) == repr(touchcal.evaluate(problem, calibration))


def test_a_problem_that_was_read_carries_its_contents(workcell: Path, tmp_path: Path) -> None:
    folder = tmp_path / "moved"
    folder.mkdir()
    for path in workcell.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    problem = Problem.from_toml(folder / "problem.toml")
    sent_away = pickle.dumps(problem)
    for path in folder.iterdir():
        path.unlink()
    other = pickle.loads(sent_away)
    assert other.inputs == problem.inputs and other.notes == problem.notes
    assert same(touchcal.calibrate(problem), touchcal.calibrate(other))


def test_inspections_and_evaluations_are_the_same(problem: Problem) -> None:
    inspection = touchcal.inspect(problem)
    other = sent(inspection)
    assert other.to_pandas().equals(inspection.to_pandas()) and other.ranges == inspection.ranges
    assert other.nominal == inspection.nominal and other.null_space == inspection.null_space
    evaluation = touchcal.evaluate(problem, touchcal.calibrate(problem))
    other = sent(evaluation)
    assert (other.all, other.scatter, other.per_fixture) == (evaluation.all, evaluation.scatter, evaluation.per_fixture)


def test_manifolds_are_the_same(tmp_path: Path) -> None:
    generator = np.random.default_rng(2)
    poses = np.array([touchcal.pose(xyz, rpy=rpy) for xyz, rpy in generator.uniform(-5e-3, 5e-3, (50, 2, 3))])
    peg, hole = tmp_path / "peg.obj", tmp_path / "hole.obj"
    # A wedge is no prism along z; the body around the hole is a box with a square hole.
    peg.write_text(solid([(-10, -10), (10, -10), (10, 10), (-10, 10)], 0, 40, 0.8))
    hole.write_text(block())
    shape = touchcal.extrusion25()
    network = Path(__file__).parents[2] / "fuzz/corpus/weights/good.safetensors"
    manifolds = [
        Manifold.ball_in_socket(),
        Manifold.plane([(0, 0, 0), (0.01, 0, 0)], radius=0.002),
        Manifold.peg_in_hole(shape, touchcal.offset_outline(shape, 0.0005), length=0.04, depth=0.03, peg_edge_radius=2e-4),
        Manifold.meshes(peg, hole, depth=0.03),
        Manifold.nearest(poses[:20], neighbours=3),
        Manifold.learned(network),
    ]
    assert manifolds[3].name == "peg in hole, not straight"
    for manifold in manifolds:
        other = sent(manifold)
        assert other.name == manifold.name
        assert other.distance(poses).tobytes() == manifold.distance(poses).tobytes(), manifold
    assert sent(manifolds[4]).project(poses).tobytes() == manifolds[4].project(poses).tobytes()


def solid(outline: list[tuple[float, float]], bottom: float, top: float, taper: float) -> str:
    """A frustum (mm), its top smaller by the factor `taper`."""
    count = len(outline)
    corners = [f"v {x} {y} {bottom}" for x, y in outline] + [f"v {taper * x} {taper * y} {top}" for x, y in outline]
    sides = [f"f {k + 1} {(k + 1) % count + 1} {count + (k + 1) % count + 1} {count + k + 1}" for k in range(count)]
    ends = ["f " + " ".join(str(count - k) for k in range(count)), "f " + " ".join(str(count + k + 1) for k in range(count))]
    return "\n".join(corners + sides + ends) + "\n"


def block() -> str:
    """A block of 40 mm, 30 mm high, with a square hole of 21 mm through it."""
    corners, faces = [], []
    for z in (-30, 0):
        for half in (20, 10.5):
            corners += [f"v {x} {y} {z}" for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))]
    for k in range(4):
        n = (k + 1) % 4
        outer, inner = (1 + k, 1 + n), (5 + k, 5 + n)
        faces += [f"f {outer[0]} {outer[1]} {outer[1] + 8} {outer[0] + 8}", f"f {inner[1]} {inner[0]} {inner[0] + 8} {inner[1] + 8}"]
        faces += [f"f {outer[0] + 8} {outer[1] + 8} {inner[1] + 8} {inner[0] + 8}", f"f {outer[1]} {outer[0]} {inner[0]} {inner[1]}"]
    return "\n".join(corners + faces) + "\n"


def test_parts_are_the_same(problem: Problem) -> None:
    robot = problem.robot
    assert (sent(robot).urdf, repr(sent(robot))) == (robot.urdf, repr(robot))
    log = touchcal.ContactLog.from_numpy(robot, np.linspace(-1, 1, 21).reshape(3, 7), temperature=[20, 21.5, 22])
    other = sent(log)
    assert other.q.tobytes() == log.q.tobytes() and list(other.temperature) == [20, 21.5, 22]
    assert (other.notes, list(other.lines), other.rows_read) == (log.notes, list(log.lines), log.rows_read)
    tool = Tool(touchcal.pose((0, 0, 0.1)), sigma=1e-3)
    assert repr(sent(tool)) == repr(tool)
    fixture = Fixture("left/0", Manifold.ball_in_socket(), free=True)
    assert repr(sent(fixture)) == repr(fixture)
    error = touchcal.InputError("words")
    assert sent(error).args == error.args and type(sent(error)) is touchcal.InputError


def test_what_cannot_be_sent_says_what_can(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = touchcal.simulate("workcell", 1, contacts=20)
    with pytest.raises(TypeError, match="a touchcal.Simulation cannot be pickled; simulate with the same scenario and seed"):
        pickle.dumps(simulation)
    campaign = touchcal.Campaign(tmp_path / "campaign", "workcell", 1)
    with pytest.raises(TypeError, match="a touchcal.Campaign cannot be pickled; send `files`"):
        pickle.dumps(campaign)
    older = pickle.dumps(Tool(exact=True)).replace(touchcal.__version__.encode(), b"0.0.1")
    with pytest.raises(touchcal.InputError, match="expected an object of touchcal .*, found one of 0.0.1"):
        pickle.loads(older)


def test_another_revision_is_another_version(problem: Problem, run) -> None:
    rebuild, (version, arguments) = problem.__reduce__()
    # Beside the version the command has the revision, where the sources are a checkout.
    assert run("--version").strip() == f"touchcal {version}"
    restored = copyreg.dispatch_table[Tool](Tool(exact=True))
    assert isinstance(restored, tuple) and restored[1][1] == version
    assert len(rebuild(version, arguments)) == len(problem)
    with pytest.raises(touchcal.InputError, match=re.escape(f"expected an object of touchcal {version}, found one of {version[:-2]}!)")):
        rebuild(f"{version[:-2]}!)", arguments)


def test_a_problem_is_changed_by_name(problem: Problem) -> None:
    strain = problem.with_(parameters=["strain"], noise=None, accept=None)
    names = [parameter.name for parameter in touchcal.calibrate(strain).parameters]
    assert "strain" in names and not any(name.startswith("joint_") for name in names)
    assert touchcal.calibrate(strain).acceptance is None and touchcal.calibrate(problem.with_(parameters=["strain"], noise=None)).acceptance
    with pytest.raises(TypeError, match="unexpected keyword argument 'tolerances'"):
        problem.with_(tolerances=1)
    with pytest.raises(touchcal.InputError, match="found \"strian\""):
        problem.with_(parameters=["strian"])


def test_later_changes_of_arguments_change_no_problem() -> None:
    robot = touchcal.Robot.from_urdf("iiwa14")
    log = touchcal.ContactLog.from_numpy(robot, np.random.default_rng(1).uniform(-1, 1, (30, 7)))
    logs, noise = {"a/0": [log]}, {"encoder_deg": 0.01}
    joints = np.array([[-10.0, 10.0]] * 7)
    accept = {"tolerance_mm": 1, "joints_deg": joints}
    sockets = [Fixture("a/0", Manifold.ball_in_socket(), free=True)]
    problem = Problem(robot, Tool(exact=True), sockets, logs, parameters=["strain"], noise=noise, accept=accept)
    before = touchcal.calibrate(problem).acceptance
    noise["encoder"] = 1
    logs["a/0"].clear()
    joints[:] = [[20, 30]] * 7
    assert before and [touchcal.calibrate(each).acceptance for each in (sent(problem), problem.with_())] == [before, before]
    assert len(sent(problem)) == len(problem) == len(problem.with_(parameters=["joint_offset"])) == 30
