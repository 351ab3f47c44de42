"""Commands that write several files, ended at each system call that changes files, and with each of these calls failed.

What must hold afterwards:

- the result in the folder is the former one, the new one, or one that readers refuse as unfinished
- files of others are as they were
- the next run succeeds, and leaves its result and nothing else
- a call that fails gives an error and exit code 1, or the command does without it and writes its whole result
"""

import hashlib
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

# System calls that change files, and the error that they fail with.
CALLS = {
    "openat": "ENOSPC",
    "write": "ENOSPC",
    "fsync": "EIO",
    "flock": "ENOLCK",
    "mkdir": "ENOSPC",
    "rename": "EROFS",
    "renameat": "EROFS",
    "renameat2": "EROFS",
    "unlink": "EROFS",
    "unlinkat": "EROFS",
    "rmdir": "EROFS",
    "ftruncate": "EIO",
}
ROOT = Path(__file__).resolve().parent.parent.parent
DONE = (0, 3)
OTHERS = {"mine.txt": "kept", ".mine": "kept"}
NEEDED = 120


@dataclass
class Command:
    """A command, one that was run before it in the same folder, and how a file of the result is read."""

    name: str
    arguments: list
    before: list = None
    # A file of the folder, and the arguments of a command that reads it.
    reader: tuple = None
    # What the next run may say after one that was finished.
    refusal: str = None
    # What a run leaves besides a result and its manifest.
    more: tuple = ()


def commands():
    calibrate = ["calibrate", "sim/problem.toml", "--out", "out"]
    of_driver = [*calibrate, "--driver-offsets", "--mcap"]
    read_urdf = ("calibrated.urdf", ["evaluate", "sim/problem.toml", "--urdf", "out/calibrated.urdf"])
    read_problem = ("problem.toml", ["inspect", "out/problem.toml"])
    simulate = ["simulate", "--preset", "mukca", "--contacts", "20", "--out", "out", "--seed"]
    campaign = ["experiment", "campaign", "--preset", "mukca", "--contacts", "20", "--trials", "2", "--out", "out", "--threads", "1"]
    falsified = ["experiment", "falsified", "--kind", "spacing_2.5_percent", "--contacts", "1000", "--trials", "1"]
    network = ["--steps", "20", "--width", "4", "--depth", "1", "--pairs", "64", "--batch", "16", "--onnx"]
    return [
        Command("calibrate", calibrate, of_driver, read_urdf),
        Command("calibrate, with files for a driver", of_driver, calibrate, read_urdf),
        Command("simulate", [*simulate, "2"], [*simulate, "1"], read_problem),
        Command("demo", ["demo", "--contacts", "1000", "--out", "out"], None, read_problem),
        Command("experiment campaign", [*campaign, "--seed", "2"], [*campaign, "--seed", "1"], more=("parts/",)),
        Command("experiment falsified", [*falsified, "--threads", "1", "--out", "out"], more=("rows/",)),
        Command("manifold", ["manifold", "--poses", "poses.csv", "--out", "out/manifold.safetensors"], more=("manifold.safetensors",)),
        Command("train", ["train", "--manifold", "manifold.safetensors", *network, "--out", "out"]),
        Command("convert", ["convert", "log.csv", "--urdf", "arm.urdf", "--out", "out/log.parquet"], more=("log.parquet",)),
        Command("new", ["new", "peg-in-hole", "--out", "out"], refusal="problem.toml exists already", more=("README.md", "problem.toml")),
    ]


