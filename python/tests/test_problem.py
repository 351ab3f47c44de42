"""Problems put together in code: what is refused, and how manifolds are."""

from pathlib import Path

import numpy as np
import pytest

import touchcal
from touchcal import Fixture, Manifold, Problem, Tool


@pytest.fixture(scope="module")
def robot() -> touchcal.Robot:
    return touchcal.Robot.from_urdf("iiwa14")


@pytest.fixture(scope="module")
def log(robot: touchcal.Robot) -> touchcal.ContactLog:
    return touchcal.ContactLog.from_numpy(robot, np.random.default_rng(1).uniform(-1, 1, (30, 7)))


def test_what_problems_are_refused_for(robot: touchcal.Robot, log: touchcal.ContactLog) -> None:
    ball = Manifold.ball_in_socket()
    sockets = [Fixture("a/0", ball, free=True), Fixture("a/1", ball, free=True)]

    def refused(words: str, **arguments: object) -> None:
        usual = {"robot": robot, "tool": Tool(exact=True), "fixtures": sockets, "contacts": {"a/0": log}, "parameters": ["strain"]}
        with pytest.raises(touchcal.InputError, match=words):
            Problem(**{**usual, **arguments})  # type: ignore[arg-type]

    refused("^Problem, estimate, parameters: expected a block of parameters .*, found \"strian\"; did you mean `strain`", parameters=["strian"])
    refused("^Problem: unknown field `encoder`, expected one of `encoder_deg`, `contact_mm`, `encoder_trend_deg`, `encoder_trend_over`, `encoder_walk_deg`, `estimated`, `force_bias_n`, `torque_bias_nm`, `force_noise_n`, `torque_noise_nm`, `wrench_scale`", noise={"encoder": 1})
    refused("encoder or contact noise above 0, found both 0", noise={"encoder_deg": 0, "contact_mm": 0})
    refused("^Problem, accept, tolerance_mm: expected .*, found none", accept={"joints_deg": [[0, 1]] * 7})
    refused("^Problem, accept: expected `postures_deg`, `joints_deg` or `region`", accept={"tolerance_mm": 1})
    refused("^Problem, accept, joints_deg: expected 7 pairs of numbers", accept={"tolerance_mm": 1, "joints_deg": [[0, 1]]})
    refused("^Problem, loss: unknown variant `l2`", estimate={"loss": "l2"})
    refused("did you mean `joint_offset.joint_a1`", parameters=["joint_offset"], estimate={"freeze": ["joint_offset.joint_b1"]})
    refused("expected the name of a fixture .*, found \"b\"", contacts={"b": log})
    refused("expected distinct names, found \"a/0\" twice", fixtures=[sockets[0], sockets[0]])
    refused("fixture `a`: expected `base_from_fixture`, or `free = true`, found none", fixtures=[Fixture("a", ball)])
    refused("fixture `p`: expected `base_from_fixture`, from where", fixtures=[Fixture("p", Manifold.plane(), free=True)])
    refused("distances: expected two fixtures", distances=[("a/0", "a/0", 0.05)])
    refused("distances: expected the name", distances=[("a/0", "c", 0.05)])
    with pytest.raises(touchcal.InputError, match="tool: expected free or standard deviations, found both"):
        Tool(free=True, sigma=1e-3)
    with pytest.raises(touchcal.InputError, match="tool, sigma: expected a number of at least 0, found -1"):
        Tool(sigma=-1)
    with pytest.raises(touchcal.InputError, match="tool: expected exact or standard deviations above 0, found both"):
        Tool(exact=True, sigma_angle=1e-3)
    with pytest.raises(touchcal.InputError, match="tool: expected free or exact, found both"):
        Tool(exact=True, free=True)
    with pytest.raises(touchcal.InputError, match=r"^tip_from_tool: expected a translation of at most 10 m \(lengths are metres\), found 120 m$"):
        Tool(touchcal.pose((0, 0, 120)))
    with pytest.raises(touchcal.InputError, match="fixture `a`, base_from_fixture: expected a translation of at most 10 m"):
        Fixture("a", ball, touchcal.pose((0, 10.01, 0)))
    assert Tool(touchcal.pose((0, 0, 9.99)))
    with pytest.raises(touchcal.InputError, match='fixture `a`, exact: expected True, False, or a list of place, found "depth"'):
        Fixture("a", ball, exact=["depth"])
    with pytest.raises(touchcal.InputError, match="fixture `a`, clearance_sigma: expected what belongs to a manifold without a hole"):
        Fixture("a", ball, clearance_sigma=1e-5)
    with pytest.raises(touchcal.InputError, match='fixture `h`, depth_sigma: expected depth_sigma or exact with "depth", found both'):
        Fixture("h", hole(), touchcal.pose(), depth_sigma=1e-5, exact=["depth"])
    with pytest.raises(touchcal.InputError, match="fixture `h`, clearance_sigma: expected a number of at least 0, found -1"):
        Fixture("h", hole(), touchcal.pose(), clearance_sigma=-1)


