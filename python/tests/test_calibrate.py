"""Calibrations: what is found, what is built in code, and how one is watched and ended."""

import json
import os
import signal
import threading
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import touchcal


@pytest.fixture(scope="module")
def long_one() -> touchcal.Problem:
    """A problem whose solve takes seconds: twenty copies of a log, each 1e-5 rad off the one before."""
    robot = touchcal.Robot.from_urdf("iiwa14")
    log = touchcal.simulate("paper", 1, contacts=3000).log("hole")
    peg = touchcal.extrusion25()
    hole = touchcal.Manifold.peg_in_hole(peg, touchcal.offset_outline(peg, 0.5e-3), length=0.04, depth=0.03)
    place = touchcal.pose((0.6, 0.1, 0.15), quat_wxyz=(0.984807753012, 0, 0, 0.173648177667))
    copies = [touchcal.ContactLog.from_numpy(robot, log["q"] + 1e-5 * k, contact=log["contact"]) for k in range(20)]
    return touchcal.Problem(
        robot,
        touchcal.Tool(touchcal.pose((0, 0, 0.15), quat_wxyz=(0, 0, 1, 0)), exact=True),
        [touchcal.Fixture("hole", hole, place, exact=True)],
        {"hole": copies},
        parameters=["strain", "joint_offset"],
    )


def test_the_same_arm_is_recorded_once_more() -> None:
    once, again = (touchcal.simulate("paper", 1, contacts=20, noise_seed=seed) for seed in (1, 2))
    assert once.noise_seed == once.seed == again.seed == 1 and again.noise_seed == 2
    assert once.truth["parameters"] == again.truth["parameters"]
    assert np.array_equal(once.log("hole")["q"], touchcal.simulate("paper", 1, contacts=20).log("hole")["q"])
    assert not np.array_equal(once.log("hole")["q"], again.log("hole")["q"])


def test_finds_the_truth(workcell: Path) -> None:
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))
    truth = json.loads((workcell / "truth.json").read_text())["parameters"]
    assert calibration.usable and calibration.status == "usable"
    offsets = [p for p in calibration.parameters if p.block == "joint_offset"]
    assert len(offsets) == 7
    deviations = [(p.value - truth[p.name]) / p.sigma for p in offsets if p.sigma and p.identifiable]
    assert len(deviations) >= 6
    # Each is within four standard deviations, and they are of the size that the intervals say.
    assert max(map(abs, deviations)) < 4
    assert np.sqrt(np.mean(np.square(deviations))) < 2
    assert calibration.postfit.all.rms < 0.1 * calibration.prefit.all.rms


TASK = """
[accept]
tolerance_mm = 0.5
joints_deg = [[-20, 20], [20, 60], [-10, 10], [-110, -70], [-10, 10], [30, 70], [-90, 90]]
"""


HELD_OUT = """
[[contacts]]
file = "again.csv"
fixture = "hole"
force_threshold_n = 3
held_out = true
"""


def test_a_problem_in_code_has_the_bits_of_its_file(workcell: Path) -> None:
    # The same contacts, as rows of their own: rows that are read twice would not be held out.
    rows = (workcell / "hole.csv").read_text().splitlines()
    (workcell / "again.csv").write_text("".join(f"{row},again\n" for row in rows))
    accepted = workcell / "accepted.toml"
    accepted.write_text((workcell / "problem.toml").read_text() + HELD_OUT + TASK)
    repeated = "1500 of 3000 contacts have, one after another, the joint positions"
    with pytest.warns(UserWarning, match=repeated):
        from_file = touchcal.calibrate(touchcal.Problem.from_toml(accepted))
    robot = touchcal.Robot.from_urdf("iiwa14", base="base_link", tip="flange")
    peg = touchcal.extrusion25()
    hole = touchcal.Manifold.peg_in_hole(
        peg, touchcal.offset_outline(peg, 0.5 * 1e-3), length=40 * 1e-3, depth=30 * 1e-3
    )
    mm, deg = 1e-3, np.pi / 180
    lag = tomllib.loads((workcell / "problem.toml").read_text())["log"]["load_lag_rows"]
    log = touchcal.ContactLog.from_file(
        robot, workcell / "hole.csv", force_threshold=3, load_on="tool", load_lag=lag
    )
    again = touchcal.ContactLog.from_file(robot, workcell / "again.csv", force_threshold=3)
    with pytest.warns(UserWarning, match=repeated):
        problem = touchcal.Problem(
            robot,
            touchcal.Tool(
                touchcal.pose((0, 0, 150 * mm), quat_wxyz=(0, 0, 1, 0)), sigma=0.05 * mm, sigma_angle=0.02 * deg
            ),
            [
                touchcal.Fixture(
                    "hole",
                    hole,
                    touchcal.pose(
                        (600 * mm, 100 * mm, 150 * mm), quat_wxyz=(0.984807753012, 0, 0, 0.173648177667)
                    ),
                    sigma=1 * mm,
                    sigma_angle=0.2 * deg,
                    clearance_sigma=0.02 * mm,
                    depth_sigma=0.02 * mm,
                    edge_radius_sigma=0.05 * mm,
                )
            ],
            {"hole": log},
            parameters=["joint_offset"],
            noise={"encoder_deg": 0.002, "contact_mm": 0.01, "encoder_trend_deg": 0},
            estimate={"loss": "geman_mcclure", "loss_scale": 3, "unseen_effects": "ignore"},
            accept=tomllib.loads(TASK)["accept"],
            held_out={"hole": again},
        )
    in_code = touchcal.calibrate(problem)
    assert in_code.parameters == from_file.parameters
    assert in_code.held_out is not None and from_file.held_out is not None
    assert in_code.held_out.scatter == from_file.held_out.scatter is not None
    assert in_code.held_out.scatter == touchcal.evaluate(problem, in_code).scatter
    assert in_code.acceptance is not None and from_file.acceptance is not None
    assert in_code.acceptance.message == from_file.acceptance.message
    assert in_code.acceptance.probability == from_file.acceptance.probability
    assert in_code.effect_tests == from_file.effect_tests
    assert np.array_equal(in_code.covariance, from_file.covariance)
    assert in_code.calibrated_urdf() == from_file.calibrated_urdf()
    assert [sha for _, sha in problem.inputs] == [
        entry["sha256"] for entry in json.loads(from_file.to_json())["inputs"][1:]
    ]


