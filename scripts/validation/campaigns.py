"""Uncertainties against many simulated trials with known errors."""

import json
import math

from .commands import files, touchcal
from .report import Row, Table

SEED = 5000
TRIALS = {"short": {"paper": 60, "others": 40}, "long": {"paper": 1000, "others": 500}}
# These have tolerances.
PRESETS = ["paper", "leo_aluminium", "workcell", "mukca"]
# Scenarios that change one thing of the preset `paper`.
VARIANTS = {
    "paper_far_start": "[errors]\nstrain = 0.1\njoint_offset_deg = 10\n",
    "paper_false_contacts": "[recorder]\nspurious = 0.3\n",
    "paper_compliant_joints": (
        "[errors]\njoint_compliance_rad_per_nm = 1e-5\n[recorder]\nencoder_step_deg = 0.002\nforce_sigma_n = 0.5\n"
    ),
}
# Coefficients of friction of `workcell_friction.toml`, with a tolerance too.
FRICTION = {"short": (20, [0.25]), "long": (1000, [0.1, 0.25, 0.4])}
COVERED = (0.93, 0.97)
NEES = (0.85, 1.15)
OVER_BOUND = 1.15
COMMAND = "`touchcal experiment campaign --preset NAME --trials N --seed 5000 --out DIR`"
FRICTION_FILE = "scripts/validation/workcell_friction.toml"
FRICTION_COMMAND = COMMAND.replace("--preset NAME", f"{FRICTION_FILE} --vary friction=A,B,…")


def campaign(name, source, options):
    """A campaign's figures; parts of it that are there are not computed again."""
    trials = TRIALS[options.form]["paper" if name == "paper" else "others"]
    folder = files(options) / "campaigns" / name
    touchcal("experiment", "campaign", *source, "--trials", trials, "--seed", SEED, "--out", folder)
    return json.loads((folder / "campaign.json").read_text())


def variant(name, options):
    path = files(options) / f"{name}.toml"
    path.write_text(f'preset = "paper"\n{VARIANTS[name]}')
    return campaign(name, [path], options)


def frictions(options):
    """The campaigns of each coefficient of friction."""
    trials, values = FRICTION[options.form]
    folder = files(options) / "campaigns" / "workcell_friction"
    vary = f"friction={','.join(map(str, values))}"
    touchcal(
        "experiment", "campaign", FRICTION_FILE, "--vary", vary, "--trials", trials, "--seed", SEED, "--out", folder
    )
    return json.loads((folder / "sweep.json").read_text())["campaigns"]


def within(value, limits, chance):
    """Within the limits, or within 99 % of chance where that is wider."""
    return min(limits[0], chance[0]) <= value <= max(limits[1], chance[1])


def row(label, found, judged=True, usable=1, nees=(1, 1), over_bound=OVER_BOUND):
    """A row; `judged` against the limits of usable results, coverage, NEES and error over the bound."""
    low, high = found["nees_bounds_99"]
    least, most = found["coverage_bounds_99"][2]
    # A root mean square of n numbers errs by 1 / √(2 n); the parameters of a trial count as one.
    over_bound = max(over_bound, 1 + 2.6 / (2 * found["trials"]) ** 0.5)
    checks = {
        "trials": (f"{found['trials']}", True),
        "usable": (f"{100 * found['usable']:.1f} %", found["usable"] >= usable),
        "within 50, 90, 99 % intervals": (", ".join(f"{100 * found['coverage'][k]:.1f}" for k in (0, 1, 3)), True),
        "within 95 %, by chance": (
            f"{100 * found['coverage'][2]:.1f} %, {100 * least:.1f} to {100 * most:.1f} %",
            within(found["coverage"][2], COVERED, (least, most)),
        ),
        "NEES, by chance": (f"{found['nees']:.3f}, {low:.3f} to {high:.3f}", within(found["nees"], nees, (low, high))),
        "error over the bound": (f"{found['error_over_cramer_rao']:.2f}", found["error_over_cramer_rao"] <= over_bound),
        "offsets' error (°), median (95 %)": (
            "{:.1e} ({:.1e})".format(*found["offset_error_deg"]) if any(found["offset_error_deg"]) else "–",
            True,
        ),
        "tool elsewhere": (f"{found['tool_error_mm']:.2g} mm, {found['tool_error_deg']:.2g}°", True),
        "s for each trial": (f"{found['seconds_a_trial']:.2f}", True),
    }
    figures = {key: text if good or not judged else f"**{text}**" for key, (text, good) in checks.items()}
    return Row(label, figures, missed=judged and not all(good for _, good in checks.values()))


def tables(options):
    presets = [row(f"`{name}`", campaign(name, ["--preset", name], options)) for name in PRESETS]
    for line in presets:
        line.reference = (
            "truth of the simulation; χ² for the NEES (divided by the number of parameters); "
            "the Cramér–Rao bound for errors (root mean square)"
        )
        line.tolerance = (
            "all usable; 93 to 97 % within 95 % intervals, or within 99 % of chance where that is wider; "
            "NEES within 99 % of chance; errors up to 1.15 times the bound, or 99 % of chance where that is more"
        )
        line.why = "what a reader of error bars takes for granted"
        line.command = COMMAND
    # The Cramér–Rao bound knows nothing of friction.
    limits = {"usable": 0.99, "nees": NEES, "over_bound": math.inf}
    with_friction = [row(f"`friction` = {found['value']:g}", found, **limits) for found in frictions(options)]
    for line in with_friction:
        line.reference = "as above"
        line.tolerance = "99 % usable; within 95 % intervals as above; NEES 0.85 to 1.15, or within 99 % of chance"
        line.why = "friction and compliance together, as in a workshop, where the model is least exact"
        line.command = FRICTION_COMMAND
    variants = [row(f"`{name}`", variant(name, options), judged=False) for name in VARIANTS]
    return [
        Table(presets, "Presets."),
        Table(
            with_friction,
            "Friction, form errors, an uncertain clearance, compliant joints, and a force sensor with a bias.",
        ),
        Table(variants, "One thing changed of `paper`, without tolerances."),
    ]
