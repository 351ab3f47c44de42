#!/usr/bin/env python3
"""Trials a second of a campaign on one thread and more, and the most memory that its process had for few trials and for many.

Usage: cargo build --release; scripts/campaign_speed.py [target/release/touchcal] [--preset NAME] [--contacts N]
"""

import argparse
import os
import subprocess
import tempfile
import time


def run(arguments, threads, trials):
    """Seconds and peak resident memory (MB) of a campaign."""
    with tempfile.TemporaryDirectory() as folder:
        command = [arguments.touchcal, "experiment", "campaign", "--preset", arguments.preset, "--out", folder]
        command += ["--threads", str(threads), "--trials", str(trials)]
        if arguments.contacts:
            command += ["--contacts", str(arguments.contacts)]
        start = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise SystemExit(process.returncode)
        return time.monotonic() - start, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("touchcal", nargs="?", default="target/release/touchcal")
    parser.add_argument("--preset", default="paper")
    parser.add_argument("--contacts", type=int)
    arguments = parser.parse_args()
    print("threads  trials  seconds  trials/s  peak MB")
    for threads, trials in [(1, 10), (1, 100), (2, 10), (2, 100)]:
        seconds, peak = run(arguments, threads, trials)
        print(f"{threads:7}  {trials:6}  {seconds:7.1f}  {trials / seconds:8.2f}  {peak:7.1f}", flush=True)


if __name__ == "__main__":
    main()
