"""Robots, problems and logs with numbers of any magnitude: each calibration is refused, or ends in its normal time.

Some numbers of a simulated problem's files are drawn, and multiplied by a power of ten, negated, or replaced.
What a calibration may take is a multiple of what that of the unchanged problem takes.
"""

import difflib
import re
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
# Presets, their numbers of contacts, and the files whose numbers are changed.
PRESETS = {"mukca": ("20", ["problem.toml", "arm.urdf"]), "paper": ("600", ["problem.toml", "arm.urdf", "hole.csv"])}
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")
REPLACED = ["0", "-0", "1e300", "-1e300", "1e-300", "5e-324", "1e308", "3.141592653589793", "9007199254740993"]
# Most numbers changed in one trial.
MOST = 3
# Time of a calibration over that of the unchanged problem, and seconds that this may vary.
SLOWER, SECONDS = 10, 5
MOST_BYTES = 4 << 30
CODES = (0, 1, 3)


def changed(text, drawn, count):
    """The text with so many of its numbers changed."""
    places = list(NUMBER.finditer(text))
    for place in sorted(drawn.sample(places, min(count, len(places))), key=lambda place: -place.start()):
        kind = drawn.randrange(3)
        if kind == 0:
            number = drawn.choice(REPLACED)
        else:
            number = repr(float(place[0]) * 10.0 ** drawn.uniform(-12, 12) * (-1) ** kind)
        text = text[: place.start()] + number + text[place.end() :]
    return text


def difference(one, other):
    lines = difflib.unified_diff(one.splitlines(), other.splitlines(), n=0, lineterm="")
    return "\n".join(line for line in lines if not line.startswith(("---", "+++", "@@")))


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))


def calibrate(program, work, seconds):
    """Exit code, what was printed to stderr, and the time; no exit code if it took longer."""
    start = time.monotonic()
    command = [program, "calibrate", "problem.toml", "--out", "out"]
    try:
        done = subprocess.run(command, cwd=work, capture_output=True, text=True, timeout=seconds, preexec_fn=limited)
    except subprocess.TimeoutExpired:
        return None, "", seconds
    return done.returncode, done.stderr, time.monotonic() - start


def make(program, work, preset, contacts):
    """A simulated problem with the arm's URDF beside it."""
    shutil.rmtree(work, ignore_errors=True)
    subprocess.run([program, "simulate", "--preset", preset, "--contacts", contacts, "--out", work], check=True, capture_output=True)
    problem = work / "problem.toml"
    problem.write_text(problem.read_text().replace('builtin = "iiwa14"', 'urdf = "arm.urdf"', 1))
    shutil.copy(ROOT / "crates/touchcal/src/robot/builtin/iiwa14.urdf", work / "arm.urdf")


def run(program, folder, drawn, trials):
    """Number of faults in so many trials of each preset."""
    work = folder / "magnitudes"
    wrong = 0
    for preset, count in trials.items():
        contacts, files = PRESETS[preset]
        make(program, work, preset, contacts)
        originals = {name: (work / name).read_text() for name in files}
        normal = max(calibrate(program, work, 60)[2] for _ in range(3))
        slowest, refused, faults = 0.0, 0, 0
        for trial in range(count):
            for name, text in originals.items():
                (work / name).write_text(text)
            name = drawn.choice(files)
            (work / name).write_text(changed(originals[name], drawn, drawn.randint(1, MOST)))
            code, printed, seconds = calibrate(program, work, SLOWER * normal + SECONDS)
            slowest, refused = max(slowest, seconds), refused + (code == 1)
            if code not in CODES or "panicked" in printed:
                faults += 1
                lines = difference(originals[name], (work / name).read_text())
                what = f"not ended after {seconds:.1f} s" if code is None else f"exit code {code}: {printed}"
                print(f"{preset}, {name} in trial {trial}: {what}\n{lines}", file=sys.stderr)
        figures = f"{refused} refused, slowest {slowest:.1f} s, {normal:.1f} s unchanged, {faults} faults"
        print(f"numbers of any magnitude, {preset}: {count} problems, {figures}", flush=True)
        wrong += faults
    return wrong
