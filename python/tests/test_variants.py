"""Problems that were read or simulated, with other arguments."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import touchcal
from touchcal import ContactLog, Problem, Tool


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("variants")
    touchcal.simulate("workcell", 3, contacts=200).save(folder)
    return folder


def names(problem: Problem) -> set[str]:
    return {parameter.name for parameter in touchcal.inspect(problem).parameters}


def test_settings_of_a_file_are_those_of_a_changed_file(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    text = (folder / "problem.toml").read_text()
    tables = '[noise]\nencoder_deg = 0.01\ncontact_mm = 0.02\n[estimate]\nparameters = ["joint_offset", "strain"]\nloss = "huber"\n'
    (tmp_path / "problem.toml").write_text(text[: text.index("[noise]")] + tables)
    noise, estimate = {"encoder_deg": 0.01, "contact_mm": 0.02}, {"loss": "huber"}
    read = Problem.from_toml(folder / "problem.toml")
    changed = read.with_(parameters=["joint_offset", "strain"], noise=noise, estimate=estimate)
    expected = Problem.from_toml(tmp_path / "problem.toml")
    assert touchcal.calibrate(changed).parameters == touchcal.calibrate(expected).parameters
    assert changed.notes == expected.notes and changed.inputs == read.inputs
    # One after the other is the same, and what is not named stays.
    one_by_one = read.with_(estimate=estimate).with_(noise=noise).with_(parameters=["joint_offset", "strain"])
    assert touchcal.calibrate(one_by_one).parameters == touchcal.calibrate(changed).parameters
    assert len(names(read)) + 1 == len(names(read.with_(parameters=["joint_offset", "strain"])))
    assert read.with_() is read


def test_a_simulated_problem_is_changed(folder: Path) -> None:
    simulated = touchcal.simulate("workcell", 3, contacts=200).problem()
    changed = {"parameters": ["joint_offset", "strain"], "accept": {"tolerance_mm": 1, "joints_deg": [[-10, 10]] * 7}}
    result = touchcal.calibrate(simulated.with_(**changed))
    saved = touchcal.calibrate(Problem.from_toml(folder / "problem.toml").with_(**changed))
    assert result.acceptance and saved.acceptance and "strain" in [parameter.name for parameter in result.parameters]
    values = [[parameter.value for parameter in each.parameters] for each in (result, saved)]
    # Files have twelve digits of numbers and nine of joint positions.
    assert np.allclose(*values, rtol=0, atol=1e-6)
    without = simulated.with_(**changed).with_(accept=None)
    assert touchcal.calibrate(without).acceptance is None


def test_the_tool_of_a_file_is_changed_with_its_note(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    text = (folder / "problem.toml").read_text()
    (tmp_path / "problem.toml").write_text(text.replace("sigma_mm = 0.05\nsigma_deg = 0.02\n", "", 1))
    with pytest.warns(UserWarning, match="tool: place ± 0.3 mm"):
        problem = Problem.from_toml(tmp_path / "problem.toml")
    exact = problem.with_(tool=Tool(touchcal.pose((0, 0, 0.1)), exact=True))
    assert any(name.startswith("tool.") for name in names(problem)) and not any(name.startswith("tool.") for name in names(exact))
    assert not any("tool: place" in note for note in exact.notes)
    with pytest.warns(UserWarning, match="tool: place ± 0.3 mm"):
        problem.with_(tool=Tool(touchcal.pose((0, 0, 0.1))))
    # What another tool may be, the one of the file is not.
    with pytest.raises(touchcal.InputError, match='with_: expected parameters without "tool" as before, or another tool'):
        problem.with_(parameters=["joint_offset", "tool"])
    free = problem.with_(parameters=["joint_offset", "tool"], tool=Tool(touchcal.pose((0, 0, 0.1))))
    assert not any("tool: place" in note for note in free.notes)


def test_logs_of_a_file_are_changed_with_their_inputs(folder: Path) -> None:
    problem = Problem.from_toml(folder / "problem.toml")
    log = ContactLog.from_numpy(problem.robot, problem.q[:50])
    fewer = problem.with_(contacts={"hole": log})
    assert len(fewer) == 50 and np.array_equal(fewer.q, problem.q[:50])
    assert not any(path.endswith("hole.csv") for path, _ in fewer.inputs) and len(fewer.inputs) == len(problem.inputs)
    held_out = problem.with_(held_out={"hole": log})
    assert len(held_out) == len(problem) and len(held_out.inputs) == len(problem.inputs) + 1
    assert touchcal.calibrate(held_out).held_out and touchcal.calibrate(held_out.with_(held_out=None)).held_out is None
    # Rows that contacts have are not held out.
    with pytest.warns(UserWarning, match="50 of 50 contacts are rows that were read before"):
        both = problem.with_(contacts={"hole": log}, held_out={"hole": log})
    assert touchcal.calibrate(both).held_out is None
    with pytest.raises(touchcal.InputError, match='contacts: expected the name of a fixture .hole., found "hle"'):
        problem.with_(contacts={"hle": log})


def test_what_cannot_be_changed_says_what_to_do(folder: Path) -> None:
    problem = Problem.from_toml(folder / "problem.toml")
    expected = "with_: expected tool, contacts, held_out, parameters, noise, estimate, accept of a problem that was read or simulated"
    for name, value in {"robot": problem.robot, "fixtures": [], "distances": []}.items():
        with pytest.raises(touchcal.InputError, match=f"{expected}, found {name}; change the file and read it again, or make the problem by Problem"):
            problem.with_(**{name: value})
    with pytest.raises(TypeError, match="unexpected keyword argument 'tolerances'"):
        problem.with_(tolerances=1)
    with pytest.raises(touchcal.InputError, match='parameters: expected a block of parameters .*, found "strian"'):
        problem.with_(parameters=["strian"])
    with pytest.raises(touchcal.InputError, match='expected parameters without "fixture" as before, found parameters with it'):
        problem.with_(parameters=["joint_offset", "fixture"])