def test_arguments_of_another_type_are_named(robot: touchcal.Robot, log: touchcal.ContactLog) -> None:
    sockets = [Fixture("a/0", Manifold.ball_in_socket(), free=True)]
    usual = {"robot": robot, "tool": Tool(exact=True), "fixtures": sockets, "contacts": {"a/0": log}, "parameters": ["strain"]}
    problem = Problem(**usual)  # type: ignore[arg-type]

    def refused(words: str, make) -> None:
        with pytest.raises(TypeError) as refusal:
            make()
        assert str(refusal.value) == words

    distances = "a list of (name, name, metres) or (name, name, metres, sigma)"
    logs = "a ContactLog (ContactLog.from_numpy makes one of an array) or a list of them"
    for argument, value, words in [
        ("robot", "iiwa14", "expected a Robot, such as Robot.from_urdf(\"iiwa14\"), found str 'iiwa14'"),
        ("tool", (0, 0, 0.1), "expected a Tool, found tuple (0, 0, 0.1)"),
        ("contacts", {"a/0": problem.q[:1]}, f"expected {logs}, found list in it"),
        ("parameters", "strain", "expected a list of names, found str 'strain'"),
        ("parameters", ["strain", 1], "expected a list of names, found int 1 in it"),
        ("parameters", {"strain": True}, "expected a list of names, found dict {'strain': True}"),
        ("fixtures", ["a/0"], "expected a list of Fixture, found str 'a/0' in it"),
        ("contacts", {"a/0": "log.csv"}, f"expected {logs}, found str 'log.csv'"),
        ("contacts", {"a/0": [log, "log.csv"]}, f"expected {logs}, found str 'log.csv' in it"),
        ("held_out", {"a/0": None}, f"expected {logs}, found NoneType None"),
        ("distances", [("a/0", "a/1")], f"expected {distances}, found tuple ('a/0', 'a/1') in it"),
        ("distances", "a/0", f"expected {distances}, found str 'a/0'"),
        ("noise", 1, "expected a mapping, found int 1"),
        ("contacts", [log], "expected a mapping, found list [ContactLog(30 contacts of 30 rows, \"array\")]"),
    ]:
        refused(f"argument '{argument}': {words}", lambda argument=argument, value=value: Problem(**{**usual, argument: value}))
    simulated = touchcal.simulate("paper", 1, contacts=3).problem()
    refused("argument 'parameters': expected a list of names, found str 'strain'", lambda: simulated.with_(parameters="strain"))
    refused("argument 'noise': expected a mapping, found int 1", lambda: simulated.with_(noise=1))
    refused("argument 'tool': expected a Tool, found str 'peg'", lambda: simulated.with_(tool="peg"))
    refused("argument 'exact': expected True, False, or a list of names, found str 'depth'", lambda: Fixture("h", hole(), touchcal.pose(), exact="depth"))  # type: ignore[arg-type]
    refused("argument 'earlier': expected a Calibration or a SavedCalibration, found str 'out'", lambda: touchcal.compare("out", "out"))  # type: ignore[arg-type]
    refused("argument 'calibration': expected a Calibration or a SavedCalibration, found str 'out'", lambda: touchcal.evaluate(problem, "out"))  # type: ignore[arg-type]
    refused("argument 'joints': expected a list of names, found str 'a1'", lambda: touchcal.ContactLog.from_numpy(robot, problem.q, joints="a1"))
    for function in (touchcal.calibrate, touchcal.inspect, touchcal.evaluate, touchcal.select):
        refused("argument 'problem': expected a Problem, such as Problem.from_toml(\"problem.toml\"), found str 'p.toml'", lambda function=function: function("p.toml"))
    refused("argument 'manifold': expected a Manifold, such as Manifold.ball_in_socket(), found str 'a'", lambda: Fixture("a", "a"))  # type: ignore[arg-type]
    # Other iterables are lists.
    assert len(Problem(**{**usual, "parameters": ("strain",), "fixtures": iter(sockets)})) == 30  # type: ignore[arg-type]


