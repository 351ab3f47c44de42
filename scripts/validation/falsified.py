"""Problems whose declarations are false: whether the answers are honest, on simulated and on recorded contacts."""

import json

from .commands import ROOT, files, touchcal
from .report import Row, Table, number

SEED = 9000
TRIALS = {"short": 2, "long": 32}
RECORDED = {"short": ["rich"], "long": ["paper", "rich"]}
# Share of honest answers of each kind, and of recorded logs over all kinds. Right intervals alone would have 99.9 %.
HONEST = 0.95
HONEST_RECORDED = 0.97
USEFUL = 0.95
# What is false is within what is declared or assumed, or nothing is: these answers must not be refused.
ANSWERED = """nothing_exact nothing hole_drawn hole_1mm hole_0.3mm hole_0.1mm hole_sigma_2mm tool_drawn tool_0.5mm tool_0.1mm
    clearance_wide_0.05mm clearance_narrow_0.05mm clearance_wide_0.02mm depth_0.05mm outline_0.2_percent encoder_drift wrench_bias""".split()
# What is false is declared exact, by so little that contacts need not see it: no tolerance.
UNSEEN = ["hole_exact_0.1mm", "hole_exact_1mm", "tool_exact_0.5mm", "wrench_bias_exact"]
COMMAND = "`touchcal experiment falsified {} --seed 9000 --out DIR`"


def figure(value):
    return "–" if value is None else number(value)


def row(found, with_tolerance):
    kind, trials, honest, useful = (found[key] for key in ("kind", "trials", "honest", "useful"))
    good = honest >= HONEST * trials and (kind not in ANSWERED or useful >= USEFUL * trials)
    figures = {
        "honest": f"{honest} of {trials}",
        "useful": f"{useful}",
        "NEES for each parameter": figure(found["nees_per_parameter"]),
        "tool's error (mm)": figure(found["tool_error_mm"]),
        "its standard deviation (mm)": figure(found["tool_sigma_mm"]),
    }
    if kind in UNSEEN or not with_tolerance:
        tolerance = "none"
    else:
        tolerance = f"{100 * HONEST:.0f} % honest" + (f", {100 * USEFUL:.0f} % useful" if kind in ANSWERED else "")
    return Row(f"`{kind}`: {found['description']}", figures, tolerance=tolerance, missed=tolerance != "none" and not good)


def battery(name, arguments, options):
    folder = files(options) / name
    touchcal("experiment", "falsified", *arguments, "--seed", SEED, "--out", folder)
    return json.loads((folder / "falsified.json").read_text())


def described(rows, reference, command):
    for line in rows:
        line.reference, line.command = reference, command
        line.why = "a wrong answer with small intervals is worse than none"
    return rows


def tables(options):
    found = battery("falsified", ["--trials", TRIALS[options.form]], options)
    simulated = described([row(kind, True) for kind in found], "truth of the simulation", COMMAND.format("--trials N"))
    folders = [f"data/mujoco_iiwa14/extrusion/{name}" for name in RECORDED[options.form]]
    arguments = [*(word for folder in folders for word in ("--logs", ROOT / folder)), "--trials", 1]
    found = [kind for kind in battery("falsified_recorded", arguments, options) if kind["kind"] not in UNSEEN]
    trials, honest, useful = (sum(kind[key] for kind in found) for key in ("trials", "honest", "useful"))
    blank = dict.fromkeys(("NEES for each parameter", "tool's error (mm)", "its standard deviation (mm)"), "–")
    total = Row(
        "all kinds",
        {"honest": f"{honest} of {trials}", "useful": f"{useful}", **blank},
        tolerance=f"{100 * HONEST_RECORDED:.0f} % honest",
        missed=honest < HONEST_RECORDED * trials,
    )
    recorded = described(
        [*(row(kind, False) for kind in found), total],
        "truth of the MuJoCo logs",
        COMMAND.format(" ".join(f"--logs {folder}" for folder in folders) + " --trials 1"),
    )
    return [
        Table(simulated, "Simulated contacts."),
        Table(recorded, "Recorded contacts of an independent physics engine; what the problem alone can declare false."),
    ]
