"""A cluster of two nodes on this machine, of which one dies: run by test_distributed.py, alone with the loopback interface.

    python two_nodes.py FOLDER

FOLDER holds folders of robots; what was seen is written there as said.json.
"""

import json
import os
import re
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

import ray
from ray.cluster_utils import Cluster
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

import touchcal
from touchcal import distributed

#: Dead nodes are noticed within seconds.
HEALTH = {"health_check_initial_delay_ms": 0, "health_check_period_ms": 500, "health_check_failure_threshold": 4}
PATIENCE_S = 60


class Seen(list[tuple[int, int]]):
    """What progress was told."""

    def __call__(self, done: int, total: int) -> None:
        self.append((done, total))


def begin_workers() -> None:
    """A process on each node, which is there before there is work, so that none is late for it."""
    nodes = [NodeAffinitySchedulingStrategy(node["NodeID"], soft=False) for node in ray.nodes()]
    ray.get([ray.remote(lambda: None).options(scheduling_strategy=node).remote() for node in nodes])


def at_work(raylet: int, task: str) -> list[int]:
    """The processes of a node that run a task of this name now."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
            title = (process / "cmdline").read_text()
        except OSError:
            continue  # ended meanwhile
        if parent == raylet and title.startswith(f"ray::{task}"):
            found.append(int(process.name))
    return found


def kill_at_work(raylet: int, task: str, with_node: bool) -> int:
    """Kills a node's processes in the middle of a task, maybe the node too, and says how many tasks that were."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        if tasks := at_work(raylet, task):
            for process in [raylet] * with_node + tasks:
                os.kill(process, signal.SIGKILL)
            return len(tasks)
        time.sleep(0.01)
    raise TimeoutError(f"the node was given no {task}")


def campaign(folder: Path, raylet: int) -> dict[str, Any]:
    """One node dies after the second part; then parts are lost, and the same call brings them back."""
    killed = []
    seen = Seen()

    def progress(done: int, total: int) -> None:
        seen(done, total)
        if done == 2:
            killed.append(kill_at_work(raylet, "_compute", with_node=True))

    arguments: dict[str, Any] = {"trials": 360, "out": folder / "campaign", "seed": 5, "contacts": 10}
    distributed.run_campaign("mukca", **arguments, progress=progress)
    alive = [node["Alive"] for node in ray.nodes()]

    parts = folder / "campaign" / "parts"
    first, damaged, lost = (parts / f"part-{number:06}.parquet" for number in (0, 3, 7))
    (folder / "campaign" / "rows.parquet").unlink()
    damaged.write_bytes(damaged.read_bytes()[:-100])
    lost.unlink()
    written = first.stat().st_mtime_ns
    again = Seen()
    distributed.run_campaign("mukca", **arguments, in_flight=1, progress=again)
    return {
        "progress": seen,
        "killed": killed,
        "alive": alive,
        "again": again,
        "untouched": first.stat().st_mtime_ns == written,
    }


def interrupted(folder: Path) -> list[str]:
    """What Ctrl-C in the middle leaves."""

    def progress(done: int, total: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    try:
        distributed.run_campaign("mukca", 250, folder / "interrupted", contacts=10, progress=progress)
    except KeyboardInterrupt:
        return sorted(path.name for path in (folder / "interrupted").rglob("*") if path.is_file())
    raise AssertionError("not interrupted")


def impossible(folder: Path) -> list[str]:
    """What is raised of a scenario without contacts: on the node, and here."""
    scenario = folder / "impossible.toml"
    scenario.write_text('preset = "mukca"\ncontacts = 10\n[recorder]\nforce_threshold_n = 1000\n')
    try:
        distributed.run_campaign(scenario, 10, folder / "impossible")
    except touchcal.SimulationError as error:
        return [type(error).__name__, str(error)]
    raise AssertionError("simulated")


def fleet(folder: Path) -> dict[str, Any]:
    """Robots of which two are broken; the same again; and again after one was repaired and the files of another have changed."""
    problems = {name: folder / name / "problem.toml" for name in ("workcell", "broken", "sockets", "nowhere")}
    problems["arm 1/2"] = problems.pop("sockets")
    out = folder / "fleet"
    first, again, changed = Seen(), Seen(), Seen()
    distributed.run_fleet(problems, out, progress=first).rename(out / "first.parquet")
    distributed.run_fleet(problems, out, progress=again).rename(out / "again.parquet")
    broken = problems["broken"]
    broken.write_text(broken.read_text().replace("joint_ofset", "joint_offset"))
    with (folder / "workcell" / "hole.csv").open("a") as log:
        log.write("\n")
    distributed.run_fleet(problems, out, progress=changed).rename(out / "changed.parquet")
    return {"first": first, "again": again, "changed": changed}


def lost(folder: Path, raylet: int) -> None:
    """A robot whose task dies, and is not begun again."""
    killer = threading.Thread(target=kill_at_work, args=(raylet, "_calibrate", False))
    killer.start()
    distributed.run_fleet({"lost": folder / "workcell" / "problem.toml"}, folder / "lost", retries=0)
    killer.join()


def guide(folder: Path) -> None:
    """What the guide shows, with fewer trials."""
    text = (Path(__file__).parents[2] / "guide" / "src" / "more-than-one-machine.md").read_text()
    [block] = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    few = block.replace("100_000", "20")
    assert few != block
    os.chdir(folder / "guide")
    exec(few, {})


def main() -> None:
    folder = Path(sys.argv[1])
    head = {"num_cpus": 1, "include_dashboard": False, "_system_config": HEALTH}
    cluster = Cluster(initialize_head=True, connect=True, head_node_args=head)
    second = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    first_raylet, second_raylet = (node.all_processes["raylet"][0].process.pid for node in (cluster.head_node, second))
    begin_workers()
    said = {
        "campaign": campaign(folder, second_raylet),
        "interrupted": interrupted(folder),
        "impossible": impossible(folder),
        "fleet": fleet(folder),
    }
    lost(folder, first_raylet)
    guide(folder)
    (folder / "said.json").write_text(json.dumps(said))
    ray.shutdown()
    cluster.shutdown()


main()
