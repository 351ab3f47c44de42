"""Other programs: cargo, touchcal and the tests, and what they print."""

import functools
import json
import subprocess
import sys
from pathlib import Path

from environment import TARGET

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = ROOT / "data"
MARK = "validate: "
SHOWN = ["--nocapture", "--include-ignored"]
# The parts' poses, the network and the campaigns of one revision.
FILES = TARGET / "validation"


def run(*command, input=None, may_fail=False, errors=None):
    """What a command prints to its standard output."""
    command = [str(word) for word in command]
    done = subprocess.run(command, check=False, input=input, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=ROOT)
    if done.returncode != 0 and not may_fail:
        raise SystemExit(f"failed: {' '.join(command)}")
    return done.stdout


@functools.cache
def revision():
    """Of the source: version and commit, with `+` where files differ from it."""
    version = next(line for line in (ROOT / "Cargo.toml").read_text().splitlines() if line.startswith("version"))
    try:
        described = run("git", "rev-parse", "--short", "HEAD", may_fail=True).strip()
        changed = run("git", "status", "--porcelain", "--", ".", ":!VALIDATION.md", may_fail=True).strip()
    except FileNotFoundError:
        described = changed = ""
    return version.split('"')[1] + (f", revision {described}{'+' if changed else ''}" if described else "")


def files(options):
    """The folder of files that several sections read, of this revision and form."""
    folder = FILES / "files" / "".join(c if c.isalnum() else "_" for c in f"{revision()} {options.form}")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def example(name, *arguments, input=None):
    """What an example of the library prints."""
    run("cargo", "build", "-q", "--workspace", "--example", name)
    return run(TARGET / "debug/examples" / name, *arguments, input=input)


@functools.cache
def program():
    """The command-line tool."""
    run("cargo", "build", "-q", "--workspace", "--bin", "touchcal")
    return TARGET / "debug/touchcal"


def touchcal(*arguments):
    """What the command-line tool prints."""
    command = [str(word) for word in (program(), *arguments)]
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    # 3: done, but the result is not usable, which is printed too.
    if done.returncode not in (0, 3):
        raise SystemExit(f"failed: {' '.join(command)}")
    return done.stdout


def touchcal_json(*arguments):
    return json.loads(touchcal(*arguments, "--json"))


class Reports(dict):
    """Figures by what was measured."""

    def __missing__(self, what):
        raise SystemExit(f"no test reports `{what}`: it may have failed before")


@functools.cache
def test(*arguments):
    """Runs tests, long forms too: the figures that they report, by what was measured, and all that they print."""
    text = run("cargo", "test", "--workspace", *arguments, "--", *SHOWN, may_fail=True)
    reports = Reports()
    for line in text.splitlines():
        if MARK in line:
            what, *figures = line.split(MARK, 1)[1].split(" | ")
            reports[what] = {name: float(value) for name, value in (figure.rsplit(" ", 1) for figure in figures)}
    return reports, text


def test_command(*arguments):
    return f"`cargo test --workspace {' '.join(arguments)} -- {' '.join(SHOWN)}`"


def passed(text):
    """How many tests of `text` passed and failed."""
    results = [line.split(".", 1)[1].split() for line in text.splitlines() if line.startswith("test result:")]
    # ` 3 passed; 0 failed; …`
    return sum(int(words[0]) for words in results), sum(int(words[2]) for words in results)


def bench(name, *arguments):
    """What a bench prints."""
    print(f"cargo bench -p touchcal --bench {name}", file=sys.stderr)
    return run("cargo", "bench", "-q", "-p", "touchcal", "--bench", name, "--", *arguments)


def bench_command(name):
    return f"`cargo bench -p touchcal --bench {name}`"
