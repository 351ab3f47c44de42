"""touchcal.correction against positions that the library computed, without the compiled part of the package."""

import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import touchcal

CASES = Path(__file__).parents[2] / "crates/touchcal/tests/formats/correction"


@pytest.fixture(scope="module")
def correction() -> ModuleType:
    """The file on its own, as it is copied."""
    path = Path(touchcal.__file__).parent / "correction.py"
    spec = importlib.util.spec_from_file_location("copied_correction", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    assert not re.search(r"^\s*(from|import) touchcal", path.read_text(), re.MULTILINE)
    return module


@pytest.mark.parametrize("arm", ["ur10", "iiwa14", "sliding"])
def test_positions_are_those_of_the_library(correction: ModuleType, arm: str) -> None:
    reader = correction.Correction.read(CASES / f"{arm}.json")
    rows = np.loadtxt(CASES / f"{arm}.csv", delimiter=",")
    n = len(reader.names)
    assert rows.shape == (40, 2 * n + 6)
    for row in rows:
        measured, load, expected = row[:n], row[n : n + 6], row[n + 6 :]
        found = reader.true_positions(measured, load)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
        np.testing.assert_allclose(reader.commanded_positions(expected, load), measured, rtol=0, atol=1e-12)
        np.testing.assert_allclose(reader.commanded_positions(found, load), measured, rtol=0, atol=1e-12)
    unloaded = reader.true_positions(rows[0, :n])
    np.testing.assert_allclose(unloaded, rows[0, n + 6 :], rtol=0, atol=1e-12)


def test_positions_by_measured_torques_are_those_of_the_library(correction: ModuleType) -> None:
    reader = correction.Correction.read(CASES / "torques.json")
    assert reader.has_measured_torques
    n = len(reader.names)
    rows = np.loadtxt(CASES / "torques.csv", delimiter=",")
    assert rows.shape == (40, 3 * n)
    for measured, tau, expected in rows.reshape(40, 3, n):
        found = reader.true_positions(measured, tau=tau)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    zeros = [0.0] * n
    with pytest.raises(correction.CorrectionError, match="`tau`, measured torques of the joints, and no `load`"):
        reader.true_positions(zeros)
    with pytest.raises(correction.CorrectionError, match="and no `load`"):
        reader.true_positions(zeros, [0.0] * 6, tau=zeros)
    with pytest.raises(correction.CorrectionError, match="nothing can be commanded"):
        reader.commanded_positions(zeros)
    by_gravity = correction.Correction.read(CASES / "sliding.json")
    with pytest.raises(correction.CorrectionError, match="no `tau`"):
        by_gravity.true_positions(zeros, tau=zeros)


def test_positions_with_backlash_are_those_of_the_library(correction: ModuleType) -> None:
    reader = correction.Correction.read(CASES / "backlash.json")
    n = len(reader.names)
    rows = np.loadtxt(CASES / "backlash.csv", delimiter=",")
    for row in rows:
        found = reader.true_positions(row[:n], row[n : n + 6])
        np.testing.assert_allclose(found, row[n + 6 :], rtol=0, atol=1e-12)
    with pytest.raises(correction.CorrectionError, match="without backlash"):
        reader.commanded_positions(rows[0, :n])


@pytest.mark.parametrize(
    ("found", "instead", "message"),
    [
        ('"schema": 1', '"schema": 2', "schema 1"),
        ('"usable"', '"not_usable"', "a calibration that may be used"),
        ('"usable"', '"fine"', "a status"),
        ('"gravity_and_load"', '"felt"', "a kind of torque"),
        ('"backlash_torque": 0.5', '"backlash_torque": 0', "a torque above 0"),
        ('"order":1', '"order":3', "order 1 or 2"),
        ('"mass_kg":', '"mass":', "mass_kg"),
        ('"sin":', '"sin":NaN,"was":', "a finite number"),
        ('"sin":', '"sin":1e999,"was":', "a finite number"),
        ('"xyz_m":[', '"xyz_m":[1,', "3 numbers"),
        ('"axis":[', '"axis":[0,0,2],"was":[', "a unit vector"),
        ('"quat_wxyz":[', '"quat_wxyz":[3,0,0,0],"was":[', "a unit quaternion"),
        ('"joints": [', '"joints": 3, "was": [', "not the text of a correction.json"),
        ("{", "", "not the text of a correction.json"),
    ],
)
def test_other_files_are_refused(correction: ModuleType, found: str, instead: str, message: str) -> None:
    text = (CASES / "ur10.json").read_text()
    assert found in text
    with pytest.raises(correction.CorrectionError, match=message):
        correction.Correction(text.replace(found, instead, 1))


def test_a_result_that_is_not_usable_is_read_on_request(correction: ModuleType) -> None:
    text = (CASES / "ur10.json").read_text().replace('"usable"', '"not_usable"', 1)
    reader = correction.Correction(text, not_usable=True)
    assert reader.status == "not_usable"
    with pytest.raises(correction.CorrectionError, match="6 numbers"):
        reader.true_positions([0.0] * 7)


def test_degrees_are_refused(correction: ModuleType) -> None:
    for arm in ("ur10", "sliding", "torques"):
        reader = correction.Correction.read(CASES / f"{arm}.json")
        content = json.loads((CASES / f"{arm}.json").read_text())
        tau = [0.0] * len(reader.names) if reader.has_measured_torques else None
        for joint, entry in enumerate(content["joints"]):
            positions = [0.0] * len(reader.names)
            positions[joint] = -90.0
            if entry["kind"] == "prismatic":
                reader.torques(positions)
                continue
            message = rf"expected at most 12\.566 rad of joint '{reader.names[joint]}' \(angles are radians\), found -90\.0 rad"
            with pytest.raises(correction.CorrectionError, match=message):
                reader.true_positions(positions, tau=tau)
            with pytest.raises(correction.CorrectionError, match=message):
                reader.commanded_positions(positions)
            with pytest.raises(correction.CorrectionError, match=message):
                reader.torques(positions)
            # A joint of two turns to either side.
            positions[joint] = -12.56
            reader.true_positions(positions, tau=tau)
