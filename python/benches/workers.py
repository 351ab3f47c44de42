"""Seconds of a campaign on one Ray worker and on more, each of one core, beside the command-line tool's on as many threads.

    python python/benches/workers.py path/to/touchcal [WORKERS ...]

The package must be installed with `distributed`, and both be built with the same profile. Rounds alternate, so that other load falls on all
alike; Ray and its workers are begun before the clock is. Where Ray shall look at no interface but loopback:

    unshare --net sh -c 'ip link set lo up && python python/benches/workers.py path/to/touchcal 1 2'
"""

import statistics
import subprocess
import sys
import tempfile
import time

import ray

from touchcal import distributed

ROUNDS = 5
TRIALS = 400
CONTACTS = 20


def on_ray(workers: int) -> float:
    """From the call to all rows in one file."""
    ray.init("local", num_cpus=workers, include_dashboard=False, log_to_driver=False)
    try:
        with tempfile.TemporaryDirectory() as folder:
            distributed.run_campaign("mukca", 50 * workers, f"{folder}/warm", contacts=10)
            begin = time.perf_counter()
            distributed.run_campaign("mukca", TRIALS, f"{folder}/campaign", contacts=CONTACTS)
            return time.perf_counter() - begin
    finally:
        ray.shutdown()


def on_threads(command: str, threads: int) -> float:
    """From the start of a process to its end."""
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["--preset", "mukca", "--trials", TRIALS, "--contacts", CONTACTS, "--threads", threads, "--out", folder]
        begin = time.perf_counter()
        subprocess.run([command, "experiment", "campaign", *map(str, arguments)], capture_output=True, check=True)
        return time.perf_counter() - begin


def main() -> None:
    command, counts = sys.argv[1], [int(word) for word in sys.argv[2:]] or [1, 2]
    ways = {
        "Ray workers": on_ray,
        "threads": lambda threads: on_threads(command, threads),
    }
    found: dict[tuple[str, int], list[float]] = {(way, count): [] for way in ways for count in counts}
    for _ in range(ROUNDS):
        for way, count in found:
            found[way, count].append(ways[way](count))
    print(f"{TRIALS} trials         best  median  all (s)")
    for (way, count), each in found.items():
        listed = " ".join(f"{value:.1f}" for value in each)
        print(f"{count:3} {way:12}  {min(each):6.1f}  {statistics.median(each):6.1f}  {listed}")


main()
