"""On a cluster of two nodes, one of which dies at work: every row there once, with the bits of one machine.

Ray looks for interfaces and addresses outside, so the cluster runs in a network namespace whose sole interface is loopback.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

import touchcal

pytestmark = pytest.mark.long
pytest.importorskip("ray", reason="Ray is not installed")
parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")

#: Without rights of its own, a user may have a namespace in which they are root.
NAMESPACES = [["unshare", "--net"], ["unshare", "--net", "--map-root-user"]]
UP = "ip link set lo up && "
PATIENCE_S = 300
TRIALS = 360


def namespace() -> list[str]:
    """The command before a shell's text that runs it in a network namespace."""
    for command in NAMESPACES:
        try:
            subprocess.run([*command, "sh", "-c", UP + "true"], check=True, capture_output=True)
            return [*command, "sh", "-c"]
        except (OSError, subprocess.CalledProcessError):
            pass
    pytest.fail("no network namespace can be made here (unshare, ip)")


def misspell(problem: Path) -> None:
    problem.write_text(problem.read_text().replace('"joint_offset"', '"joint_ofset"'))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("distributed")
    begin = namespace()
    (folder / "guide").mkdir()
    (folder / "guide" / "scenario.toml").write_text('preset = "mukca"\ncontacts = 10\n')
    touchcal.simulate("mukca", 4, contacts=20).save(folder / "guide" / "robots" / "one")
    touchcal.simulate("workcell", 3, contacts=300).save(folder / "workcell")
    touchcal.simulate("mukca", 3, contacts=20).save(folder / "sockets")
    shutil.copytree(folder / "workcell", folder / "broken")
    misspell(folder / "broken" / "problem.toml")
    command = [*begin, UP + 'exec "$@"', "sh", sys.executable, Path(__file__).with_name("two_nodes.py"), folder]
    # Ray's own files: their paths must be short (107 bytes for a socket), and no other cluster be found there.
    with tempfile.TemporaryDirectory(prefix="ray", dir="/tmp") as own:
        environment = {**os.environ, "RAY_TMPDIR": own, "RAY_USAGE_STATS_ENABLED": "0", "RAY_AUTH_MODE": "disabled"}
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.fixture(scope="module")
def said(folder: Path) -> dict[str, Any]:
    told: dict[str, Any] = json.loads((folder / "said.json").read_text())
    return told


def bits(path: Path) -> dict[str, bytes]:
    """Columns of a Parquet file as bytes: of NaN too, which equals nothing."""
    table = parquet.read_table(path).combine_chunks()
    return {name: table.column(name).to_numpy().tobytes() for name in table.column_names}


def test_every_row_once_though_a_node_died_at_work(folder: Path, said: dict[str, Any], run) -> None:
    campaign = said["campaign"]
    assert campaign["progress"] == [[done, 8] for done in range(9)]
    assert sorted(campaign["alive"]) == [False, True] and campaign["killed"] == [1], campaign
    arguments = ["--preset", "mukca", "--trials", TRIALS, "--contacts", 10, "--seed", 5]
    run("experiment", "campaign", *arguments, "--out", folder / "whole", "--threads", 2)
    run("experiment", "merge", folder / "whole", "--out", folder / "whole", "--rows")
    ours, theirs = bits(folder / "campaign" / "rows.parquet"), bits(folder / "whole" / "rows.parquet")
    assert list(ours) == list(theirs)
    for name in ours:
        assert ours[name] == theirs[name], name
    rows = parquet.read_table(folder / "campaign" / "rows.parquet").to_pydict()
    assert rows["trial"] == list(range(TRIALS))
    assert rows["seed"] == list(range(5, 5 + TRIALS))
    # The command line finds the parts alike too, and takes the folder for its own.
    merged = run("experiment", "merge", folder / "campaign", folder / "whole", "--out", folder / "both")
    assert merged.count("are identical in two files and counted once") == 8
    told = json.loads(run("experiment", "campaign", *arguments, "--out", folder / "campaign", "--json"))
    assert told["trials"] == TRIALS


