"""Same input, same bits, same words as the command-line tool."""

import json
import re
from pathlib import Path

import pytest

import touchcal


def timeless(text: str) -> str:
    """A result's text but for when it was made and the time that it took."""
    return re.sub(r'("(?:seconds|created)": ?)(?:[0-9.e-]+|"[0-9TZ:-]+")', r"\g<1>0", text)


@pytest.mark.parametrize("data", ["workcell", "sockets"])
def test_files_of_a_calibration(data: str, run, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    problem = request.getfixturevalue(data) / "problem.toml"
    run("calibrate", problem, "--out", tmp_path / "command")
    written = touchcal.calibrate(touchcal.Problem.from_toml(problem)).save(tmp_path / "python")
    assert [Path(path).name for path in written] == ["calibrated.urdf", "estimate.json", "report.html"]
    for path in written:
        theirs = (tmp_path / "command" / Path(path).name).read_text()
        assert timeless(Path(path).read_text()) == timeless(theirs), path


def test_files_for_other_programs(run, workcell: Path, tmp_path: Path) -> None:
    run("calibrate", workcell / "problem.toml", "--out", tmp_path / "command", "--export", "dh,xacro")
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))
    calibration.save(tmp_path / "python", export=["dh", "xacro"])
    for name in ("dh.json", "calibrated.xacro"):
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name
    with pytest.raises(touchcal.InputError, match="export: expected ur, dh, xacro, ros2_control, found"):
        calibration.save(tmp_path / "other", export=["urdf"])  # type: ignore[list-item]
    with pytest.raises(touchcal.InputError, match="expected an arm with the joints shoulder_pan_joint, "):
        calibration.save(tmp_path / "other", export=["ur"])
    assert not (tmp_path / "other").exists()


def test_files_of_a_simulation(run, tmp_path: Path) -> None:
    run("simulate", "--preset", "workcell", "--seed", 7, "--contacts", 200, "--out", tmp_path / "command")
    touchcal.simulate("workcell", 7, contacts=200).save(tmp_path / "python")
    names = sorted(path.name for path in (tmp_path / "command").iterdir())
    assert names == ["hole.csv", "problem.toml", "scenario.toml", "touchcal.json", "true.urdf", "truth.json"]
    for name in names:
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name


def test_scores(run, workcell: Path, tmp_path: Path) -> None:
    problem = touchcal.Problem.from_toml(workcell / "problem.toml")
    calibration = touchcal.calibrate(problem)
    urdf, estimate, _ = calibration.save(tmp_path)
    printed = json.loads(
        run("evaluate", workcell / "problem.toml", "--urdf", urdf, "--estimate", estimate, "--json")
    )
    score = touchcal.evaluate(problem, urdf=urdf, estimate=estimate)
    assert [printed["mean_mm"], printed["rms_mm"], printed["max_mm"]] == [
        1e3 * value for value in (score.all.mean, score.all.rms, score.all.max)
    ]
    assert printed["nominal"]["rms_mm"] == 1e3 * touchcal.evaluate(problem).all.rms
    # The file's numbers are rounded in the last digit or not at all.
    from_memory = touchcal.evaluate(problem, calibration)
    assert from_memory.all.rms == pytest.approx(score.all.rms, rel=1e-9)
    scatter = score.scatter
    assert scatter is not None and from_memory.scatter is not None
    assert from_memory.scatter.predicted == pytest.approx(scatter.predicted, rel=1e-6)
    assert printed["scatter"]["all"] == {
        "found_mm": 1e3 * scatter.found,
        "predicted_mm": 1e3 * scatter.predicted,
        "ratio": scatter.ratio,
        "by_chance": list(scatter.by_chance),
    }
    assert printed["scatter"]["per_fixture"].keys() == score.scatter_per_fixture.keys() == {"hole"}


def test_distances_of_fixtures(run, sockets: Path, tmp_path: Path) -> None:
    problem = touchcal.Problem.from_toml(sockets / "problem.toml")
    urdf, estimate, _ = touchcal.calibrate(problem).save(tmp_path)
    false = sockets / "false.toml"
    text = (sockets / "problem.toml").read_text()
    assert "mm = 50" in text
    false.write_text(text.replace("mm = 50", "mm = 49"))
    printed = json.loads(run("evaluate", false, "--urdf", urdf, "--estimate", estimate, "--json"))
    found = touchcal.evaluate(touchcal.Problem.from_toml(false), urdf=urdf, estimate=estimate)
    assert [tuple(entry["between"]) for entry in printed["distances"]] == [each.between for each in found.distances]
    assert [entry["deviations"] for entry in printed["distances"]] == [each.deviations for each in found.distances]
    assert all(each.source == "distance" and each.declared == 0.049 and each.deviations > 3 for each in found.distances)
    assert [warning["message"] for warning in printed["warnings"]] == [warning.message for warning in found.warnings]
    assert found.common_strain is not None and found.common_strain[0] > 0.015
    assert "predicted" in found.to_pandas()
    assert not touchcal.evaluate(touchcal.Problem.from_toml(false), urdf=urdf).warnings


