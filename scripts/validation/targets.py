"""A UR10 against a laser tracker: models chosen by hand and by the tool, beside the same fits by scipy."""

import json
import tempfile
from pathlib import Path

import numpy as np

from . import ur10
from .commands import touchcal
from .report import Row, Table

# Blocks of touchcal, and of scipy's fits.
MODELS = {
    "joint origins": (["joint_origin"], ["origin"]),
    "with compliance": (["joint_origin", "joint_compliance"], ["origin", "compliance"]),
    "and harmonics": (["joint_origin", "joint_compliance", "joint_harmonic", "joint_harmonic_2"], ["origin", "compliance", "harmonic"]),
}
# What is aimed at: the best fits of scipy in `data/ur10`.
AIM = (0.338, 0.422)
ROWS = (20, 40, 100)
DRAWS = {"short": 2, "long": 20}
PROBLEM = """\
[robot]
urdf = "{urdf}"
[tool]
kind = "point"
free = true
[[fixture]]
name = "tracker"
kind = "target"
free = true
[[contacts]]
file = "rows.csv"
fixture = "tracker"
unit = "rad"
[noise]
encoder_deg = 0
[estimate]
parameters = {parameters}
loss = "huber"
"""


def calibrated(rows, parameters, *more):
    """The arm that touchcal finds from these rows of series B, with its corrections."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lines = (ur10.FOLDER / "series_b.csv").read_text().splitlines()
        (folder / "rows.csv").write_text("\n".join([lines[0], *(lines[1 + row] for row in rows)]) + "\n")
        text = PROBLEM.format(urdf=ur10.FOLDER / "ur10.urdf", parameters=json.dumps(parameters))
        (folder / "problem.toml").write_text(text)
        touchcal("calibrate", folder / "problem.toml", "--out", folder / "out", *more)
        arm = ur10.Arm.read(folder / "out/calibrated.urdf")
        correction = folder / "out/correction.json"
        notes = json.loads((folder / "out/estimate.json").read_text())["notes"]
        chosen = next((note.removeprefix("model: ").split(";")[0] for note in notes if note.startswith("model: ")), "")
        return (arm.corrected_by(json.loads(correction.read_text())) if correction.exists() else arm), chosen


def by_hand(scores, nominal, rows):
    """All training rows, models named."""
    lines = [Row("nominal", {"touchcal": scores(nominal)[1], "scipy": ""})]
    for name, (parameters, blocks) in MODELS.items():
        found, _ = calibrated(rows, parameters)
        reference = ur10.fitted(nominal, blocks, ur10.series("b").rows(rows))
        lines.append(Row(name, {"touchcal": scores(found)[1], "scipy": scores(reference)[1]}))
    found, chosen = calibrated(rows, ["joint_origin"], "--model", "auto")
    values, text = scores(found)
    missed = any(value > aim for value, aim in zip(values, AIM))
    lines.append(Row(f"chosen by the tool: {chosen}", {"touchcal": text, "scipy": ""}, missed=missed))
    return Table(lines, f"All {len(rows)} training rows: mean distances (mm) on the rest of B, on A; the aim of the last row is {AIM[0]}, {AIM[1]}.")


def of_few_rows(scores, nominal, rows, draws):
    """Means over seeded draws of few rows."""
    series, lines = ur10.series("b"), []
    for count in ROWS:
        found = {name: [] for name in ["chosen by the tool", *MODELS]}
        for seed in range(draws):
            drawn = np.sort(np.random.default_rng([count, seed]).choice(rows, count, replace=False))
            arm, _ = calibrated(drawn, ["joint_origin"], "--model", "auto")
            found["chosen by the tool"].append(scores(arm)[0])
            for name, (_, blocks) in MODELS.items():
                found[name].append(scores(ur10.fitted(nominal, blocks, series.rows(drawn)))[0])
        means = {name: np.mean(values, axis=0) for name, values in found.items()}
        best = np.min([means[name] for name in MODELS], axis=0)
        shown = lambda values: f"{values[0]:.3f}, {values[1]:.3f}"
        figures = {("scipy, " if name in MODELS else "") + name: shown(values) for name, values in means.items()}
        lines.append(Row(f"{count} rows", figures, missed=bool((means["chosen by the tool"] > best).any())))
    return Table(lines, f"Few rows, means over {draws} seeded draws: mean distances (mm) on the rest of B, on A; the aim is the best of scipy's models.")


def tables(options):
    nominal, rows = ur10.Arm.read(ur10.FOLDER / "ur10.urdf"), ur10.training_rows()
    a, b = ur10.series("a"), ur10.series("b")
    rest = b.rows(np.setdiff1d(np.arange(len(b.q)), rows))

    def scores(arm):
        values = [ur10.mean_distance(arm, series) for series in (rest, a)]
        return values, f"{values[0]:.3f}, {values[1]:.3f}"

    return [by_hand(scores, nominal, rows), of_few_rows(scores, nominal, rows, DRAWS[options.form])]
