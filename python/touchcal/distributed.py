"""Campaigns and fleets on more than one machine, with Ray; ``pip install touchcal[distributed]`` brings it.

::

    from touchcal import distributed

    distributed.run_campaign("scenario.toml", 100_000, "campaign")
    problems = {path.parent.name: path for path in Path("robots").glob("*/problem.toml")}
    distributed.run_fleet(problems, "fleet")

The work goes where ``ray.init()`` leads: to a cluster (``RAY_ADDRESS``), or to the cores of this machine. touchcal must be installed on
every node. What a task leaves comes back to the caller, who alone writes, each file whole or not at all: after Ctrl-C, or if the
caller dies, the same call goes on with what is missing. Tasks that die with their node are repeated.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias, TypeVar
from urllib.parse import quote

import touchcal

__all__ = ["bar", "run_campaign", "run_fleet"]

_Path: TypeAlias = str | os.PathLike[str]
_Watch: TypeAlias = Callable[[int, int], object]
_Key = TypeVar("_Key")

_GROUP = 1000
"""Robots whose rows are in memory at a time."""


def run_campaign(
    scenario: _Path,
    trials: int,
    out: _Path,
    seed: int = 1,
    *,
    contacts: int | None = None,
    threads: int = 1,
    retries: int = 3,
    in_flight: int = 1000,
    progress: _Watch | None = None,
) -> Path:
    """Simulates and calibrates a scenario many times, as ``touchcal experiment campaign`` does: the same seeds give the same rows.

    A task is a part of fifty trials. ``out`` is a folder of the command line's too: ``touchcal experiment merge OUT --out OUT`` tells
    what the rows come to.

    Args:
        scenario: path of a scenario.toml, or the name of a preset.
        trials: how many.
        out: folder to write into; parts found there are not computed again.
        seed: of the first trial; the others count on from it.
        contacts: contacts with each fixture; default: what the scenario says.
        threads: cores for each task.
        retries: how often a task is repeated whose process or node died.
        in_flight: most tasks that Ray knows of at a time.
        progress: called with the number of parts that are done, and of all; what it raises ends the work. See `bar`.

    Returns:
        path of rows.parquet, a row a trial.

    Raises:
        FileError, InputError, SimulationError: if the scenario is not one, or cannot be simulated.
    """
    campaign = touchcal.Campaign(out, scenario, trials, seed, contacts=contacts)
    missing = {part: part for part in range(campaign.parts) if not campaign.has(part)}
    tasks = _Tasks(threads, retries, in_flight, progress, campaign.parts)
    shared = (campaign.files, trials, seed, threads)
    tasks.run(_compute, missing, shared, lambda part, task: campaign.keep(part, _result(task)))
    rows = Path(out) / "rows.parquet"
    campaign.write_rows(rows)
    return rows


def run_fleet(
    problems: Mapping[str, _Path],
    out: _Path,
    *,
    threads: int = 1,
    retries: int = 3,
    in_flight: int = 1000,
    progress: _Watch | None = None,
) -> Path:
    """Calibrates many robots, a task each.

    A robot whose files are broken, or whose task dies again and again, has a row too: its status is "failed", its message says why.

    Args:
        problems: each robot's problem.toml by the robot's name. Every node must find it, and what it refers to, at that path.
        out: folder to write into; robots found there are not calibrated again, unless they failed or their files have changed.
        threads: cores for each task.
        retries: how often a task is repeated whose process or node died.
        in_flight: most tasks that Ray knows of at a time.
        progress: called with the number of robots that are done, and of all; what it raises ends the work. See `bar`.

    Returns:
        path of fleet.parquet, a row a robot in the order of ``problems``: name, problem, status ("usable", "doubtful",
        "not_usable", "failed"), message, seconds, contacts, rms_before, rms_after (m), parameters (name, unit, value, sigma,
        identifiable), calibrated_urdf, inputs (path, sha256), version.
    """
    paths = {name: os.path.abspath(problem) for name, problem in problems.items()}
    files = {name: Path(out) / "robots" / f"{quote(name, safe=' ')}.parquet" for name in paths}

    def keep(name: str, task: Any) -> None:
        _write_rows(files[name], [[_row(name, paths[name], task)]])

    missing = {name: path for name, path in paths.items() if not _has(files[name], path)}
    tasks = _Tasks(threads, retries, in_flight, progress, len(paths))
    tasks.run(_calibrate, missing, threads, keep)
    rows = Path(out) / "fleet.parquet"
    _write_rows(rows, _read_rows(files.values()))
    return rows


@contextmanager
def bar(**options: Any) -> Iterator[_Watch]:
    """A tqdm line to give as ``progress``; needs tqdm.

    Args:
        options: of tqdm.
    """
    from tqdm.auto import tqdm

    with tqdm(**options) as line:

        def show(done: int, total: int) -> None:
            line.total = total
            line.update(done - line.n)

        yield show


@dataclass(frozen=True)
class _Tasks:
    """How tasks are run, and how many there are with those that were done before."""

    threads: int
    retries: int
    in_flight: int
    progress: _Watch | None
    total: int

    def run(
        self,
        function: Callable[[Any, Any], Any],
        arguments: Mapping[_Key, Any],
        shared: object,
        keep: Callable[[_Key, Any], None],
    ) -> None:
        """Has ``function(argument, shared)`` run for each argument; ``keep`` takes its key and its Ray object when it has ended."""
        import ray

        tell = self.progress if self.progress is not None else lambda done, total: None
        done = self.total - len(arguments)
        tell(done, self.total)
        if not arguments:
            return
        if not ray.is_initialized():
            ray.init()
        begin = ray.remote(num_cpus=self.threads, max_retries=self.retries)(function).remote
        shared = ray.put(shared)
        keys = iter(arguments)
        under_way: dict[Any, _Key] = {}
        try:
            while done < self.total:
                for key in islice(keys, self.in_flight - len(under_way)):
                    under_way[begin(arguments[key], shared)] = key
                [ended], _ = ray.wait(list(under_way))
                keep(under_way.pop(ended), ended)
                done += 1
                tell(done, self.total)
        finally:
            for task in under_way:
                ray.cancel(task, force=True)


def _result(task: Any) -> Any:
    """What a task returned; what it raised is raised here as it was there."""
    import ray

    try:
        return ray.get(task)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None


def _compute(part: int, shared: tuple[list[tuple[str, str]], int, int, int]) -> bytes:
    """A part of a campaign, on a node that has nothing but touchcal."""
    files, trials, seed, threads = shared
    with tempfile.TemporaryDirectory() as folder:
        return touchcal.Campaign.from_files(folder, files, trials, seed).compute(part, threads)


def _calibrate(path: str, threads: int) -> dict[str, Any]:
    """What a row says of a robot whose calibration ended."""
    # Read when a process begins its first calibration. Results do not depend on it.
    os.environ["RAYON_NUM_THREADS"] = str(threads)
    try:
        problem = touchcal.Problem.from_toml(path)
        found = touchcal.calibrate(problem)
        urdf = found.calibrated_urdf()
    except touchcal.Error as error:
        return {"status": "failed", "message": str(error)}
    columns = ("name", "unit", "value", "sigma", "identifiable")
    return {
        "status": found.status,
        "message": "; ".join(warning.message for warning in found.warnings),
        "seconds": found.seconds,
        "contacts": len(problem),
        "rms_before": found.prefit.all.rms,
        "rms_after": found.postfit.all.rms,
        "parameters": [{column: getattr(each, column) for column in columns} for each in found.parameters],
        "calibrated_urdf": urdf,
        # Built-in arms are no files.
        "inputs": [{"path": file, "sha256": sha256} for file, sha256 in problem.inputs if Path(file).exists()],
    }


def _row(name: str, problem: str, task: Any) -> dict[str, Any]:
    """The row of a robot whose task has ended, somehow."""
    import ray

    try:
        found = _result(task)
    except ray.exceptions.RayError as error:
        found = {"status": "failed", "message": str(error)}
    return {"name": name, "problem": problem, "version": touchcal.__version__, **found}


def _has(file: Path, problem: str) -> bool:
    """Whether a robot's row is there, and its files are still what it was computed from."""
    import pyarrow

    try:
        [[row]] = _read_rows([file])
    except (OSError, pyarrow.ArrowException):
        return False
    if row["status"] == "failed" or (row["problem"], row["version"]) != (problem, touchcal.__version__):
        return False
    return all(_sha256(each["path"]) == each["sha256"] for each in row["inputs"])


