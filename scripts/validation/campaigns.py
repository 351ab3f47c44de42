"""Uncertainties against many simulated trials with known errors."""

import json

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
COVERED = (0.93, 0.97)
OVER_BOUND = 1.15
COMMAND = "`touchcal experiment campaign --preset NAME --trials N --seed 5000 --out DIR`"


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


def within(value, limits, chance):
    """Within the limits, or within 99 % of chance where that is wider."""
    return min(limits[0], chance[0]) <= value <= max(limits[1], chance[1])


def row(name, found):
    low, high = found["nees_bounds_99"]
    least, most = found["coverage_bounds_99"][2]
    # A root mean square of n numbers errs by 1 / √(2 n); the parameters of a trial count as one.
    over_bound = max(OVER_BOUND, 1 + 2.6 / (2 * found["trials"]) ** 0.5)
    checks = {
        "trials": (f"{found['trials']}", True),
        "usable": (f"{100 * found['usable']:.1f} %", found["usable"] == 1),
        "within 50, 90, 99 % intervals": (", ".join(f"{100 * found['coverage'][k]:.1f}" for k in (0, 1, 3)), True),
        "within 95 %, by chance": (
            f"{100 * found['coverage'][2]:.1f} %, {100 * least:.1f} to {100 * most:.1f} %",
            within(found["coverage"][2], COVERED, (least, most)),
        ),
        "NEES, by chance": (f"{found['nees']:.3f}, {low:.3f} to {high:.3f}", low <= found["nees"] <= high),
        "error over the bound": (f"{found['error_over_cramer_rao']:.2f}", found["error_over_cramer_rao"] <= over_bound),
        "offsets' error (°), median (95 %)": (
            "{:.1e} ({:.1e})".format(*found["offset_error_deg"]) if any(found["offset_error_deg"]) else "–",
            True,
        ),
        "tool elsewhere": (f"{found['tool_error_mm']:.2g} mm, {found['tool_error_deg']:.2g}°", True),
        "s for each trial": (f"{found['seconds_a_trial']:.2f}", True),
    }
    judged = name in PRESETS
    figures = {key: text if good or not judged else f"**{text}**" for key, (text, good) in checks.items()}
    return Row(f"`{name}`", figures, missed=judged and not all(good for _, good in checks.values()))


def tables(options):
    presets = [row(name, campaign(name, ["--preset", name], options)) for name in PRESETS]
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
    variants = [row(name, variant(name, options)) for name in VARIANTS]
    return [Table(presets, "Presets."), Table(variants, "One thing changed of `paper`, without tolerances.")]
