"""Problems whose declarations are false: whether the answers are honest."""

import json

from .commands import files, touchcal
from .report import Row, Table, number

SEED = 9000
TRIALS = {"short": 4, "long": 32}
# Share of honest answers. Right intervals alone would have 99.9 %.
HONEST = 0.95
# Nothing is false and all is known: these answers must not be refused.
ANSWERED = ["nothing_exact"]
COMMAND = "`touchcal experiment falsified --trials N --seed 9000 --out DIR`"


def figure(value):
    return "–" if value is None else number(value)


def row(found):
    trials, honest, useful = (found[key] for key in ("trials", "honest", "useful"))
    good = honest >= HONEST * trials and (found["kind"] not in ANSWERED or useful >= HONEST * trials)
    figures = {
        "honest": f"{honest} of {trials}",
        "useful": f"{useful}",
        "NEES for each parameter": figure(found["nees_per_parameter"]),
        "tool's error (mm)": figure(found["tool_error_mm"]),
        "its standard deviation (mm)": figure(found["tool_sigma_mm"]),
    }
    return Row(f"`{found['kind']}`: {found['description']}", figures, missed=not good)


def tables(options):
    folder = files(options) / "falsified"
    touchcal("experiment", "falsified", "--trials", TRIALS[options.form], "--seed", SEED, "--out", folder)
    rows = [row(found) for found in json.loads((folder / "falsified.json").read_text())]
    for line in rows:
        line.reference = "truth of the simulation"
        line.tolerance = f"at least {100 * HONEST:.0f} % honest; `{ANSWERED[0]}` also useful"
        line.why = "a wrong answer with small intervals is worse than none"
        line.command = COMMAND
    return [Table(rows)]