def test_inspections(run, sockets: Path) -> None:
    printed = json.loads(run("inspect", sockets / "problem.toml", "--json"))
    found = touchcal.inspect(touchcal.Problem.from_toml(sockets / "problem.toml"))
    assert printed["rank"] == found.rank
    assert printed["singular_values"] == found.singular_values.tolist()
    assert printed["contacts_per_fixture"] == found.per_fixture
    assert printed["nominal"]["mean_mm"] == pytest.approx(1e3 * found.nominal.all.mean, rel=1e-12)
    assert [warning["kind"] for warning in printed["warnings"]] == [warning.kind for warning in found.warnings]
    assert [entry["sigma"] for entry in printed["parameters"]] == [entry.sigma for entry in found.parameters]
    assert printed["null_space"] == [null.description for null in found.null_space]
    assert [entry["least"] for entry in printed["joints"]] == [joint.least for joint in found.ranges]


BROKEN = {
    "unknown key": ("[estimate]", "[estimat]"),
    "unknown block": ('["joint_offset"]', '["joint_offsets"]'),
    "out of range": ("depth_mm = 30", "depth_mm = -30"),
    "no such file": ('file = "hole.csv"', 'file = "holes.csv"'),
    "no such fixture": ('fixture = "hole"', 'fixture = "hull"'),
    "no such arm": ('builtin = "iiwa14"', 'builtin = "iiwa41"'),
    "no shape": ("depth_mm = 30", 'depth_mm = 30\nmanifold = "unknown"'),
    "not a number": ("force_threshold_n = 3", "force_threshold_n = nan"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_words_about_a_problem(case: str, run, workcell: Path) -> None:
    broken = workcell / "broken.toml"
    before, after = BROKEN[case]
    text = (workcell / "problem.toml").read_text()
    assert before in text
    broken.write_text(text.replace(before, after))
    with pytest.raises(run.Refusal) as refused:
        run("inspect", broken)
    with pytest.raises(touchcal.InputError) as raised:
        touchcal.Problem.from_toml(broken)
    assert str(raised.value) == str(refused.value)
    assert raised.value.file in str(raised.value)


def test_words_about_a_log(run, workcell: Path, tmp_path: Path) -> None:
    lines = (workcell / "hole.csv").read_text().splitlines()
    lines[4] = lines[4].replace(lines[4].split(",")[2], "many", 1)
    (tmp_path / "hole.csv").write_text("\n".join(lines))
    (tmp_path / "problem.toml").write_text((workcell / "problem.toml").read_text())
    with pytest.raises(run.Refusal) as refused:
        run("calibrate", tmp_path / "problem.toml", "--out", tmp_path)
    with pytest.raises(touchcal.InputError) as raised:
        touchcal.Problem.from_toml(tmp_path / "problem.toml")
    assert str(raised.value) == str(refused.value)
    assert (raised.value.file, raised.value.line) == (str(tmp_path / "hole.csv"), 5)


def test_words_about_files(run, workcell: Path, tmp_path: Path) -> None:
    nowhere = tmp_path / "nowhere.toml"
    with pytest.raises(run.Refusal) as refused:
        run("inspect", nowhere)
    with pytest.raises(touchcal.FileError) as raised:
        touchcal.Problem.from_toml(nowhere)
    assert str(raised.value) == str(refused.value)

    other = tmp_path / "panda.urdf"
    other.write_text(touchcal.Robot.from_urdf("panda").urdf.replace("panda_link0", "base_link"))
    problem = workcell / "problem.toml"
    with pytest.raises(run.Refusal) as refused:
        run("evaluate", problem, "--urdf", other)
    with pytest.raises(touchcal.InputError) as raised:
        touchcal.evaluate(touchcal.Problem.from_toml(problem), urdf=other)
    assert str(raised.value) == str(refused.value)


def test_a_users_own_problem_is_not_overwritten(run, tmp_path: Path) -> None:
    (tmp_path / "problem.toml").write_text("# mine")
    with pytest.raises(run.Refusal) as refused:
        run("simulate", "--preset", "workcell", "--contacts", 10, "--out", tmp_path)
    with pytest.raises(touchcal.InputError) as raised:
        touchcal.simulate("workcell", 1, contacts=10).save(tmp_path)
    assert str(raised.value) == str(refused.value)
    assert (tmp_path / "problem.toml").read_text() == "# mine"
