"""Other programs: cargo, touchcal and the tests, and what they print."""

import functools
import json
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = Path(os.environ.get("TOUCHCAL_DATA", ROOT.parent / "shared/data"))
MARK = "validate: "


def run(*command, input=None, may_fail=False):
    """What a command prints to its standard output."""
    environment = {**os.environ, "TOUCHCAL_DATA": str(DATA)}
    command = [str(word) for word in command]
    done = subprocess.run(command, check=False, input=input, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=environment)
    if done.returncode != 0 and not may_fail:
        raise SystemExit(f"failed: {' '.join(command)}")
    return done.stdout


@functools.cache
def revision():
    """Version of touchcal, and of the repository where it is one; `+` where files but VALIDATION.md differ from it."""
    version = next(line for line in (ROOT / "Cargo.toml").read_text().splitlines() if line.startswith("version"))
    try:
        described = run("git", "rev-parse", "--short", "HEAD", may_fail=True).strip()
        changed = run("git", "status", "--porcelain", "--", ".", ":!VALIDATION.md", may_fail=True).strip()
    except FileNotFoundError:
        described = changed = ""
    return version.split('"')[1] + (f", revision {described}{'+' if changed else ''}" if described else "")


def example(name, *arguments, input=None):
    """What an example of the library prints."""
    return run("cargo", "run", "-q", "-p", "touchcal", "--example", name, "--", *arguments, input=input)


def touchcal(*arguments):
    """What the command-line tool answers, as JSON."""
    # 3: done, but the result is not usable, which the answer says too.
    return json.loads(run("cargo", "run", "-q", "-p", "touchcal-cli", "--", *arguments, "--json"))


class Reports(dict):
    """Figures by what was measured."""

    def __missing__(self, what):
        raise SystemExit(f"no test reports `{what}`: it may have failed before")


def test(*arguments):
    """Runs tests: the figures that they report, by what was measured, and all that they print."""
    text = run("cargo", "test", "-p", "touchcal", *arguments, "--", "--nocapture", may_fail=True)
    reports = Reports()
    for line in text.splitlines():
        if MARK in line:
            what, *figures = line.split(MARK, 1)[1].split(" | ")
            reports[what] = {name: float(value) for name, value in (figure.rsplit(" ", 1) for figure in figures)}
    return reports, text


def passed(text):
    """How many tests of `text` passed and failed."""
    results = [line.split(".", 1)[1].split() for line in text.splitlines() if line.startswith("test result:")]
    # ` 3 passed; 0 failed; …`
    return sum(int(words[0]) for words in results), sum(int(words[2]) for words in results)
