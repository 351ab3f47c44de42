#!/usr/bin/env python3
"""Python environments with pinned packages, below target/environments.

    scripts/environment.py NAME REQUIREMENTS      # makes or updates one, and prints its folder

Scripts that need packages call `enter` before they import them.
"""

import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()


def folder_of(name):
    return TARGET / "environments" / f"{name}-{sys.version_info.major}.{sys.version_info.minor}"


def prepare(name, requirements):
    """The folder of an environment that has these packages."""
    folder = folder_of(name)
    if not (folder / "bin/pip").exists():
        venv.create(folder, with_pip=True, clear=True)
    pip = [folder / "bin/python", "-m", "pip", "--quiet", "--disable-pip-version-check", "install"]
    subprocess.run([*pip, "--requirement", requirements], check=True, stdout=sys.stderr)
    return folder


def enter(name):
    """Continues the running script in the environment of scripts/requirements/NAME.txt."""
    if Path(sys.prefix) == folder_of(name):
        return
    python = prepare(name, ROOT / f"scripts/requirements/{name}.txt") / "bin/python"
    os.execv(python, [python, "-B", *sys.argv])


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    print(prepare(sys.argv[1], sys.argv[2]))
