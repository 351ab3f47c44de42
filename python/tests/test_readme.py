"""The Python programs of the README and of the guide's page run as they stand."""

import re
import shutil
from pathlib import Path

import matplotlib
import pytest

import touchcal

matplotlib.use("Agg")

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "guide/src/from-python.md"]
BLOCKS = [
    block
    for page in PAGES
    for block in re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
]


def frames() -> list[object]:
    """Logs of two sockets in degrees, with another name of the first joint."""
    simulated = touchcal.simulate("mukca", 1, contacts=30)
    tables = [simulated.to_pandas(f"front/{n}").rename(columns={"joint_a1": "J1"}) for n in (0, 1)]
    turning = ["J1", *(f"joint_a{k}" for k in range(2, 8))]
    return [table.assign(**{name: table[name] * 180 / 3.141592653589793 for name in turning}) for table in tables]


def test_the_readme_runs(workcell: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("problem.toml", "hole.csv"):
        shutil.copy(workcell / name, tmp_path)
    shutil.copy(workcell / "problem.toml", tmp_path / "other.toml")
    (tmp_path / "robot.urdf").write_text(touchcal.Robot.from_urdf("iiwa14").urdf)
    monkeypatch.chdir(tmp_path)
    log = touchcal.simulate("workcell", 1, contacts=100).log("hole")
    names: dict[str, object] = {"q": log["q"], "wrench": log["wrench"], "frames": frames()}
    assert len(BLOCKS) == 10
    for block in BLOCKS:
        exec(block, names)
    assert (tmp_path / "out" / "report.html").exists()
    assert touchcal.inspect(names["in_sockets"]).rank > 10  # type: ignore[arg-type]
    assert len(names["problem"]) == 100  # type: ignore[arg-type]
    assert (tmp_path / "calibration.png").exists()
    assert len(names["calibrations"]) == 4  # type: ignore[arg-type]
