"""The choice of a model by prediction."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import touchcal
from touchcal import ModelChoice, Problem


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("select")
    touchcal.simulate("mukca", 1, contacts=15).save(folder)
    return folder


@pytest.fixture(scope="module")
def choice(folder: Path) -> ModelChoice:
    return touchcal.select(Problem.from_toml(folder / "problem.toml"))


def test_the_choice_is_that_of_the_command(folder: Path, choice: ModelChoice, run) -> None:
    printed = json.loads(run("select", folder / "problem.toml", "--json"))
    assert choice.chosen.blocks == printed["chosen"] == ["joint_origin"]
    assert choice.group_kind == printed["group_kind"] and choice.groups == printed["groups"]
    assert [model.errors for model in choice.models] == [model["errors"] for model in printed["models"]]
    assert [gain.gain for gain in choice.gains] == [gain["gain"]["mean"] for gain in printed["gains"]]
    assert choice.chosen in choice.models and choice.best.above_best == 0
    table = choice.to_pandas()
    assert table["chosen"].sum() == 1 and table.loc[table["chosen"], "model"].item() == choice.chosen.name
    assert np.allclose(table["held_out"], [np.mean(model.errors) for model in choice.models])


def test_a_calibration_with_the_chosen_model_says_how_it_was_chosen(choice: ModelChoice, tmp_path: Path) -> None:
    calibration = touchcal.calibrate(choice.problem)
    blocks = {parameter.block for parameter in calibration.parameters}
    assert "joint_origin" in blocks and not blocks & {"joint_compliance", "joint_harmonic"}
    calibration.save(tmp_path)
    notes = json.loads((tmp_path / "estimate.json").read_text())["notes"]
    assert any(note.startswith("model: joint_origin; 3 placements, each left out") for note in notes)


def test_a_choice_is_sent_to_other_processes(choice: ModelChoice) -> None:
    again = pickle.loads(pickle.dumps(choice))
    assert repr(again) == repr(choice) and again.models == choice.models and again.gains == choice.gains
    assert again.problem.notes == choice.problem.notes


def test_few_contacts_are_refused() -> None:
    few = touchcal.simulate("workcell", 3, contacts=15).problem()
    with pytest.raises(touchcal.InputError, match="select: expected contacts with at least 3 .* found 15 contacts"):
        touchcal.select(few)


def test_what_a_callback_raises_ends_the_work(folder: Path) -> None:
    seen = []

    def stop(progress: touchcal.Progress) -> None:
        seen.append(progress)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        touchcal.select(Problem.from_toml(folder / "problem.toml"), stop)
    assert [(progress.stage, progress.iteration) for progress in seen] == [("selection", 1)]
