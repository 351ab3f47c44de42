"""What people see of a result: its summary, its piece of HTML, and representations."""

import builtins
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import touchcal


@pytest.fixture(scope="module")
def calibration(workcell: Path) -> touchcal.Calibration:
    return touchcal.calibrate(touchcal.Problem.from_toml(workcell / "problem.toml"))


def test_a_summary_begins_with_the_verdict(calibration: touchcal.Calibration) -> None:
    lines = calibration.summary().splitlines()
    known = calibration.workspace_uncertainty
    assert calibration.status == "usable" and known is not None
    assert lines[0] == (
        f"USABLE            expected tool error in base {1e3 * known.position:.3f} mm, {np.degrees(known.angle):.3f}° "
        f"(before, with the tool as declared: {1e3 * known.nominal_position:.3f} mm, "
        f"{np.degrees(known.nominal_angle):.3f}°), "
        f"between two positions {1e3 * known.distance:.3f} mm (before: {1e3 * known.nominal_distance:.3f} mm)"
    )
    contacts = json.loads(calibration.to_json())["contacts"]
    assert lines[1].endswith(f"{contacts['read']} rows read: {contacts['used']} used, {contacts['rejected']} rejected")
    assert f"{1e3 * calibration.postfit.all.rms:.3f} mm rms" in lines[2]
    assert f"{calibration.noise_factor:.2f} times" in lines[3]
    listed = [line.split() for line in lines if re.match(r"  \S+\.\S+ ", line)]
    assert len(listed) == 10 < len(calibration.parameters)
    for name, value, sigma, *_, unit in listed:
        parameter = calibration[name]
        factor = {"m": 1e3, "rad": 180 / np.pi}[parameter.unit]
        assert unit == {"m": "mm", "rad": "deg"}[parameter.unit] and parameter.sigma is not None
        assert float(value) == pytest.approx(factor * parameter.value, abs=0.5001e-4)
        assert float(sigma) == pytest.approx(factor * parameter.sigma, abs=0.5001e-4)
    assert f"Identifiable      {calibration.rank} of " in calibration.summary()
    undetermined = [line for line in lines if line.startswith("Not identifiable")]
    assert undetermined[0].endswith(calibration.null_space[0].description) and len(undetermined) == 4
    assert undetermined[-1].endswith(f"and {len(calibration.null_space) - 3} more directions")


def test_gap_biases_of_directions_are_left_out_and_those_of_fixtures_are_not(calibration: touchcal.Calibration, tmp_path: Path) -> None:
    content = json.loads(calibration.to_json())
    names = ["gap_bias.hole", "gap_bias.hole.top", "gap_bias.hole.+x", "gap_bias.hole.top.-z"]
    content["parameters"] = [content["parameters"][0] | {"name": name, "block": "gap_bias", "unit": "m"} for name in names]
    content["covariance"] = np.zeros((4, 4)).tolist()
    (tmp_path / "estimate.json").write_text(json.dumps(content))
    summary = touchcal.SavedCalibration.load(tmp_path / "estimate.json").summary()
    assert re.findall(r"^  (gap_bias\S*)", summary, re.MULTILINE) == ["gap_bias.hole", "gap_bias.hole.top"]


def test_what_must_not_be_used_says_so_first() -> None:
    calibration = touchcal.calibrate(touchcal.simulate("paper", 1, contacts=3).problem())
    first, *others = calibration.summary().splitlines()
    assert first.startswith("NOT USABLE") and "do not use" in first
    warnings = [line for line in others if line.startswith("Warning")]
    assert calibration.warnings[0].message in warnings[0] and calibration.warnings[0].advice in warnings[0]


class Cells(HTMLParser):
    """Texts of the cells of a page, and its tags."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.add(tag)
        self.open += [] if tag == "br" else [tag]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open[-1] == "td":
            self.texts.append(data)


def test_html_escapes_names(tmp_path: Path) -> None:
    name = "<script>alert('a & b')</script>"
    touchcal.simulate("mukca", 3, contacts=40).save(tmp_path)
    problem = tmp_path / "problem.toml"
    problem.write_text(problem.read_text().replace('"front/0"', f'"{name}"'))
    calibration = touchcal.calibrate(touchcal.Problem.from_toml(problem))
    page = calibration._repr_html_()  # type: ignore[attr-defined]
    cells = Cells(page)
    assert not cells.open
    assert cells.tags == {"div", "p", "b", "br", "table", "thead", "tbody", "tr", "th", "td"}
    assert f"fixture.{name}.x" in cells.texts and calibration[f"fixture.{name}.x"]
    assert page.startswith("<div><p><b>USABLE</b> expected tool error")


def test_names_complete_keys(calibration: touchcal.Calibration) -> None:
    names = calibration._ipython_key_completions_()  # type: ignore[attr-defined]
    assert names == [parameter.name for parameter in calibration.parameters]


def test_a_covariance_has_names(calibration: touchcal.Calibration) -> None:
    frame = calibration.covariance_frame()
    names = [parameter.name for parameter in calibration.parameters]
    assert list(frame.index) == list(frame.columns) == names
    assert np.array_equal(frame.to_numpy(), calibration.covariance)
    sigma = calibration["joint_offset.joint_a3"].sigma
    assert sigma == pytest.approx(frame.loc["joint_offset.joint_a3", "joint_offset.joint_a3"] ** 0.5, rel=1e-12)


def test_representations_are_in_millimetres_and_degrees(calibration: touchcal.Calibration, workcell: Path) -> None:
    def shown(value: float) -> str:
        return repr(float(f"{value:.4g}"))

    parameter = calibration["joint_offset.joint_a3"]
    assert parameter.sigma is not None
    values = [shown(np.degrees(value)) for value in (parameter.value, parameter.sigma)]
    assert repr(parameter) == f'Parameter("joint_offset.joint_a3", {values[0]} ± {values[1]} deg)'
    spread = calibration.postfit.all
    mean, rms, most = (shown(1e3 * value) for value in (spread.mean, spread.rms, spread.max))
    assert repr(spread) == f"Spread({spread.count} contacts: mean {mean} mm, rms {rms} mm, max {most} mm)"
    known = calibration.workspace_uncertainty
    assert known is not None
    assert repr(known).startswith(f"WorkspaceUncertainty({shown(1e3 * known.position)} mm, {shown(np.degrees(known.angle))} deg, ")
    joint = touchcal.inspect(touchcal.Problem.from_toml(workcell / "problem.toml")).ranges[2]
    ends = f"{shown(np.degrees(joint.least))} deg to {shown(np.degrees(joint.most))} deg"
    assert repr(joint).startswith(f'JointRange("joint_a3", {ends}, ')
    tool = touchcal.Tool(touchcal.pose((0, 0, 0.12), rpy=(0, 0, np.pi / 2)), exact=True)
    assert repr(tool) == "Tool((0.0, 0.0, 120.0) mm, rotated by 90.0 deg, exact)"
    socket = touchcal.Fixture("a", touchcal.Manifold.ball_in_socket(), free=True)
    assert repr(socket) == 'Fixture("a", "ball in socket", no place, free)'


def test_all_classes_have_representations_and_none_hides_a_builtin() -> None:
    public = {name: getattr(touchcal, name) for name in touchcal.__all__}
    assert not {name for name in public if name in vars(builtins) and not name.startswith("__")}
    for value in public.values():
        if isinstance(value, type) and not issubclass(value, Exception):
            assert "__repr__" in vars(value), value
