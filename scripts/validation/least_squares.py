"""Levenberg–Marquardt against NIST's certified problems."""

from .commands import test, test_command
from .report import Row, Table

COMMAND = test_command("--lib", "nist")
REFERENCE = "certified values of NIST's Statistical Reference Datasets, eleven digits"
WHY = "normal equations square the condition number: up to half of sixteen digits may be lost"


def tables(_options):
    reports, _ = test("--lib", "nist")
    rows = []
    for name in dict.fromkeys(what.split(",")[0] for what in reports):
        starts = [reports[f"{name}, start {number}"] for number in (1, 2)]
        figures = {f"digits, start {number}": f"{found['digits']:.1f}" for number, found in enumerate(starts, 1)}
        figures["of standard deviations"] = f"{max(found['deviations'] for found in starts):.1f}"
        figures["linearizations"] = ", ".join(f"{found['looks']:.0f}" for found in starts)
        limit = starts[0]["limit"]
        missed = not min(found["digits"] for found in starts) >= limit
        rows.append(Row(name, figures, REFERENCE, f"at least {limit:.0f} digits of every parameter", WHY, COMMAND, missed))
    return [Table(rows)]
