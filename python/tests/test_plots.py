"""Pictures of a calibration show its numbers."""

from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes

import touchcal
from touchcal import plots

matplotlib.use("Agg")


@pytest.fixture(scope="module")
def calibration(workcell: Path) -> touchcal.Calibration:
    return touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))


@pytest.fixture
def ax() -> Iterator[Axes]:
    from matplotlib import pyplot

    figure, ax = pyplot.subplots(layout="constrained")
    yield ax
    # Drawing is where names that are taken for formulas fail.
    figure.canvas.draw()
    pyplot.close(figure)


def texts(labels: object) -> list[str]:
    return [label.get_text() for label in labels]  # type: ignore[attr-defined]


def test_parameters_are_ratios_in_order(calibration: touchcal.Calibration, ax: Axes) -> None:
    plots.parameters(calibration, ax, most=5)
    known = [parameter for parameter in calibration.parameters if parameter.identifiable and parameter.sigma]
    ratios = {parameter.name: parameter.value / (parameter.sigma or 0) for parameter in known}
    names = texts(ax.get_yticklabels())
    assert names == [name for name in ratios if name in names] and len(names) == 5 < len(ratios)
    assert min(abs(ratios[name]) for name in names) >= max(abs(ratios[name]) for name in ratios if name not in names)
    drawn = ax.lines[-1].get_xdata()
    assert list(drawn) == [ratios[name] for name in names]
    assert ax.get_xlabel() == "estimate / standard deviation (1)"


def test_residuals_count_every_contact(calibration: touchcal.Calibration, ax: Axes) -> None:
    plots.residuals(calibration, ax)
    counts = [sum(bar.get_height() for bar in group) for group in ax.containers]  # type: ignore[attr-defined]
    assert counts == [len(calibration.weights)] * 2
    rms = [1e3 * score.all.rms for score in (calibration.prefit, calibration.postfit)]
    assert texts(ax.get_legend().get_texts()) == [  # type: ignore[union-attr]
        f"{label}: {value:.3g} mm rms" for label, value in zip(("before", "after"), rms, strict=True)
    ]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("distance from contact (mm)", "contacts")


def test_residuals_of_one_fixture(sockets: Path, ax: Axes) -> None:
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(sockets / "problem.toml"))
    plots.residuals(calibration, ax, fixture="left/1")
    counts = [sum(bar.get_height() for bar in group) for group in ax.containers]  # type: ignore[attr-defined]
    assert counts == [calibration.postfit.per_fixture["left/1"].count] * 2
    with pytest.raises(KeyError, match="expected the name of a fixture .*left/1.*, found 'left/7'"):
        plots.residuals(calibration, ax, fixture="left/7")


def test_the_tools_error_is_in_millimetres_and_degrees(calibration: touchcal.Calibration, ax: Axes) -> None:
    plots.workspace(calibration, ax)
    known = calibration.workspace_uncertainty
    assert known is not None
    before = [1e3 * known.nominal_position, 1e3 * known.nominal_distance, np.degrees(known.nominal_angle)]
    after = [1e3 * known.position, 1e3 * known.distance, np.degrees(known.angle)]
    heights = [[bar.get_height() for bar in group] for group in ax.containers]  # type: ignore[attr-defined]
    assert heights == [before, after]
    assert texts(ax.get_xticklabels()) == ["position\n(mm)", "distance\n(mm)", "rotation\n(deg)"]


def test_names_are_no_formulas(tmp_path: Path, ax: Axes) -> None:
    touchcal.simulate("mukca", 3, contacts=40).save(tmp_path)
    problem = tmp_path / "problem.toml"
    problem.write_text(problem.read_text().replace('"front/0"', r"'$\frac{$'"))
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(problem))
    plots.parameters(calibration, ax)
    plots.residuals(calibration, ax, fixture=r"$\frac{$")


def test_other_objects_are_refused(calibration: touchcal.Calibration, ax: Axes, tmp_path: Path) -> None:
    for draw in (plots.parameters, plots.residuals, plots.workspace):
        with pytest.raises(TypeError, match="argument 'ax': expected one matplotlib Axes, found ndarray"):
            draw(calibration, np.array([ax, ax]))  # type: ignore[arg-type]
    calibration.save(tmp_path)
    saved = touchcal.SavedCalibration.load(tmp_path)
    plots.parameters(saved, ax)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected a Calibration, which has its contacts, found SavedCalibration"):
        plots.residuals(saved, ax)  # type: ignore[arg-type]
    with pytest.raises(touchcal.InputError, match="calibrated.urdf: expected the folder of a calibration, or its estimate.json"):
        touchcal.SavedCalibration.load(tmp_path / "calibrated.urdf")
