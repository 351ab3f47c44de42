"""Calibrations that were saved: read back, evaluated, and compared as the command line does."""

import ast
import json
import pickle
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import touchcal
from touchcal import SavedCalibration


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[touchcal.Calibration, Path]]:
    """Two calibrations of one arm, of different logs, with their folders."""
    found = []
    for noise_seed in (3, 4):
        folder = tmp_path_factory.mktemp("saved")
        simulation = touchcal.simulate("workcell", 3, contacts=600, noise_seed=noise_seed)
        simulation.save(folder)
        calibration = touchcal.calibrate(touchcal.Problem.from_toml(folder / "problem.toml"))
        calibration.save(folder / "out")
        found.append((calibration, folder))
    return found


def test_what_was_saved_is_read_back(saved: list[tuple[touchcal.Calibration, Path]]) -> None:
    calibration, folder = saved[0]
    loaded = SavedCalibration.load(folder / "out")
    for each in ("status", "usable", "parameters", "rank", "null_space", "warnings", "untested"):
        assert getattr(loaded, each) == getattr(calibration, each), each
    assert loaded.covariance.tobytes() == calibration.covariance.tobytes()
    assert loaded.to_json() == calibration.to_json() == (folder / "out/estimate.json").read_text()
    assert loaded.to_pandas().equals(calibration.to_pandas())
    assert loaded.covariance_frame().equals(calibration.covariance_frame())
    name = calibration.parameters[0].name
    assert loaded[name] == calibration[name] and name in loaded._ipython_key_completions_()
    # Millimetres of the file: to rounding.
    tool, expected = loaded.workspace_uncertainty, calibration.workspace_uncertainty
    assert tool and expected and tool.position == pytest.approx(expected.position, rel=1e-14)
    assert tool.nominal_angle == pytest.approx(expected.nominal_angle, rel=1e-14)
    # The summary is that of the result, but for the noise factor, which no file has, and the tests.
    lines = calibration.summary().splitlines()
    assert "What contacts say against the problem file" not in lines
    others = [line for line in lines if line.startswith(("Noise ", "Left out ", "Declared ", "Untested "))]
    assert loaded.summary().splitlines() == [line for line in lines if line not in others]
    assert len(loaded.summary().splitlines()) == len(lines) - 4 and "<table>" in loaded._repr_html_()
    assert loaded.robot and loaded.robot.urdf == calibration.calibrated_urdf()
    q = np.random.default_rng(1).uniform(-2, 2, (20, 7))
    assert np.array_equal(loaded.robot.base_from_tip(q), calibration.robot.base_from_tip(q))
    written = json.loads(calibration.to_json())
    assert (loaded.version, loaded.created) == (touchcal.__version__, written["created"])
    assert loaded.inputs == [(entry["path"], entry["sha256"]) for entry in written["inputs"]] != []


def test_save_returns_what_its_types_say(saved: list[tuple[touchcal.Calibration, Path]], tmp_path: Path) -> None:
    stubs = ast.parse(Path(touchcal.__file__).with_name("_touchcal.pyi").read_text())
    classes = {node.name: node for node in stubs.body if isinstance(node, ast.ClassDef)}

    def returned(owner: str) -> object:
        (save,) = (part for part in classes[owner].body if isinstance(part, ast.FunctionDef) and part.name == "save")
        assert save.returns
        return eval(ast.unparse(save.returns), {"Path": Path})  # noqa: S307

    calibration, _ = saved[0]
    written = calibration.save(tmp_path / "calibration")
    kinds = get_args(returned("Calibration"))
    assert len(kinds) == len(written) == 3 and all(isinstance(path, kind) for path, kind in zip(written, kinds, strict=True))
    assert returned("Simulation") is touchcal.simulate("paper", 1, contacts=3).save(tmp_path / "simulation") is None
    assert [name for name, owner in classes.items() if any(getattr(part, "name", "") == "save" for part in owner.body)] == ["Calibration", "Simulation"]


def test_a_saved_calibration_is_evaluated_as_its_files_are(saved: list[tuple[touchcal.Calibration, Path]], tmp_path: Path) -> None:
    (_, folder), (_, other) = saved
    problem, out = touchcal.Problem.from_toml(other / "problem.toml"), folder / "out"
    by_files = touchcal.evaluate(problem, urdf=out / "calibrated.urdf", estimate=out / "estimate.json")
    loaded = SavedCalibration.load(out)
    found = touchcal.evaluate(problem, loaded)
    assert (found.all, found.scatter) == (by_files.all, by_files.scatter)
    # Without the URDF there is no calibrated arm.
    (tmp_path / "estimate.json").write_bytes((out / "estimate.json").read_bytes())
    alone = SavedCalibration.load(tmp_path / "estimate.json")
    assert alone.robot is None and alone.parameters == loaded.parameters
    with pytest.raises(touchcal.InputError, match="expected a folder with calibrated.urdf, found an estimate.json alone"):
        touchcal.evaluate(problem, alone)


