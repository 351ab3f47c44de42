#!/usr/bin/env python3
"""Compares the results of two builds of touchcal, number by number.

    scripts/compare_builds.py OLD NEW [--tolerance SIGMA] [--only WORD …] [--keep FOLDER]

OLD and NEW are programs.
Both calibrate and inspect the same problems: the demonstration, recorded logs, real arms, and parts as meshes.
Differences of parameters and covariances are in standard deviations, those of other numbers are relative.
"Equal" are all bits that are compared, and the bytes of the calibrated URDF.
Exit code 1 if a difference exceeds the tolerance, or a field is in one result only.
"""

import argparse
import concurrent.futures
import functools
import json
import math
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import comparison_problems

# Fields of schema 1 and their names in schema 2.
RENAMED = {
    ("null_space", "words"): "description",
    ("warnings", "words"): "message",
}
# Names before the first dot of a text, and what they are since schema 2: blocks of parameters, kinds of warnings.
WORDS = {
    "interference": "gap_bias",
    "ambiguous": "competing_minimum",
    "compliance_needs_driver": "compliance_in_robot",
    "err_alike": "correlated_errors",
    "few_tell_walls": "few_informative_contacts",
    "held": "unobservable",
    "joint_hardly_moved": "little_joint_motion",
    "tool_aside": "origin_outside_tool",
    "tool_only_in_estimate": "tool_not_in_robot",
    "untouched": "fixture_without_contacts",
}
# Texts for people, times, and what names the program: not compared.
NOT_COMPARED = {"schema", "severity", "version", "seconds", "created", "description", "message", "words", "advice", "path", "text"}
# Fields that versions before 0.3.0 do not write: compared where both have them.
ADDED = {"effect_tests", "robot", "tip_from_tool", "is_log"}
# Components of directions below this share of a direction are rounding.
NEGLIGIBLE = 1e-9


@dataclass
class Difference:
    """Greatest differences of one run."""

    sigmas: float = 0.0
    relative: float = 0.0
    at: str = ""
    mismatches: list[str] = field(default_factory=list)

    def add(self, kind, value, path):
        if not value <= max(self.sigmas, self.relative):
            self.at = path
        setattr(self, kind, max(getattr(self, kind), math.inf if math.isnan(value) else value))


def renamed(value, parent=""):
    """A result with the names of schema 2."""
    if isinstance(value, dict):
        named = {current(RENAMED.get((parent, key), key)): renamed(entry, key) for key, entry in value.items()}
        return {key: entry for key, entry in named.items() if key not in NOT_COMPARED}
    if isinstance(value, list):
        return [renamed(entry, parent) for entry in value]
    return current(value) if isinstance(value, str) else value


def current(text):
    first, dot, rest = text.partition(".")
    return WORDS.get(first, first) + dot + rest


