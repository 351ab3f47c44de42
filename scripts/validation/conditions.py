"""What changes with contacts, noise, clearance, false contacts and friction."""

import json

from .commands import files, touchcal
from .report import Row, Table

SEED = 7000
TRIALS = {"short": 4, "long": 50}
SETTINGS = {
    "contacts": [1000, 3000, 10000],
    "encoder_deg": [0.001, 0.005, 0.01],
    "outline_offset_mm": [0.25, 0.35, 0.75],
    "spurious": [0.1, 0.3, 0.5],
    "friction": [0.1, 0.3],
}


def sweep(setting, options):
    folder = files(options) / "conditions" / setting
    vary = f"{setting}={','.join(map(str, SETTINGS[setting]))}"
    source = ["--preset", "paper", "--vary", vary, "--trials", TRIALS[options.form], "--seed", SEED]
    touchcal("experiment", "campaign", *source, "--out", folder)
    return json.loads((folder / "sweep.json").read_text())["campaigns"]


def row(setting, found):
    figures = dict.fromkeys(
        ("offsets' median error, at the bound (°)", "tool elsewhere (mm)", "within 95 %", "NEES", "error over the bound"), "–"
    )
    if found["usable"] > 0:
        numbers = [
            f"{found['offset_error_deg'][0]:.1e}, {found['offset_cramer_rao_deg']:.1e}",
            f"{found['tool_error_mm']:.2g}",
            f"{100 * found['coverage'][2]:.1f} %",
            f"{found['nees']:.2f}",
            f"{found['error_over_cramer_rao']:.2f}",
        ]
        figures = dict(zip(figures, numbers))
    return Row(f"`{setting}` = {found['value']:g}", {"usable": f"{100 * found['usable']:.0f} %", **figures})


def tables(options):
    rows = [row(setting, found) for setting in SETTINGS for found in sweep(setting, options)]
    for line in rows:
        line.reference = f"truth of the simulation, {TRIALS[options.form]} trials for each row; no tolerance"
        line.command = "`touchcal experiment campaign --preset paper --vary SETTING=A,B,… --trials N --seed 7000 --out DIR`"
    return [Table(rows)]