def test_sockets_in_code_have_the_bits_of_their_file(sockets: Path) -> None:
    from_file = touchcal.calibrate(touchcal.Problem.from_toml(sockets / "problem.toml"))
    robot = touchcal.Robot.from_urdf("iiwa14")
    names = [f"{placement}/{number}" for placement in ("front", "left", "right") for number in (0, 1)]
    logs = {
        name: [touchcal.ContactLog.from_file(robot, sockets / f"{name.replace('/', '_')}.csv", force_threshold=3)]
        for name in names
    }
    problem = touchcal.Problem(
        robot,
        touchcal.Tool(touchcal.pose((0, 0, 150e-3), quat_wxyz=(0, 0, 1, 0)), sigma=2e-3),
        [touchcal.Fixture(name, touchcal.Manifold.ball_in_socket(), free=True) for name in names],
        logs,
        distances=[(names[k], names[k + 1], 50 * 1e-3, 0.01 * 1e-3) for k in (0, 2, 4)],
        parameters=["joint_origin"],
        noise=settings(sockets, "noise"),
        estimate=settings(sockets, "estimate"),
    )
    assert touchcal.calibrate(problem).parameters == from_file.parameters


def settings(folder: Path, table: str) -> dict[str, object]:
    """A table of problem.toml, but for `parameters`."""
    read = tomllib.loads((folder / "problem.toml").read_text())[table]
    return {key: value for key, value in read.items() if key != "parameters"}


def test_a_calibrated_arm_is_the_one_that_is_written(workcell: Path, tmp_path: Path) -> None:
    problem = touchcal.Problem.from_toml(workcell / "problem.toml")
    calibration = touchcal.calibrate(problem)
    urdf, _, _ = calibration.save(tmp_path)
    again = touchcal.Robot.from_urdf(urdf, base="base_link", tip="flange")
    q = problem.q[:50]
    assert np.array_equal(calibration.robot.base_from_tip(q), again.base_from_tip(q))
    assert not np.allclose(calibration.robot.base_from_tip(q), problem.robot.base_from_tip(q), atol=1e-4)


def test_held_out_contacts_are_scored_with_what_was_found(workcell: Path) -> None:
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))
    other = touchcal.simulate(workcell / "scenario.toml", 3, contacts=1500).problem()
    assert touchcal.evaluate(other, calibration).all.rms < 0.05e-3 < touchcal.evaluate(other).all.rms
    assert set(calibration.base_from_fixture) == {"hole"}
    truth = json.loads((workcell / "truth.json").read_text())["parameters"]
    moved = calibration.base_from_fixture["hole"][:3] - np.array([0.6, 0.1, 0.15])
    assert np.linalg.norm(moved) == pytest.approx(
        np.linalg.norm([truth[f"fixture.hole.{axis}"] for axis in "xyz"]), abs=2e-3
    )