class Trials:
    """Trials of one command, each in a copy of the same folder."""

    def __init__(self, program, base, command):
        self.program, self.base, self.command = program, base, command
        self.work, self.trace = base.parent / "work", base.parent / "trace"

    def run(self, arguments, tracer=()):
        return subprocess.run([*tracer, self.program, *arguments], cwd=self.work, capture_output=True, text=True, timeout=NEEDED)

    def fresh(self):
        shutil.rmtree(self.work, ignore_errors=True)
        shutil.copytree(self.base, self.work)
        out = self.work / "out"
        out.mkdir(exist_ok=True)
        for name, text in OTHERS.items():
            (out / name).write_text(text)

    def prepare(self):
        """The base gets the former result."""
        self.fresh()
        if self.command.before:
            done = self.run(self.command.before)
            assert done.returncode in DONE, done.stderr
        self.base = self.base.parent / "prepared"
        shutil.rmtree(self.base, ignore_errors=True)
        shutil.copytree(self.work, self.base)

    def calls(self):
        """The calls that change files: of each name, which of all calls of that name in its thread."""
        self.fresh()
        done = self.run(self.command.arguments, ["strace", "-f", "-o", self.trace, "-e", "trace=" + ",".join(CALLS)])
        assert done.returncode in DONE, done.stderr
        numbers, found = {}, []
        for line in self.trace.read_text().splitlines():
            call = re.match(r"(\d+) +(\w+)\(", line)
            if call is None:
                continue
            name = call[2]
            numbers[call[1], name] = numbers.get((call[1], name), 0) + 1
            if name != "openat" or "O_CREAT" in line:
                found.append((name, numbers[call[1], name]))
        # Of threads with the same numbers each has its call tried.
        return sorted(set(found))

    def interrupted(self, name, number):
        """Ends the command at this call."""
        self.fresh()
        done = self.run(self.command.arguments, self.tracer(name, number, "signal=KILL"))
        return self.faults() + ([] if done.returncode in (-signal.SIGKILL, 128 + signal.SIGKILL) else ["the call was not reached"])

    def failed(self, name, number):
        """Fails this call."""
        self.fresh()
        done = self.run(self.command.arguments, self.tracer(name, number, f"error={CALLS[name]}"))
        faults = []
        if done.returncode == 1 and not done.stderr.startswith("touchcal: error: "):
            faults.append(f"no error message: {done.stderr}")
        if done.returncode not in (1, *DONE):
            faults.append(f"exit code {done.returncode}: {done.stderr}")
        if "(INJECTED)" not in self.trace.read_text():
            faults.append("the call was not reached")
        if done.returncode in DONE:
            faults += self.not_whole()
        if "panicked" in done.stderr:
            faults.append(done.stderr)
        return faults + self.faults()

    def tracer(self, name, number, what):
        return ["strace", "-f", "-o", self.trace, "-e", f"trace={name}", "-e", f"inject={name}:{what}:when={number}"]

    def states(self):
        """Of each result that the manifest lists: finished, torn, or unfinished."""
        out = self.work / "out"
        if not (out / "touchcal.json").exists():
            return []
        results = json.loads((out / "touchcal.json").read_text())["results"].values()
        sha256 = lambda name: hashlib.sha256((out / name).read_bytes()).hexdigest() if (out / name).exists() else None
        is_whole = lambda result: all(sha256(name) == found for name, found in result["files"].items())
        return ["unfinished" if each["unfinished"] else "finished" if is_whole(each) else "torn" for each in results]

    def not_whole(self):
        """What the folder has besides a finished result, and what it lacks of that."""
        out = self.work / "out"
        faults = [f"a result that is {state}" for state in self.states() if state != "finished"]
        listed = set()
        if (out / "touchcal.json").exists():
            results = json.loads((out / "touchcal.json").read_text())["results"].values()
            listed = {"touchcal.json", *(name for each in results for name in each["files"])}
        single = {name for name in self.command.more if not name.endswith("/")}
        if not listed and not single:
            faults.append("no result")
        folders = tuple(name for name in self.command.more if name.endswith("/"))
        found = {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()} - OTHERS.keys()
        if missing := (listed | single) - found:
            faults.append(f"without {missing}")
        if more := {name for name in found - listed - single if not (folders and name.startswith(folders)) or ".touchcal-" in name}:
            faults.append(f"besides the result {more}")
        return faults

    def faults(self):
        """What is wrong with what is left, and with the next run."""
        out = self.work / "out"
        states = self.states()
        faults = ["torn"] if "torn" in states else []
        if self.command.reader and "unfinished" in states and (out / self.command.reader[0]).exists():
            listed = json.loads((out / "touchcal.json").read_text())["results"].values()
            if any(each["unfinished"] and self.command.reader[0] in each["files"] for each in listed):
                done = self.run(self.command.reader[1])
                if done.returncode != 1 or "a finished result" not in done.stderr:
                    faults.append(f"an unfinished result was read: {done.returncode} {done.stderr}")
        done = self.run(self.command.arguments)
        is_refused = self.command.refusal is not None and self.command.refusal in done.stderr
        if done.returncode not in DONE and not is_refused:
            faults.append(f"the next run: exit code {done.returncode}: {done.stderr}")
        faults += [f"after the next run: {fault}" for fault in self.not_whole()]
        if any((out / name).read_text() != text for name, text in OTHERS.items()):
            faults.append("files of others changed")
        return faults


    def at_random_times(self, count, drawn):
        """Ends the command at random times."""
        self.fresh()
        start = time.monotonic()
        self.run(self.command.arguments)
        longest = time.monotonic() - start
        faults = []
        for _ in range(count):
            self.fresh()
            process = subprocess.Popen([self.program, *self.command.arguments], cwd=self.work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(drawn.uniform(0.0, longest))
            process.kill()
            process.wait()
            faults += [f"ended at a random time: {fault}" for fault in self.faults()]
        return faults


def make_base(program, base):
    """What the commands read."""
    base.mkdir()
    run = lambda *arguments: subprocess.run([program, *arguments], cwd=base, check=True, capture_output=True)
    run("simulate", "--preset", "mukca", "--contacts", "20", "--out", "sim")
    poses = [f"{1e-3 * i},{1e-3 * (i % 5)},0,1,0,0,0" for i in range(40)]
    (base / "poses.csv").write_text("x,y,z,qw,qx,qy,qz\n" + "\n".join(poses) + "\n")
    run("manifold", "--poses", "poses.csv", "--out", "manifold.safetensors")
    joints = [f"joint_a{k}" for k in range(1, 8)]
    (base / "log.csv").write_text(",".join(joints) + "\n" + "\n".join(",".join(["0.1"] * 7) for _ in range(20)) + "\n")
    shutil.copy(ROOT / "crates/touchcal/src/robot/builtin/iiwa14.urdf", base / "arm.urdf")


def run(program, folder, drawn, every, at_random_times):
    """Number of faults. Of `every` so many calls one is tried, as `drawn`."""
    base = folder / "base"
    make_base(program, base)
    wrong = 0
    for command in commands():
        trials = Trials(program, base, command)
        trials.prepare()
        calls = [call for call in trials.calls() if drawn.randrange(every) == 0]
        faults = []
        for name, number in calls:
            faults += [f"ended at {name} {number}: {fault}" for fault in trials.interrupted(name, number)]
            faults += [f"{name} {number} failed: {fault}" for fault in trials.failed(name, number)]
        faults += trials.at_random_times(at_random_times, drawn)
        for fault in faults:
            print(f"touchcal {command.name}, {fault}", file=sys.stderr)
        tried = f"ended at {len(calls)} system calls and {at_random_times} random times, {len(calls)} calls failed"
        print(f"touchcal {command.name}: {tried}, {len(faults)} faults", flush=True)
        wrong += len(faults)
    return wrong