def test_only_what_is_missing_is_computed(said: dict[str, Any]) -> None:
    assert said["campaign"]["again"] == [[6, 8], [7, 8], [8, 8]]
    assert said["campaign"]["untouched"]


def test_an_interrupt_leaves_whole_files(folder: Path, said: dict[str, Any], run) -> None:
    part, scenario = said["interrupted"]
    assert (part[:5], scenario) == ("part-", "scenario.toml")
    table = parquet.read_table(folder / "interrupted" / "parts" / part)
    assert table.num_rows == 50


def test_what_cannot_be_simulated_is_said(said: dict[str, Any], folder: Path, run) -> None:
    with pytest.raises(run.Refusal) as refused:
        run("experiment", "campaign", folder / "impossible.toml", "--trials", 10, "--out", "x", cwd=folder)
    name, text = said["impossible"]
    assert name == "SimulationError"
    assert text.split(": ", 1)[1] == str(refused.value).split(": ", 1)[1]


def test_the_guide_runs(folder: Path) -> None:
    assert parquet.read_table(folder / "guide" / "campaign" / "rows.parquet").num_rows == 20
    assert parquet.read_table(folder / "guide" / "fleet" / "fleet.parquet")["name"].to_pylist() == ["one"]


def test_a_row_a_robot(folder: Path, said: dict[str, Any]) -> None:
    assert said["fleet"]["first"] == [[done, 4] for done in range(5)]
    rows = parquet.read_table(folder / "fleet" / "again.parquet").to_pylist()
    assert [row["name"] for row in rows] == ["workcell", "broken", "nowhere", "arm 1/2"]
    cell, broken, nowhere, sockets = rows
    problem = touchcal.Problem.from_toml(folder / "sockets" / "problem.toml")
    found = touchcal.calibrate(problem)
    assert (sockets["status"], sockets["contacts"]) == (found.status, len(problem))
    assert [(each["name"], each["value"], each["sigma"]) for each in sockets["parameters"]] == [
        (each.name, each.value, each.sigma) for each in found.parameters
    ]
    assert sockets["calibrated_urdf"] == found.calibrated_urdf()
    assert (sockets["rms_before"], sockets["rms_after"]) == (found.prefit.all.rms, found.postfit.all.rms)
    assert cell["status"] in ("usable", "doubtful", "not_usable") and cell["seconds"] > 0
    # As it was before it was repaired.
    misspell(folder / "broken" / "problem.toml")
    for row in (broken, nowhere):
        with pytest.raises(touchcal.Error) as raised:
            touchcal.Problem.from_toml(row["problem"])
        assert row["status"] == "failed" and row["parameters"] is None
        assert row["message"] == str(raised.value)


def test_a_robot_whose_task_dies_has_a_row(folder: Path) -> None:
    [row] = parquet.read_table(folder / "lost" / "fleet.parquet").to_pylist()
    assert (row["name"], row["status"], row["parameters"]) == ("lost", "failed", None)
    assert "died unexpectedly" in row["message"], row["message"]


def test_robots_are_calibrated_again_when_they_failed_or_changed(folder: Path, said: dict[str, Any]) -> None:
    assert said["fleet"]["again"] == [[2, 4], [3, 4], [4, 4]]
    assert said["fleet"]["changed"] == [[1, 4], [2, 4], [3, 4], [4, 4]]
    first, again, changed = (
        {row["name"]: row for row in parquet.read_table(folder / "fleet" / f"{name}.parquet").to_pylist()}
        for name in ("first", "again", "changed")
    )
    assert again == first
    assert changed["arm 1/2"] == first["arm 1/2"]
    assert changed["workcell"]["inputs"] != first["workcell"]["inputs"]
    assert changed["workcell"]["parameters"] == first["workcell"]["parameters"]
    assert changed["broken"]["status"] == first["workcell"]["status"]
    assert changed["broken"]["parameters"] == first["workcell"]["parameters"]
    assert changed["nowhere"]["status"] == "failed"
