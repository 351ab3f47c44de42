"""Declarations that contacts contradict, and too few contacts: whether the result is called usable."""

from .commands import test, test_command
from .report import Row, Table

NOT_USABLE = ("--test", "recovery", "not_usable")
LOAD = ("--test", "recovery", "load")
DECLARED = ["noise declared three times too small", "noise declared ten times too small", "hole declared 0.8 mm too wide on each side"]
MAY_BE_USED = {DECLARED[0]: True}


def verdict(is_usable):
    return "usable" if is_usable else "not usable"


def declared(reports):
    rows = []
    for what in DECLARED:
        found, expected = reports[what], MAY_BE_USED.get(what, False)
        figures = {"noise factor": f"{found['noise factor']:.2f}", "result": verdict(found["usable"])}
        rows.append(Row(what, figures, tolerance=verdict(expected), missed=bool(found["usable"]) != expected))
    return Table(rows, "Wrong declarations, `extrusion/rich/trial_00`.")


def free_hole(reports):
    rows = []
    for what, found in reports.items():
        if what.endswith(", hole free"):
            worst = found["worst offset error (°)"]
            figures = {"greatest error of an offset (°)": f"{worst:.2f}", "result": verdict(found["usable"])}
            missed = worst >= 0.5 and bool(found["usable"])
            rows.append(Row(f"`{what.removesuffix(', hole free')}`", figures, tolerance="not usable, or below 0.5°", missed=missed))
    return Table(rows, "Nothing known of the place of the hole.")


def few(reports):
    found = reports["few contacts"]
    figures = {name: f"{found[name]:.0f}" for name in ("trials", "usable", "wrong")}
    missed = found["wrong"] > 2 or found["usable"] < 3
    what = "150, 300 and 600 contacts of `paper`, eight seeds each"
    return Table([Row(what, figures, tolerance="at least 3 usable, at most 2 of these off by more than 5 σ", missed=missed)])


def load():
    reports, _ = test(*LOAD)
    rows = []
    for what, found in reports.items():
        if what.startswith("load, seed"):
            figures = {name: f"{found[name]:.1e}" for name in ("with", "without")}
            rows.append(Row(what.removeprefix("load, "), figures, missed=not found["without"] > 10 * found["with"]))
    for line in rows:
        line.reference = "truth of the simulation"
        line.tolerance = "ten times greater without the wrench, and then not usable"
        line.command = test_command(*LOAD)
    return Table(rows, "Joints that give way by 1e-5 rad/(N m): mean error of offsets (°) with and without the wrench.")


def tables(_options):
    reports, _ = test(*NOT_USABLE)
    found = [declared(reports), free_hole(reports), few(reports)]
    for table in found:
        for line in table.rows:
            line.command = test_command(*NOT_USABLE)
    return [*found, load()]