def test_messages_on_unknown_names_have_the_nearest(robot: touchcal.Robot, log: touchcal.ContactLog) -> None:
    simulation = touchcal.simulate("workcell", 1, contacts=20)
    found = "expected the name of a fixture .hole., found \"hle\"; did you mean `hole`\\?$"
    with pytest.raises(touchcal.InputError, match=f"contact_poses: {found}"):
        simulation.problem().contact_poses("hle")
    with pytest.raises(touchcal.InputError, match=f"simulation: {found}"):
        simulation.log("hle")
    sockets = [Fixture("a/0", Manifold.ball_in_socket(), free=True)]
    with pytest.raises(touchcal.InputError, match="contacts: .*, found \"a/O\"; did you mean `a/0`"):
        Problem(robot, Tool(exact=True), sockets, {"a/O": log}, parameters=["strain"])


def test_millimetres_and_degrees_are_questioned(robot: touchcal.Robot, log: touchcal.ContactLog, tmp_path: Path) -> None:
    metres, ball, peg = r".*\(lengths are metres\), found ", Manifold.ball_in_socket(), touchcal.extrusion25()

    def questioned(words: str, make) -> None:
        with pytest.raises(touchcal.InputError, match=f"^{words}"):
            make()

    questioned(f"tool, sigma: expected at most 0.5 m{metres}1 m$", lambda: Tool(sigma=1))
    questioned(r"tool, sigma_angle: expected at most 3.142 rad \(angles are radians\), found 5 rad$", lambda: Tool(sigma_angle=5))
    questioned(f"fixture `a`, sigma: expected at most 0.5 m{metres}2", lambda: Fixture("a", ball, sigma=2))
    for part in ("clearance_sigma", "depth_sigma", "edge_radius_sigma"):
        questioned(f"fixture `h`, {part}: expected at most 0.01 m{metres}0.02 m", lambda part=part: Fixture("h", hole(), touchcal.pose(), **{part: 0.02}))
    questioned(r"rpy: expected at most 12.566 rad \(angles are radians\), found -90 rad", lambda: touchcal.pose(rpy=(0, 0, -90)))
    questioned(f"plane, radius: expected at most 2 m{metres}5 m", lambda: Manifold.plane(radius=5))
    questioned(f"plane, points: expected at most 2 m{metres}12", lambda: Manifold.plane([(0, 0, 12)]))
    wide = touchcal.offset_outline(peg, 0.0005)
    questioned(f"length: expected at most 2 m{metres}40", lambda: Manifold.peg_in_hole(peg, wide, length=40, depth=30))
    questioned(f"peg: expected at most 2 m{metres}17", lambda: Manifold.peg_in_hole(1e3 * peg, 1e3 * wide, length=0.04, depth=0.03))
    questioned(f"depth: expected at most 2 m{metres}30", lambda: Manifold.meshes(tmp_path / "a.stl", tmp_path / "b.stl", depth=30))
    questioned(f"samples: expected at most 10 m{metres}25 m", lambda: Manifold.nearest([touchcal.pose((0, 0, z)) for z in (20, 25)]))
    questioned(f"metres_per_radian: expected at most 10 m{metres}57 m", lambda: Manifold.nearest([touchcal.pose(), touchcal.pose((0, 0, 1))], metres_per_radian=57))
    questioned(f"spacing: expected at most 2 m{metres}50 m", lambda: Problem.from_mukca(tmp_path, robot, spacing=50))
    sockets = [Fixture(f"a/{k}", ball, free=True) for k in (0, 1)]
    problem = lambda **distance: Problem(robot, Tool(exact=True), sockets, {"a/0": log}, parameters=["strain"], **distance)
    questioned(f"distances: expected at most 10 m{metres}50 m", lambda: problem(distances=[("a/0", "a/1", 50)]))
    questioned(f"distances, sigma: expected at most 0.5 m{metres}1 m", lambda: problem(distances=[("a/0", "a/1", 0.05, 1)]))
    questioned("gravity: expected at most 100 m/s², found 9810 m/s²", lambda: touchcal.Robot.from_urdf("iiwa14", gravity=(0, 0, -9810)))
    # What is large, but may be meant.
    assert Tool(sigma=0.5, sigma_angle=3) and Manifold.plane(radius=2) and touchcal.pose(rpy=(0, 0, -6.3)) is not None
    assert np.ptp(touchcal.offset_outline([(0, 0), (0.01, 0), (0.01, 0.01)], 0.02)[:, 0]) > 0.05


