"""What Python costs: importing, and calibrating from files to files beside the command-line tool; and the size of the wheel.

    python python/benches/overhead.py path/to/touchcal [touchcal.whl]

The package must be installed, and both be built with the same profile. Rounds alternate. The solve is the `seconds` of estimate.json; the whole is
from the start of a process to its end: reading, solving, scoring the nominal arm, writing the three files.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import touchcal

ROUNDS = 15
IMPORT = "import time; begin = time.perf_counter(); import touchcal; print(time.perf_counter() - begin)"
CALIBRATE = """
import sys, touchcal
steps = []
touchcal.calibrate(touchcal.Problem.from_toml(sys.argv[1]), steps.append).save(sys.argv[2])
"""


def seconds(command: list[object], out: Path) -> tuple[float, float]:
    """Of the solve, and of the whole process."""
    begin = time.perf_counter()
    subprocess.run(list(map(str, command)), capture_output=True, check=True)
    whole = time.perf_counter() - begin
    return json.loads((out / "estimate.json").read_text())["seconds"], whole


def imported() -> float:
    """Seconds that `import touchcal` takes in a new interpreter."""
    done = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True)
    return float(done.stdout)


imports = [imported() for _ in range(ROUNDS)]
print(f"import: median {1e3 * statistics.median(imports):.1f} ms, longest {1e3 * max(imports):.1f} ms")

with tempfile.TemporaryDirectory() as folder:
    touchcal.simulate("paper", 1, contacts=3000).save(folder)
    problem, out = Path(folder) / "problem.toml", Path(folder) / "out"
    tool, python, empty = [], [], []
    for _ in range(ROUNDS):
        tool.append(seconds([sys.argv[1], "calibrate", problem, "--out", out], out))
        python.append(seconds([sys.executable, "-c", CALIBRATE, problem, out], out))
        empty.append(seconds([sys.executable, "-c", "pass"], out)[1])

solve, whole = (statistics.median(column) for column in zip(*tool, strict=True))
print(f"calibrate, 3000 contacts, medians of {ROUNDS}: tool {1e3 * solve:.1f} ms, its whole process {1e3 * whole:.1f} ms")
solve_over = statistics.median(mine[0] - its[0] for mine, its in zip(python, tool, strict=True))
whole_over = statistics.median(mine[1] - its[1] for mine, its in zip(python, tool, strict=True))
print(f"  Python's solve takes {1e3 * solve_over:+.1f} ms ({100 * solve_over / solve:+.1f} % of the solve)")
start = statistics.median(empty)
print(f"  Python's whole process takes {1e3 * whole_over:+.1f} ms, {1e3 * start:.1f} ms of which an interpreter that does nothing takes")
print(f"  the rest is {100 * (whole_over - start) / solve:+.1f} % of the solve")
if len(sys.argv) > 2:
    print(f"wheel: {Path(sys.argv[2]).stat().st_size / 1e6:.1f} MB")
