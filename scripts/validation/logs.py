"""Estimates from the logs of an independent physics engine, against its truth."""

from .commands import test, test_command
from .report import Row, Table, number

TEST = ("--test", "recovery", "recorded_logs")
COMMAND = test_command(*TEST)
REFERENCE = "truth of the MuJoCo logs"
PROFILES = {
    "extrusion/paper": "T-slot peg, little elbow motion",
    "extrusion/rich": "T-slot peg, elbow motion",
    "square/paper": "square peg, little elbow motion",
    "square/rich": "square peg, elbow motion",
}
# Least share of true values within 95 % intervals; eight of a trial go together.
COVERED = 0.88


def tables(_options):
    reports, _ = test(*TEST)
    errors, coverage = [], []
    for profile, words in PROFILES.items():
        trials, inside, of = (reports[profile][name] for name in ("trials", "inside", "of"))
        for quantity in ("encoder offsets (°)", "strain"):
            found = reports[f"{profile}, {quantity}"]
            figures = {name: number(found[name]) for name in ("mean", "q75", "q99", "max")}
            what = f"{words}: {quantity}, {trials:.0f} {'trial' if trials == 1 else 'trials'}"
            why = "of the size that a prototype of the method reached"
            errors.append(
                Row(what, figures, REFERENCE, f"mean {number(found['limit'])}", why, COMMAND, not found["mean"] <= found["limit"])
            )
        single = trials == 1
        figures = {"true values within 95 % intervals": f"{inside:.0f} of {of:.0f}"}
        tolerance = "none" if single else f"at least {100 * COVERED:.0f} %"
        why = "one trial's go together" if single else "parts give way a little, and eight of a trial go together"
        coverage.append(Row(words, figures, REFERENCE, tolerance, why, COMMAND, not single and inside < COVERED * of))
    return [Table(errors, "Absolute errors."), Table(coverage, "Intervals.")]