def test_too_few_contacts_are_a_status_and_no_exception() -> None:
    calibration = touchcal.calibrate(touchcal.simulate("paper", 1, contacts=3).problem())
    assert not calibration.usable
    assert calibration.status == "not_usable"
    assert {"too_few_contacts"} <= {warning.kind for warning in calibration.warnings}
    assert all(warning.message and warning.advice for warning in calibration.warnings)
    assert calibration.null_space and calibration.null_space[0].description


def test_minima_that_contacts_do_not_rule_out_are_listed() -> None:
    calibration = touchcal.calibrate(touchcal.simulate("paper", 5, contacts=150).problem())
    minima = calibration.competing_minima
    assert not calibration.usable and len(minima) > 1
    assert "competing_minimum" in {warning.kind for warning in calibration.warnings}
    assert [other.cost_ratio for other in minima] == sorted(other.cost_ratio for other in minima)
    here = {parameter.name: parameter.value for parameter in calibration.parameters}
    for other in minima:
        assert other.tool_distance > 0 and other.parameter in here and set(other.values) == set(here)
        assert abs(other.values[other.parameter] - here[other.parameter]) > 1e-4
    written = json.loads(calibration.to_json())["competing_minima"]
    assert [entry["values"] for entry in written] == [list(other.values[name] for name in here) for other in minima]


def test_progress_is_told_at_every_step(workcell: Path) -> None:
    seen: list[touchcal.Progress] = []
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"), progress=seen.append)
    assert seen == calibration.steps
    assert {progress.stage for progress in seen} == {"coarse", "fine"}


def test_what_a_callback_raises_ends_the_work(long_one: touchcal.Problem) -> None:
    calls = 0

    def tired(_: touchcal.Progress) -> None:
        nonlocal calls
        calls += 1
        if calls == 2:
            raise LookupError("tired")

    with pytest.raises(LookupError, match="tired"):
        touchcal.calibrate(long_one, tired)
    assert calls == 2


def test_a_tolerance_is_passed_or_failed(tmp_path: Path) -> None:
    touchcal.simulate("paper", 3, contacts=1500).save(tmp_path)
    problem = tmp_path / "problem.toml"
    text = problem.read_text()
    assert touchcal.calibrate(touchcal.Problem.from_toml(problem)).acceptance is None
    for tolerance_mm, decision in [(1, "pass"), (0.0001, "fail")]:
        problem.write_text(text + TASK.replace("0.5", str(tolerance_mm)))
        found = touchcal.calibrate(touchcal.Problem.from_toml(problem)).acceptance
        assert found is not None and found.decision == decision and found.probability is not None
        assert (found.probability >= 0.95) == (decision == "pass")
        assert found.message.startswith(decision.upper()) and repr(found) == f'Acceptance("{found.message}")'


@pytest.mark.parametrize("work", ["calibrate", "simulate"])
def test_ctrl_c(work: str, long_one: touchcal.Problem) -> None:
    begin = time.monotonic()
    threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        if work == "calibrate":
            touchcal.calibrate(long_one)
        else:
            touchcal.simulate("paper", 1, contacts=500_000)
    assert 0.2 < time.monotonic() - begin < 3


def test_others_run_during_a_solve(long_one: touchcal.Problem) -> None:
    done = threading.Event()
    begin = time.monotonic()
    ticks = calls = 0

    class Enough(Exception):
        pass

    def tick() -> None:
        nonlocal ticks
        while not done.wait(0.01):
            ticks += 1

    def stop(_: touchcal.Progress) -> None:
        nonlocal calls
        calls += 1
        if time.monotonic() - begin > 1.5:
            raise Enough

    other = threading.Thread(target=tick)
    other.start()
    with pytest.raises(Enough):
        touchcal.calibrate(long_one, stop)
    elapsed = time.monotonic() - begin
    done.set()
    other.join()
    # If the interpreter were kept, the other would tick at the calls at most.
    assert ticks > 20 * elapsed
    assert ticks > 2 * calls


def test_threads_give_the_bits_of_a_loop() -> None:
    problems = [touchcal.simulate("workcell", seed, contacts=200).problem() for seed in (1, 2, 3, 4)]
    with ThreadPoolExecutor(2) as pool:
        side_by_side = list(pool.map(touchcal.calibrate, problems))
    for problem, result in zip(problems, side_by_side, strict=True):
        alone = touchcal.calibrate(problem)
        assert result.parameters == alone.parameters
        assert np.array_equal(result.covariance, alone.covariance)


