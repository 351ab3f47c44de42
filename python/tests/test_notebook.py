"""The notebook runs as it stands, and is stored without outputs."""

import ast
import json
from pathlib import Path

import matplotlib
import pytest

import touchcal

matplotlib.use("Agg")

NOTEBOOK = Path(__file__).parents[1] / "examples/calibrate.ipynb"


def test_the_notebook_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    notebook = json.loads(NOTEBOOK.read_text())
    assert notebook["nbformat"] == 4
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) == 7 and not any(cell["outputs"] or cell["execution_count"] for cell in cells)
    monkeypatch.chdir(tmp_path)
    # As a kernel does: cells one after the other in one namespace, the last expression of each is shown.
    names: dict[str, object] = {"__name__": "__main__"}
    shown = []
    for cell in cells:
        *body, last = ast.parse("".join(cell["source"])).body
        is_shown = isinstance(last, ast.Expr)
        exec(compile(ast.Module(body if is_shown else [*body, last], []), NOTEBOOK.name, "exec"), names)
        if isinstance(last, ast.Expr):
            shown.append(eval(compile(ast.Expression(last.value), NOTEBOOK.name, "eval"), names))
    assert [type(value).__name__ for value in shown] == ["Problem", "Inspection", "Calibration", "DataFrame", "NoneType", "list"]
    before, after, calibration = names["before"], names["after"], names["calibration"]
    assert isinstance(before, touchcal.Evaluation) and isinstance(after, touchcal.Evaluation)
    assert isinstance(calibration, touchcal.Calibration) and calibration.usable
    # What the notebook shows: contacts of another log are nearer to touching.
    assert after.all.rms < 0.5 * before.all.rms
