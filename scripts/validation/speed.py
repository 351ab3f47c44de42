"""Times of the benches, on the machine that measured them."""

import re

from .commands import bench, bench_command
from .report import Printed, Row, Table

# Greatest times (s) by the name of the bench.
LIMITS = {
    "forward kinematics and Jacobian, 7 joints, 8 parameters": 2e-6,
    "calibration on one core/panda_3, six placements of two sockets": 0.1,
    "81,000 samples/a million training pairs on all cores": 60.0,
}
# Greatest time (s) of the slowest recorded log: the aim for a calibration with all tests on.
SLOWEST = 1.0
LINE = re.compile(r"^test (.+?) \.\.\. bench:\s+([\d,]+) ns/iter \(\+/- ([\d,]+)\)", re.MULTILINE)


def duration(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def criterion(name):
    rows = []
    for what, each, spread in LINE.findall(bench(name, "--output-format", "bencher")):
        seconds, spread = (1e-9 * float(text.replace(",", "")) for text in (each, spread))
        limit = LIMITS.get(what)
        figures = {"time": duration(seconds), "scatter": f"± {duration(spread)}"}
        tolerance = f"at most {duration(limit)}" if limit else "none"
        rows.append(Row(what, figures, tolerance=tolerance, missed=bool(limit) and seconds > limit, command=bench_command(name)))
    return Table(rows)


def recorded():
    name = "recorded_logs"
    printed = bench(name)
    slowest = float(re.search(r"^slowest: ([\d.]+) s$", printed, re.MULTILINE)[1])
    title = f"Recorded logs of 3000 contacts, nothing exact, all tests on, one core; the least of three times, at most {duration(SLOWEST)}."
    return Printed(printed, title, bench_command(name), failed=slowest > SLOWEST)


def tables(options):
    found = [criterion("speed"), recorded(), criterion("projection")]
    found.append(Printed(bench("meshes"), "Parts as meshes, 3000 simulated contacts, one core.", bench_command("meshes")))
    if options.form == "long":
        found.append(Printed(bench("scaling"), "Time and memory, processor time of one core.", bench_command("scaling")))
    return found