def _sha256(path: str) -> str | None:
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return None


def _read_rows(files: Iterable[Path]) -> Iterator[list[dict[str, Any]]]:
    """Rows of many files, some at a time."""
    from pyarrow import parquet

    files = iter(files)
    while some := list(islice(files, _GROUP)):
        yield [row for file in some for row in parquet.read_table(file).to_pylist()]


def _write_rows(path: Path, groups: Iterable[list[dict[str, Any]]]) -> None:
    """Rows of robots as a Parquet file, whole or not at all."""
    import pyarrow
    from pyarrow import parquet

    text, number = pyarrow.string(), pyarrow.float64()
    parameter = {"name": text, "unit": text, "value": number, "sigma": number, "identifiable": pyarrow.bool_()}
    schema = pyarrow.schema(
        {
            "name": text,
            "problem": text,
            "status": text,
            "message": text,
            "seconds": number,
            "contacts": pyarrow.int64(),
            "rms_before": number,
            "rms_after": number,
            "parameters": pyarrow.list_(pyarrow.struct(parameter)),
            "calibrated_urdf": text,
            "inputs": pyarrow.list_(pyarrow.struct({"path": text, "sha256": text})),
            "version": text,
        }
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with parquet.ParquetWriter(temporary, schema) as writer:
            for rows in groups:
                writer.write_table(pyarrow.Table.from_pylist(rows, schema))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
