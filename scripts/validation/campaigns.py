"""Uncertainties against many simulated trials, of which the truth is known."""

import json

from .commands import touchcal
from .report import Row, Table

# These have tolerances, and are run where they are missing; any other campaign of the folder is shown too.
PRESETS = ["paper", "leo_aluminium", "workcell", "mukca"]
SEED = 5000
CONVERGED = 1.0
COVERED = (0.93, 0.97)
OVER_BOUND = 1.15
COMMAND = "`touchcal experiment campaign --preset NAME --trials N --seed SEED --out DIR/NAME`"


def row(name, found):
    low, high = found["nees_bounds_99"]
    checks = {
        "trials": (f"{found['trials']}", True),
        "converged": (f"{100 * found['converged']:.1f} %", found["converged"] >= CONVERGED),
        "within 50, 90, 99 % intervals": (", ".join(f"{100 * found['coverage'][k]:.1f}" for k in (0, 1, 3)), True),
        "within 95 %": (f"{100 * found['coverage'][2]:.1f} %", COVERED[0] <= found["coverage"][2] <= COVERED[1]),
        "NEES, by chance": (f"{found['nees']:.3f}, {low:.3f} to {high:.3f}", low <= found["nees"] <= high),
        "error over the bound": (f"{found['error_over_cramer_rao']:.2f}", found["error_over_cramer_rao"] <= OVER_BOUND),
        "offsets' error (°), median (95 %)": (
            "{:.1e} ({:.1e})".format(*found["offset_error_deg"]) if any(found["offset_error_deg"]) else "–",
            True,
        ),
        "tool elsewhere": (f"{found['tool_error_mm']:.2g} mm, {found['tool_error_deg']:.2g}°", True),
    }
    judged = name in PRESETS
    figures = {key: text if good or not judged else f"**{text}**" for key, (text, good) in checks.items()}
    return Row(f"`{name}`", figures, "", "", "", "", judged and not all(good for _, good in checks.values()))


def tables(options):
    folder = options.campaigns.resolve()
    for name in PRESETS:
        if not (folder / name / "campaign.json").exists():
            touchcal(
                "experiment", "campaign", "--preset", name, "--trials", options.trials, "--seed", SEED, "--out", folder / name
            )
    others = sorted(path.parent.name for path in folder.glob("*/campaign.json") if path.parent.name not in PRESETS)
    table = Table([row(name, json.loads((folder / name / "campaign.json").read_text())) for name in [*PRESETS, *others]])
    for line in table.rows:
        line.reference = "truth of the simulation; χ² for the NEES (over the number of parameters); the Cramér–Rao bound for errors (root mean square)"
        line.tolerance = "of the presets: all converged, 93 to 97 % within 95 % intervals, NEES within 99 % of chance, errors up to 1.15 times the bound"
        line.why = "what a reader of error bars takes for granted, and what hundreds of trials can tell"
        line.command = COMMAND
    return [table]
