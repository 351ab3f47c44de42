"""Tests of what a problem declares and of what its model leaves out."""

import json
from pathlib import Path

import numpy as np
import pytest

import touchcal

EXACT = """
preset = "workcell"
contacts = 1500
friction = 0
contact_mm = 0.005
[recorder]
rate_hz = 300
force_sigma_n = 0
force_lag_s = 0
"""


@pytest.fixture(scope="module")
def with_exact_tool(tmp_path_factory: pytest.TempPathFactory) -> touchcal.Problem:
    """A log without friction; tool and shape of the hole are declared exact."""
    folder = tmp_path_factory.mktemp("exact")
    (folder / "exact.toml").write_text(EXACT)
    touchcal.simulate(folder / "exact.toml", 3).save(folder)
    text = (folder / "problem.toml").read_text()
    text = text.replace("sigma_mm = 0.05\nsigma_deg = 0.02\n", "exact = true\n")
    text = text.replace("clearance_sigma_mm = 0.02\ndepth_sigma_mm = 0.02\n", 'exact = ["clearance", "depth"]\n')
    (folder / "problem.toml").write_text(text)
    return touchcal.Problem.from_toml(folder / "problem.toml")


def test_what_is_left_out_is_tested(with_exact_tool: touchcal.Problem) -> None:
    calibration = touchcal.calibrate(with_exact_tool)
    tests = {test.effect: test for test in calibration.effect_tests}
    # The tool is declared exact; the fixture has a standard deviation and is estimated.
    assert {"joint_compliance", "joint_origin", "joint_trend", "tool"} <= set(tests)
    assert "fixture.hole" not in tests
    p_values = [test.p_value for test in calibration.effect_tests]
    assert p_values == sorted(p_values) and all(0 <= p <= 1 for p in p_values)
    test = tests["joint_compliance"]
    assert test.description and test.degrees_of_freedom >= 1 and test.statistic > 0 and test.radius > 0
    value, sigma = test.values["joint_compliance.joint_a2"]
    assert np.isfinite(value) and sigma >= 0
    # All entries are those of the file.
    written = json.loads(calibration.to_json())["effect_tests"]
    assert [entry["effect"] for entry in written] == [test.effect for test in calibration.effect_tests]
    assert written[0]["displacement_mm"] == pytest.approx(1e3 * calibration.effect_tests[0].displacement, rel=1e-12)


def test_what_is_declared_is_tested(with_exact_tool: touchcal.Problem) -> None:
    calibration = touchcal.calibrate(with_exact_tool)
    tests = {test.name: test for test in calibration.prior_tests}
    # The tool is declared exact; the fixture has a standard deviation.
    assert {"fixture.hole", "noise"} <= set(tests) and "tool" not in tests
    test = tests["fixture.hole"]
    assert 0 < test.p_value <= 1 and test.degrees_of_freedom >= 1 and test.displacement > 0
    x = next(entry for entry in calibration.parameters if entry.name == "fixture.hole.x")
    assert test.values["fixture.hole.x"] == (x.value, x.prior_sigma)
    written = json.loads(calibration.to_json())["prior_tests"]
    assert [entry["name"] for entry in written] == [test.name for test in calibration.prior_tests]


def test_a_summary_has_what_contacts_contradict(run, tmp_path: Path) -> None:
    (tmp_path / "strained.toml").write_text(EXACT.replace("[recorder]", "[errors]\nsegment_strain = 0.002\n[recorder]"))
    touchcal.simulate(tmp_path / "strained.toml", 3).save(tmp_path)
    # Links are strained, and the problem leaves it out.
    file = tmp_path / "problem.toml"
    file.write_text(file.read_text().replace('["segment_strain", "joint_offset"]', '["joint_offset"]'))
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(file))
    assert {test.effect: test.p_value for test in calibration.effect_tests}["segment_strain"] < 1e-3
    lines = calibration.summary().splitlines()
    begin = lines.index("What contacts say against the problem file")
    end = next(k for k in range(begin + 1, len(lines)) if not lines[k].startswith("  "))
    table = [line.split() for line in lines[begin + 1 : end]]
    assert table[0][:4] == ["left", "out", "or", "declared"] and "segment_strain" in [row[0] for row in table]
    assert {"Declared", "Untested"} <= {line[:18].strip() for line in lines[end:]}
    # The words are those of the terminal.
    terminal = run("calibrate", file, "--out", tmp_path / "out").split()
    for words in [*table, *(line[18:].split() for line in lines[end:] if not line.startswith("Warning"))]:
        assert any(terminal[k : k + len(words)] == words for k in range(len(terminal))), words
    page = calibration._repr_html_()  # type: ignore[attr-defined]
    assert "<b>What contacts say against the problem file</b>" in page and "<td>segment_strain</td>" in page