def hole() -> Manifold:
    peg = touchcal.extrusion25()
    return Manifold.peg_in_hole(peg, touchcal.offset_outline(peg, 0.0005), length=0.04, depth=0.03)


def test_what_is_assumed_is_warned_of_and_estimated(robot: touchcal.Robot, log: touchcal.ContactLog) -> None:
    place = touchcal.pose((0.6, 0.1, 0.15))

    def problem(tool: Tool, fixtures: list[Fixture], **arguments: object) -> Problem:
        contacts = {
            fixture.name: touchcal.ContactLog.from_numpy(robot, log.q + 0.01 * k) for k, fixture in enumerate(fixtures)
        }
        return Problem(robot, tool, fixtures, contacts, parameters=["joint_offset"], **arguments)  # type: ignore[arg-type]

    words = r"tool: place ± 0.3 mm, 0.2°; fixture `h`: place ± 1 mm, 0.5°; fixture `h`: clearance ± 0.03 mm; fixture `h`: depth ± 0.03 mm; fixture `h`: edge radius ± 0.05 mm; declare"
    with pytest.warns(UserWarning, match=words):
        assumed = problem(Tool(), [Fixture("h", hole(), place)])
    assert len(assumed.notes) == 1
    priors = {entry.name: entry.prior_sigma for entry in touchcal.inspect(assumed).parameters}
    assert priors["tool.x"] == 0.3e-3 and priors["fixture.h.x"] == 1e-3
    assert priors["fixture.h.rx"] == pytest.approx(np.radians(0.5), rel=1e-12)
    with pytest.warns(UserWarning, match=r"tool: place ± 2 mm, 0.2°; declare"):
        problem(Tool(sigma=2e-3), [Fixture("h", hole(), place, exact=True)])
    # A ball has no orientation.
    ball = [Fixture(name, Manifold.ball_in_socket(), place, sigma=1e-3) for name in ("a", "b")]
    with pytest.warns(UserWarning, match="^assumed, since no standard deviations are declared: distance a–b: ± 0.1 mm; declare"):
        problem(Tool(sigma=2e-3), ball, distances=[("a", "b", 0.05)])
    with pytest.warns(UserWarning, match="^standard deviations of 0 are taken as exact: tool$"):
        problem(Tool(sigma=0, sigma_angle=0), ball)
    exact = problem(Tool(exact=True), [Fixture("h", hole(), place, exact=["place"], clearance_sigma=1e-5, depth_sigma=1e-4, edge_radius_sigma=1e-5)])
    assert not exact.notes
    assert not any(entry.name.startswith(("tool.", "fixture.")) for entry in touchcal.inspect(exact).parameters)