def relative(one, other, scale=0.0):
    """To the greater of both, or to `scale` where that is greater still."""
    return 0.0 if one == other else abs(one - other) / max(abs(one), abs(other), scale)


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def compare(old, new, found, path=""):
    """Walks both results."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            where = f"{path}.{key}"
            if key in ADDED and (key not in old or key not in new):
                continue
            if key not in old or key not in new:
                found.mismatches.append(f"{where}: only in {'OLD' if key in old else 'NEW'}")
            elif key == "parameters" and isinstance(old[key], list):
                parameters(old[key], new[key], found, where)
            elif key == "covariance":
                covariance(old[key], new[key], found, where)
            elif key == "direction":
                direction(old[key], new[key], found, where)
            elif key == "measured" and is_number(old[key]) and is_number(new[key]):
                # What was left at the end is rounding far below the threshold.
                found.add("relative", relative(old[key], new[key], old.get("threshold") or 0.0), where)
            else:
                compare(old[key], new[key], found, where)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        # Singular values: those of the null space are rounding of the greatest.
        scale = max(map(abs, old), default=0.0) if path.endswith("singular_values") else 0.0
        for index, (one, other) in enumerate(zip(old, new)):
            if scale:
                found.add("relative", relative(one, other, scale), f"{path}[{index}]")
            else:
                compare(one, other, found, f"{path}[{index}]")
    elif is_number(old) and is_number(new):
        found.add("relative", relative(old, new), path)
    elif old != new:
        found.mismatches.append(f"{path}: {old!r} and {new!r}")


def parameters(old, new, found, path):
    """By name; the estimate and its standard deviation in standard deviations."""
    by_name = [{entry["name"]: entry for entry in entries} for entries in (old, new)]
    for name in sorted(by_name[0].keys() ^ by_name[1].keys()):
        found.mismatches.append(f"{path}.{name}: only in {'OLD' if name in by_name[0] else 'NEW'}")
    for name in by_name[0].keys() & by_name[1].keys():
        one, other = (dict(entries[name]) for entries in by_name)
        sigma = one.get("sigma")
        if sigma and other.get("sigma"):
            for key in ("value", "sigma"):
                if key in one and key in other:
                    found.add("sigmas", abs(one.pop(key) - other.pop(key)) / sigma, f"{path}.{name}.{key}")
        compare(one, other, found, f"{path}.{name}")


def covariance(old, new, found, path):
    if len(old) != len(new):
        found.mismatches.append(f"{path}: {len(old)} and {len(new)} rows")
        return
    sigma = [math.sqrt(row[k]) for k, row in enumerate(old)]
    for i, (one, other) in enumerate(zip(old, new)):
        for j, (a, b) in enumerate(zip(one, other)):
            if a != b:
                found.add("sigmas", abs(a - b) / ((sigma[i] * sigma[j]) or math.nan), f"{path}[{i}][{j}]")


def direction(old, new, found, path):
    """Components, relative to the largest."""
    scale = max([abs(value) for value in [*old.values(), *new.values()]], default=1.0)
    for name in old.keys() | new.keys():
        share = abs(old.get(name, 0.0) - new.get(name, 0.0)) / scale
        if share > NEGLIGIBLE:
            found.add("relative", share, f"{path}.{name}")


def run(program, folder, *arguments):
    done = subprocess.run([program, *map(str, arguments)], cwd=folder, capture_output=True, text=True, check=False)
    # 3: done, but the result is not usable, which the result says too.
    if done.returncode not in (0, 3):
        sys.exit(f"{program} {' '.join(map(str, arguments))} in {folder} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout


@functools.cache
def knows_exact(program):
    """Whether a build has the key `exact`; without it, in 0.2.0 and before, all that has no standard deviation is exact."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.toml"
        path.write_text('[robot]\n[tool]\nkind = "ball"\nexact = true\n')
        done = subprocess.run([program, "inspect", path], capture_output=True, text=True, check=False)
    return "unknown field `exact`" not in done.stderr


def results(program, folder, problem):
    """What a build makes of a problem: results by name, and the bytes of its robot."""
    out = folder / "out"
    if problem.write is None:
        run(program, folder, "demo", "--out", out.name)
        toml = out / "problem.toml"
    else:
        toml = problem.write(folder)
        if not knows_exact(program):
            lines = toml.read_text().splitlines(keepends=True)
            toml.write_text("".join(line for line in lines if not line.startswith(("exact = ", "encoder_trend_deg = "))))
        run(program, folder, "calibrate", toml.name, "--out", out.name)
    texts = {
        "estimate.json": (out / "estimate.json").read_text(),
        "inspect": run(program, folder, "inspect", toml.relative_to(folder), "--json"),
    }
    found = {name: renamed(json.loads(text)) for name, text in texts.items()}
    return found, (out / "calibrated.urdf").read_bytes()


def compared(problem, programs, folder):
    pair = []
    for name, program in zip(("old", "new"), programs):
        place = folder / problem.name.replace("/", "_") / name
        place.mkdir(parents=True)
        pair.append(results(program, place, problem))
    (old, old_bytes), (new, new_bytes) = pair
    found = Difference()
    for name in old:
        compare(old[name], new[name], found, name)
    return problem.name, found, old == new and old_bytes == new_bytes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--tolerance", type=float, default=1e-6, help="greatest difference allowed (default: %(default)g)")
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help="problems whose names have one of these in them")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="an empty or new folder for what both wrote")
    arguments = parser.parse_args()
    programs = [path.resolve(strict=True) for path in (arguments.old, arguments.new)]
    wanted = lambda problem: not arguments.only or any(word in problem.name for word in arguments.only)
    problems = [problem for problem in comparison_problems.all_problems() if wanted(problem)]
    failed = 0
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        folder = arguments.keep or Path(temporary)
        print(f"{'problem':<44} {'σ':>9} {'relative':>9}  bits")
        for name, found, equal in pool.map(lambda problem: compared(problem, programs, folder.resolve()), problems):
            bad = found.mismatches or max(found.sigmas, found.relative) > arguments.tolerance
            failed += bool(bad)
            verdict = f"  beyond the tolerance at {found.at}" if bad and found.at else ""
            print(f"{name:<44} {found.sigmas:9.1e} {found.relative:9.1e}  {'equal' if equal else 'differ'}{verdict}", flush=True)
            for mismatch in found.mismatches[:10]:
                print(f"    {mismatch}")
            if len(found.mismatches) > 10:
                print(f"    and {len(found.mismatches) - 10} more")
    print(f"{len(problems) - failed} of {len(problems)} problems within {arguments.tolerance:g}")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