def test_a_bar_counts_steps(workcell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with touchcal.bar(mininterval=0) as progress:
        calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"), progress)
    told = capsys.readouterr().err
    assert f"{len(calibration.steps)} steps" in told and "fine, cost" in told


def test_frames(workcell: Path) -> None:
    problem = touchcal.Problem.from_toml(workcell / "problem.toml")
    calibration = touchcal.calibrate(problem)
    frame = calibration.to_pandas().set_index("name")
    assert frame.loc["joint_offset.joint_a3", "value"] == calibration["joint_offset.joint_a3"].value
    assert frame["sigma"].notna().sum() == sum(p.sigma is not None for p in calibration.parameters)
    contacts = calibration.contacts_to_pandas()
    assert len(contacts) == len(problem) and set(contacts["fixture"]) == {"hole"}
    assert np.sqrt(np.mean(contacts["after"] ** 2)) == pytest.approx(calibration.postfit.all.rms, rel=1e-12)
    assert np.sqrt(np.mean(contacts["before"] ** 2)) == pytest.approx(calibration.prefit.all.rms, rel=1e-12)
    assert contacts["line"].is_monotonic_increasing
    scores = calibration.postfit.to_pandas()
    assert scores["contacts"].tolist() == [len(problem)]
    assert len(touchcal.inspect(problem).to_pandas()) == len(frame)


def test_results_cannot_be_changed(workcell: Path) -> None:
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))
    with pytest.raises(AttributeError):
        calibration.parameters[0].value = 1.0  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        calibration.covariance[0, 0] = 1.0
    expected = r"expected the name of a parameter \(`joint_offset\.joint_a1`, .*, found \"joint_offset\.joint_a9\"; did you mean `joint_offset\.joint_a\d`\?"
    with pytest.raises(KeyError, match=expected):
        calibration["joint_offset.joint_a9"]


def test_the_covariance_is_that_of_the_sigmas(workcell: Path) -> None:
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))
    spread = np.sqrt(np.diag(calibration.covariance))
    for parameter, sigma in zip(calibration.parameters, spread, strict=True):
        if parameter.sigma is not None:
            assert sigma == pytest.approx(parameter.sigma, rel=1e-12)


def test_a_wrench_that_is_a_load_has_a_bias(tmp_path: Path) -> None:
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(
        'preset = "paper"\ncontacts = 300\n[robot]\nbuiltin = "iiwa14"\ngravity = [0, 0, 0]\n'
        "[errors]\njoint_compliance_rad_per_nm = 1e-4\n"
        "[recorder]\nforce_bias_n = 0.5\ntorque_bias_nm = 0.05\nwrench_scale = 0.02\n"
    )
    simulation = touchcal.simulate(scenario, 3)
    simulation.save(tmp_path / "sim")
    names = [f"wrench_bias.{part}" for part in ("fx", "fy", "fz", "tx", "ty", "tz")] + ["wrench_scale"]
    assert all(simulation.truth["parameters"][name] != 0 for name in names)
    robot = touchcal.Robot.from_urdf("iiwa14", gravity=(0, 0, 0))
    peg = touchcal.extrusion25()
    hole = touchcal.Manifold.peg_in_hole(peg, touchcal.offset_outline(peg, 0.5e-3), length=0.04, depth=0.03)
    place = touchcal.pose((0.6, 0.1, 0.15), quat_wxyz=(0.984807753012, 0, 0, 0.173648177667))

    def problem(**noise: float) -> touchcal.Problem:
        return touchcal.Problem(
            robot,
            touchcal.Tool(touchcal.pose((0, 0, 0.15), quat_wxyz=(0, 0, 1, 0)), exact=True),
            [touchcal.Fixture("hole", hole, place, exact=True)],
            {
                "hole": touchcal.ContactLog.from_file(
                    robot, tmp_path / "sim/hole.csv", force_threshold=3, load_on="tool"
                )
            },
            parameters=["strain", "joint_offset", "joint_compliance"],
            noise={"encoder_deg": 0.002, "contact_mm": 0.005, "encoder_trend_deg": 0, **noise},
        )

    with pytest.warns(UserWarning, match="wrench: scale ± 2 %; declare them .force_bias_n, torque_bias_nm"):
        assumed = problem(force_bias_n=1, torque_bias_nm=0.1)
    found = {p.name: p for p in touchcal.calibrate(assumed).parameters}
    assert [found[name].prior_sigma for name in names] == [1, 1, 1, 0.1, 0.1, 0.1, 0.02]
    assert [found[name].unit for name in names] == ["N"] * 3 + ["N m"] * 3 + ["1"]
    with pytest.warns(UserWarning, match="taken as exact: wrench: bias of the forces, wrench: bias of the moments"):
        exact = problem(force_bias_n=0, torque_bias_nm=0, force_noise_n=0, torque_noise_nm=0, wrench_scale=0)
    assert not any(p.block.startswith("wrench") for p in touchcal.calibrate(exact).parameters)