def test_settings_mean_what_a_file_means(robot: touchcal.Robot, log: touchcal.ContactLog) -> None:
    fixture = Fixture("s", Manifold.ball_in_socket(), free=True)
    other = touchcal.ContactLog.from_numpy(robot, log.q + 0.01)
    problem = Problem(
        robot,
        Tool(free=True),
        [fixture],
        {"s": [log, other]},
        parameters=["joint_offset", "joint_origin"],
        estimate={"freeze": ["joint_origin.joint_a1"], "prior": {"joint_origin_mm": 0.25}},
    )
    assert len(problem) == 60 and problem.fixtures == ["s"]
    expected = {entry.name: entry for entry in touchcal.inspect(problem).parameters}
    assert "joint_origin.joint_a2.x" in expected and "joint_origin.joint_a1.x" not in expected
    assert expected["joint_origin.joint_a2.x"].prior_sigma == 0.25e-3
    assert {"tool.x", "fixture.s.x"} <= set(expected)


def test_a_ball_is_as_far_as_its_centre() -> None:
    poses = np.array([touchcal.pose((0.003, 0.004, 0)), touchcal.pose((0, 0, -0.002), rpy=(1, 2, 3))])
    assert Manifold.ball_in_socket().distance(poses) == pytest.approx([0.005, 0.002], abs=1e-15)
    assert Manifold.plane(radius=0.001).distance(poses) == pytest.approx([0.001, 0.003], abs=1e-15)
    corners = [[0.01, 0, 0], [-0.01, 0, 0]]
    tilted = [touchcal.pose((0, 0, 0.02), rpy=(0, 0.1, 0))]
    assert Manifold.plane(corners).distance(tilted) == pytest.approx([0.02 - 0.01 * np.sin(0.1)], abs=1e-15)


def test_a_peg_in_the_middle_of_its_hole_is_the_clearance_away() -> None:
    square = np.array([[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]])
    hole = touchcal.offset_outline(square, 0.0005)
    assert sorted(map(tuple, np.round(hole, 12))) == sorted(map(tuple, np.round(square * 1.05, 12)))
    manifold = Manifold.peg_in_hole(square, hole, length=0.04, depth=0.03)
    seated = [touchcal.pose((0.0002 * k, 0, -0.02)) for k in range(3)]
    assert manifold.distance(seated) == pytest.approx([0.0005, 0.0003, 0.0001], abs=1e-12)
    assert touchcal.extrusion25().shape[1] == 2
    for outline in (square[:2], square[:, :1], np.full((4, 2), np.nan)):
        with pytest.raises(touchcal.InputError, match="^peg: "):
            Manifold.peg_in_hole(outline, hole, length=0.04, depth=0.03)
    with pytest.raises(touchcal.InputError, match=r"a hole that the peg fits into.*an overlap of 0\.5 mm"):
        Manifold.peg_in_hole(hole, square, length=0.04, depth=0.03)
    with pytest.raises(touchcal.InputError, match="^outline: "):
        touchcal.offset_outline(square, -0.5)


def test_a_round_edge_of_a_tilted_peg_is_farther_from_the_floor() -> None:
    square = np.array([[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]])
    tilted = [touchcal.pose((0, 0, -0.028), rpy=(0, 0.1, 0))]

    def distance(of_peg: float, of_hole: float) -> float:
        wide = touchcal.offset_outline(square, 0.005)
        hole = Manifold.peg_in_hole(
            square, wide, length=0.04, depth=0.03, peg_edge_radius=of_peg, hole_edge_radius=of_hole
        )
        return hole.distance(tilted)[0]

    rounding = 0.0002 * (np.sin(0.1) + np.cos(0.1) - 1)
    assert distance(0.0002, 0) == pytest.approx(0.002 - 0.01 * np.sin(0.1) + rounding, abs=1e-12)
    assert distance(0, 0.0002) == pytest.approx(0.002 - 0.01 * np.sin(0.1), abs=1e-12)
    with pytest.raises(touchcal.InputError, match="edge radius of the peg"):
        distance(0.02, 0)


