"""Problems whose declarations are false: whether the answers are honest, on simulated and on recorded contacts."""

import json

from .commands import ROOT, files, touchcal
from .report import Row, Table, number

SEED = 9000
TRIALS = {"short": 2, "long": 32}
RECORDED = {"short": ["rich"], "long": ["paper", "rich"]}
# Share of honest answers of each kind, of all, and of recorded logs over all kinds.
# Right intervals alone would have 99.9 %.
HONEST = 0.95
HONEST_OVERALL = 0.99
HONEST_RECORDED = 0.97
USEFUL = 0.95
# What is false is within what is declared or assumed, or nothing is: these answers must not be refused.
DRAWN = "hole_drawn tool_drawn shapes_drawn trends_drawn spacing_drawn all_drawn wrench_bias".split()
ANSWERED = """nothing_exact nothing hole_1mm hole_0.3mm hole_0.1mm hole_sigma_2mm tool_0.5mm tool_0.1mm clearance_wide_0.05mm
    clearance_narrow_0.05mm clearance_wide_0.02mm depth_0.05mm outline_0.2_percent encoder_drift encoder_walk""".split() + DRAWN
# Where the error is drawn from the declared standard deviation: bounds of the mean NEES, and of the
# tool's standard deviation over its error. Few answers scatter too much: in the long form only.
SHARP = {"nees": (0.3, 2.0), "sigma": 2.0}
# What is false is declared exact, by so little that contacts need not see it: no tolerance.
UNSEEN = ["hole_exact_0.1mm", "hole_exact_1mm", "tool_exact_0.5mm", "wrench_bias_exact"]
# Kinds that are tried with --free-suspects too; these answers must be useful.
FREED = "hole_exact_1mm tool_exact_0.5mm compliance_2e-5 compliance_5e-6 encoder_drift encoder_walk encoder_harmonic encoder_noise clearance_exact".split()
COMMAND = "`touchcal experiment falsified {} --seed 9000 --out DIR`"


def figure(value):
    return "–" if value is None else number(value)


def is_sharp(found):
    least, greatest = SHARP["nees"]
    nees, error, sigma = (found[key] for key in ("nees_per_parameter", "tool_error_mm", "tool_sigma_mm"))
    return nees is not None and least <= nees <= greatest and sigma <= SHARP["sigma"] * error


def row(found, form, with_tolerance, must_be_useful=ANSWERED):
    kind, trials, honest, useful = (found[key] for key in ("kind", "trials", "honest", "useful"))
    good = honest >= HONEST * trials and (kind not in must_be_useful or useful >= USEFUL * trials)
    must_be_sharp = kind in DRAWN and form == "long"
    good = good and (not must_be_sharp or is_sharp(found))
    figures = {
        "honest": f"{honest} of {trials}",
        "useful": f"{useful}",
        "NEES for each parameter": figure(found["nees_per_parameter"]),
        "tool's error (mm)": figure(found["tool_error_mm"]),
        "its standard deviation (mm)": figure(found["tool_sigma_mm"]),
    }
    if not with_tolerance or (kind in UNSEEN and kind not in must_be_useful):
        tolerance = "none"
    else:
        tolerance = f"{100 * HONEST:.0f} % honest" + (f", {100 * USEFUL:.0f} % useful" if kind in must_be_useful else "")
        if must_be_sharp:
            least, greatest = SHARP["nees"]
            tolerance += f", NEES {least} to {greatest}, standard deviation at most {SHARP['sigma']} times the error"
    return Row(f"`{kind}`: {found['description']}", figures, tolerance=tolerance, missed=tolerance != "none" and not good)


def total(kinds, name, least):
    trials, honest, useful = (sum(kind[key] for kind in kinds) for key in ("trials", "honest", "useful"))
    blank = dict.fromkeys(("NEES for each parameter", "tool's error (mm)", "its standard deviation (mm)"), "–")
    return Row(
        name,
        {"honest": f"{honest} of {trials}", "useful": f"{useful}", **blank},
        tolerance=f"{100 * least:.0f} % honest",
        missed=honest < least * trials,
    )


def battery(name, arguments, options):
    folder = files(options) / name
    touchcal("experiment", "falsified", *arguments, "--seed", SEED, "--out", folder)
    return json.loads((folder / "falsified.json").read_text())


def described(rows, reference, command):
    for line in rows:
        line.reference, line.command = reference, command
        line.why = "a wrong answer with small intervals is worse than none"
    return rows


def of_kinds(kinds):
    return [word for kind in kinds for word in ("--kind", kind)]


def on_simulated_contacts(options):
    """All kinds. Those that are tried with one excitation have twice the trials: as many answers as with two."""
    trials = TRIALS[options.form]
    found = battery("falsified", ["--trials", trials], options)
    few = [kind["kind"] for kind in found if kind["trials"] < 2 * trials]
    more = battery("falsified", [*of_kinds(few), "--trials", 2 * trials], options) if few else []
    more = {kind["kind"]: kind for kind in more}
    return [more.get(kind["kind"], kind) for kind in found]


def tables(options):
    found = on_simulated_contacts(options)
    judged = [kind for kind in found if kind["kind"] not in UNSEEN]
    rows = [*(row(kind, options.form, True) for kind in found), total(judged, "all kinds with a tolerance", HONEST_OVERALL)]
    simulated = described(rows, "truth of the simulation", COMMAND.format("--trials N"))
    kinds = of_kinds(FREED)
    found = battery("falsified_freed", ["--free-suspects", *kinds, "--trials", TRIALS[options.form]], options)
    freed = described(
        [row(kind, options.form, True, FREED) for kind in found],
        "truth of the simulation",
        COMMAND.format(" ".join(kinds) + " --free-suspects --trials N"),
    )
    folders = [f"data/mujoco_iiwa14/extrusion/{name}" for name in RECORDED[options.form]]
    arguments = [*(word for folder in folders for word in ("--logs", ROOT / folder)), "--trials", 1]
    found = [kind for kind in battery("falsified_recorded", arguments, options) if kind["kind"] not in UNSEEN]
    recorded = described(
        [*(row(kind, options.form, False) for kind in found), total(found, "all kinds", HONEST_RECORDED)],
        "truth of the MuJoCo logs",
        COMMAND.format(" ".join(f"--logs {folder}" for folder in folders) + " --trials 1"),
    )
    return [
        Table(simulated, "Simulated contacts."),
        Table(freed, "The same where what contacts contradict is estimated."),
        Table(recorded, "Recorded contacts of an independent physics engine; what the problem alone can declare false."),
    ]
