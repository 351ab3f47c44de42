"""Trials a second of a campaign on one Ray worker and on more, each of one core.

    python python/benches/workers.py [WORKERS ...]

The package must be installed with `distributed`. Rounds alternate; workers are begun before the clock is. Where Ray shall look at no interface but loopback:

    unshare --net sh -c 'ip link set lo up && python python/benches/workers.py 1 2'
"""

import statistics
import sys
import tempfile
import time

import ray

from touchcal import distributed

ROUNDS = 3
TRIALS = 600
CONTACTS = 40


def seconds(workers: int) -> float:
    """Of a campaign, from the call to all rows in one file."""
    ray.init("local", num_cpus=workers, include_dashboard=False, log_to_driver=False)
    try:
        with tempfile.TemporaryDirectory() as folder:
            distributed.run_campaign("mukca", 50 * workers, f"{folder}/warm", contacts=10)
            begin = time.perf_counter()
            distributed.run_campaign("mukca", TRIALS, f"{folder}/campaign", contacts=CONTACTS)
            return time.perf_counter() - begin
    finally:
        ray.shutdown()


def main() -> None:
    counts = [int(word) for word in sys.argv[1:]] or [1, 2]
    found: dict[int, list[float]] = {workers: [] for workers in counts}
    for _ in range(ROUNDS):
        for workers in counts:
            found[workers].append(seconds(workers))
    print("workers  seconds: median (all)        trials/s  times the first")
    first = statistics.median(found[counts[0]])
    for workers, each in found.items():
        median = statistics.median(each)
        listed = ", ".join(f"{value:.1f}" for value in each)
        print(f"{workers:7}  {median:7.1f} ({listed})  {TRIALS / median:8.1f}  {first / median:5.2f}")


main()