def obj(path: Path, corners: list[tuple[float, float, float]], faces: list[tuple[int, ...]]) -> Path:
    """A mesh (mm) whose faces name corners from 0, counter-clockwise seen from outside."""
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
    path.write_text(vertices + "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in faces))
    return path


def square(half: float, z: float) -> list[tuple[float, float, float]]:
    return [(x, y, z) for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))]


def bar(path: Path) -> Path:
    """A square bar of 20 mm, 40 mm long."""
    sides = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    return obj(path, square(10, 0) + square(10, 40), [(3, 2, 1, 0), (4, 5, 6, 7), *sides])


def block(path: Path) -> Path:
    """A block of 40 mm, 30 mm high, with a hole for the bar, 0.5 mm wider on each side."""
    corners = square(20, -30) + square(10.5, -30) + square(20, 0) + square(10.5, 0)
    faces = []
    for i in range(4):
        k = (i + 1) % 4
        outside, inside = (i, k, k + 8, i + 8), (k + 4, i + 4, i + 12, k + 12)
        top, bottom = (i + 8, k + 8, k + 12, i + 12), (k, i, i + 4, k + 4)
        faces += [outside, inside, top, bottom]
    return obj(path, corners, faces)


def test_drawings_and_meshes_are_read(tmp_path: Path) -> None:
    drawing = tmp_path / "peg.svg"
    drawing.write_text("<svg><rect id='peg' x='-10' y='-10' width='20' height='20'/><circle r='3'/></svg>")
    outline = touchcal.read_outline(drawing, name="peg", unit=0.001)
    assert sorted(map(tuple, np.round(outline, 12))) == [(-0.01, -0.01), (-0.01, 0.01), (0.01, -0.01), (0.01, 0.01)]
    with pytest.raises(touchcal.InputError, match="states its unit, or `unit`, found neither"):
        touchcal.read_outline(drawing, name="peg")
    drawing.write_text(drawing.read_text().replace("<svg>", "<svg width='30mm' viewBox='0 0 30 30'>"))
    with pytest.raises(touchcal.InputError, match="one closed outline; `name` says which"):
        touchcal.read_outline(drawing)
    with pytest.raises(touchcal.InputError, match="the unit that `unit` declares, 25.4 mm"):
        touchcal.read_outline(drawing, name="peg", unit=0.0254)
    drawing.write_text(drawing.read_text().replace(" width='30mm' viewBox='0 0 30 30'", ""))
    peg, hole = bar(tmp_path / "peg.obj"), block(tmp_path / "block.obj")
    poses = [touchcal.pose((0.002, 0, 0.001)), touchcal.pose((0.0003, 0, -0.01))]
    assert Manifold.meshes(peg, hole, depth=0.03).distance(poses) == pytest.approx([0.001, 0.0002], abs=1e-12)
    with pytest.raises(touchcal.InputError, match=r"a hole that the peg fits into.*where the peg's axis lies"):
        Manifold.meshes(peg, bar(tmp_path / "bar.obj"), depth=0.03)
    for unit in (0.0, -0.001, float("nan")):
        with pytest.raises(touchcal.InputError, match="positive length"):
            Manifold.meshes(peg, hole, depth=0.03, unit=unit)
        with pytest.raises(touchcal.InputError, match="positive length"):
            touchcal.read_outline(drawing, name="peg", unit=unit)
    (tmp_path / "open.obj").write_text(peg.read_text().replace("f 4 3 2 1\n", ""))
    with pytest.raises(touchcal.InputError, match="closed surface.* mm has 1"):
        Manifold.meshes(tmp_path / "open.obj", hole, depth=0.03)