def test_calibrations_are_compared_as_by_the_command(saved: list[tuple[touchcal.Calibration, Path]], run) -> None:
    (first, folder), (second, other) = saved
    printed = json.loads(run("compare", folder / "out", other / "out", "--json"))
    both = SavedCalibration.load(folder / "out"), SavedCalibration.load(other / "out")
    found = touchcal.compare(*both)
    arm = printed["arm"]
    assert (found.p_value, found.statistic, found.degrees_of_freedom) == (arm["p_value"], arm["statistic"], arm["degrees_of_freedom"])
    assert found.degrees_of_freedom > 0 and found.only_in_one == arm["only_in_one"] and found.common_logs == printed["common_logs"]
    changes = [(change.name, change.earlier, change.later, change.sigma, change.deviations) for change in found.parameters]
    keys = ("name", "earlier", "later", "sigma_of_difference", "deviations")
    assert changes == [tuple(entry[key] for key in keys) for entry in arm["parameters"]]
    assert found.tool_p_value == printed["tool"]["p_value"] and len(found.tool_parameters) == len(printed["tool"]["parameters"])
    motion = printed["tip_motion"]["position_mm"]
    assert found.tip_motion and np.allclose(1e3 * np.array(found.tip_motion), [motion["rms"], motion["max"]], rtol=1e-12, atol=0)
    assert pickle.loads(pickle.dumps(found)) == found and pickle.loads(pickle.dumps(both[0])).to_json() == both[0].to_json()
    # Saved or not is the same, and nothing changed from a calibration to itself.
    assert repr(touchcal.compare(first, second)) == repr(found)
    itself = touchcal.compare(first, both[0])
    assert (itself.statistic, itself.p_value, itself.tip_motion) == (0, 1, (0, 0)) and len(itself.common_logs) == 1


def test_a_comparison_has_the_notes_of_the_command(saved: list[tuple[touchcal.Calibration, Path]], run) -> None:
    (first, folder), (second, _) = saved
    assert touchcal.compare(first, second).notes == []
    itself = touchcal.compare(first, first)
    (note,) = itself.notes
    assert note.startswith("both calibrations read ") and repr(itself).endswith(f"; note: {note})")
    printed = run("compare", folder / "out", folder / "out")
    assert printed[printed.index("Note ") :].split()[1:].index("parameter") == len(note.split())
    assert " ".join(printed.split()).count(f"Note {note}") == 1


def test_what_was_changed_or_is_another_arm_is_refused(saved: list[tuple[touchcal.Calibration, Path]], tmp_path: Path) -> None:
    calibration, _ = saved[0]
    for name in ("estimate.json", "calibrated.urdf"):
        calibration.save(tmp_path / name)
        path = tmp_path / name / name
        path.write_text(path.read_text() + "\n")
        with pytest.raises(touchcal.InputError, match=f"{name}: expected the file that touchcal.json lists, as it was written, found another or a changed one"):
            SavedCalibration.load(tmp_path / name)
    # Each by itself is checked too, if the manifest beside it lists it.
    alone = tmp_path / "estimate.json/estimate.json"
    with pytest.raises(touchcal.InputError, match="estimate.json: expected the file that touchcal.json lists"):
        SavedCalibration.load(alone)
    (tmp_path / "elsewhere.json").write_bytes(alone.read_bytes())
    assert SavedCalibration.load(tmp_path / "elsewhere.json").parameters == calibration.parameters
    (tmp_path / "calibrated.urdf/calibrated.urdf").unlink()
    with pytest.raises(touchcal.FileError, match="calibrated.urdf"):
        SavedCalibration.load(tmp_path / "calibrated.urdf")
    with pytest.raises(touchcal.FileError, match="none"):
        SavedCalibration.load(tmp_path / "none")
    arm = touchcal.Robot.from_urdf("panda")
    log = touchcal.ContactLog.from_numpy(arm, np.random.default_rng(1).uniform(-1, 1, (30, arm.dof)))
    socket = touchcal.Fixture("socket", touchcal.Manifold.ball_in_socket(), free=True)
    panda = touchcal.calibrate(touchcal.Problem(arm, touchcal.Tool(exact=True), [socket], {"socket": log}, parameters=["strain"]))
    with pytest.raises(touchcal.InputError, match="later.*expected a calibration of the robot"):
        touchcal.compare(calibration, panda)


def test_the_summary_of_a_descent_that_failed_says_nothing_of_the_data(tmp_path: Path) -> None:
    touchcal.simulate("paper", 1, contacts=200).save(tmp_path)
    text = (tmp_path / "problem.toml").read_text()
    method = '[estimate]\nmethod = "gradient_descent"\ndescent = { steps = 30, contacts = 40, rate = 50 }'
    (tmp_path / "descent.toml").write_text(text.replace("[estimate]", method))
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(tmp_path / "descent.toml"))
    calibration.save(tmp_path / "out")
    loaded = SavedCalibration.load(tmp_path / "out")
    for summary in (calibration.summary(), loaded.summary()):
        lines = summary.splitlines()
        assert lines[0].startswith("NOT USABLE") and "not converge" in lines[0]
        assert "Identifiable      not stated, since the gradient descent did not end at a minimum" in lines
        assert "not identifiable" not in summary and "Not identifiable" not in summary
        warnings = [line for line in lines if line.startswith("Warning ")]
        assert "the gradient descent did not end at a minimum" in warnings[0] and "take the default method" in warnings[0]
    assert loaded.warnings[0].kind == "descent_failed"
    assert "not stated" in loaded._repr_html_()