def test_projection_finds_the_nearest_sample() -> None:
    rng = np.random.default_rng(2)
    places, angles = rng.uniform(-0.01, 0.01, (200, 3)), rng.uniform(-0.2, 0.2, (200, 3))
    samples = np.array([touchcal.pose(x, rpy=rpy) for x, rpy in zip(places, angles, strict=True)])
    manifold = Manifold.nearest(samples)
    at, turned = rng.uniform(-0.02, 0.02, (50, 3)), rng.uniform(-0.3, 0.3, (50, 3))
    poses = np.array([touchcal.pose(x, rpy=rpy) for x, rpy in zip(at, turned, strict=True)])
    # A millimetre counts as much as a degree.
    length = 1e-3 / np.radians(1)
    far = np.linalg.norm(at[:, None] - places, axis=2) ** 2 + (length * np.linalg.norm(turned[:, None] - angles, axis=2)) ** 2
    assert np.allclose(touchcal.project(manifold, poses), samples[far.argmin(axis=1)], atol=1e-14)
    assert manifold.distance(poses) == pytest.approx(np.sqrt(far.min(axis=1)), rel=1e-9)
    assert np.allclose(manifold.project(samples), samples, atol=1e-14)
    with pytest.raises(touchcal.InputError, match="project: expected a manifold made by `nearest` or `learned`"):
        touchcal.project(Manifold.ball_in_socket(), poses)


def test_recorded_poses_are_a_manifold(workcell: Path) -> None:
    problem = Problem.from_toml(workcell / "problem.toml")
    poses = problem.contact_poses("hole")
    assert poses.shape == (len(problem), 7)
    assert Manifold.nearest(poses).distance(poses) == pytest.approx(np.zeros(len(poses)), abs=1e-12)
    # The exact shape of the same contacts: a nominal arm is off.
    peg = touchcal.extrusion25()
    exact = Manifold.peg_in_hole(peg, touchcal.offset_outline(peg, 0.5e-3), length=0.04, depth=0.03)
    assert np.sqrt(np.mean(exact.distance(poses) ** 2)) == pytest.approx(touchcal.evaluate(problem).all.rms, rel=1e-9)
    with pytest.raises(touchcal.InputError, match="expected the name of a fixture"):
        problem.contact_poses("hull")


def test_everything_public_is_documented() -> None:
    for name in touchcal.__all__:
        thing = getattr(touchcal, name)
        assert name == "__version__" or thing.__doc__, name
        if isinstance(thing, type):
            members = [member for member in vars(thing) if not member.startswith("_")]
            attributes = thing.__doc__ or ""
            for member in members:
                assert getattr(thing, member).__doc__ or f"{member}" in attributes, f"{name}.{member}"


def test_rows_that_are_there_twice_count_once(robot: touchcal.Robot, log: touchcal.ContactLog) -> None:
    sockets = [Fixture(f"a/{k}", Manifold.ball_in_socket(), free=True) for k in range(2)]

    def problem(**arguments: object) -> Problem:
        return Problem(robot, Tool(exact=True), sockets, parameters=["joint_offset"], **arguments)  # type: ignore[arg-type]

    words = "array: 30 of 30 contacts are rows that were read before, in this log or another, and are counted once"
    with pytest.warns(UserWarning, match=words):
        twice = problem(contacts={"a/0": [log, log]})
    assert np.array_equal(twice.q, log.q) and words in twice.notes[0]
    with pytest.warns(UserWarning, match=words):
        assert len(problem(contacts={"a/0": log, "a/1": log}).q) == 30
    with pytest.warns(UserWarning, match=words):
        both = problem(contacts={"a/0": log}, held_out={"a/1": log})
    assert touchcal.calibrate(both).held_out is None
    # The same numbers as other joints, and with other digits: rows of their own.
    joints = [f"joint_a{k}" for k in range(7, 0, -1)]
    other = touchcal.ContactLog.from_numpy(robot, log.q, joints=joints)
    assert len(problem(contacts={"a/0": [log, other]}).q) == 60
    copy = touchcal.ContactLog.from_numpy(robot, log.q + 1e-9)
    with pytest.warns(UserWarning, match="30 of 60 contacts have, one after another, the joint positions of earlier"):
        assert len(problem(contacts={"a/0": [log, copy]}).q) == 60
