"""What several tests start from: simulated logs, whose truth no estimator reads, and the command-line tool."""

import os
import signal
import subprocess
from pathlib import Path

import pytest

import touchcal

SEED = 3


@pytest.fixture(autouse=True)
def ctrl_c() -> None:
    """A shell that runs the tests in the background has them ignore it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def workcell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A peg in a hole known to 1 mm, encoders off: a folder with problem.toml, logs and truth.json."""
    folder = tmp_path_factory.mktemp("workcell")
    touchcal.simulate("workcell", SEED, contacts=1500).save(folder)
    return folder


@pytest.fixture(scope="session")
def sockets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ball in six sockets at three placements, all joint origins off."""
    folder = tmp_path_factory.mktemp("sockets")
    touchcal.simulate("mukca", SEED, contacts=60).save(folder)
    return folder


@pytest.fixture(scope="session")
def command() -> Path:
    """The command-line tool of the same checkout, which scripts/test_python builds."""
    path = Path(os.environ["TOUCHCAL_COMMAND"])
    assert path.exists(), path
    return path


class Refusal(Exception):
    """What the command-line tool says when it refuses."""


@pytest.fixture(scope="session")
def run(command: Path):
    """Runs the command-line tool; a refusal is raised with its text."""

    def run(*arguments: object, cwd: Path | None = None) -> str:
        done = subprocess.run(
            [command, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, check=False
        )
        if done.returncode not in (0, 3):
            raise Refusal(done.stderr.removeprefix("touchcal: error: ").removesuffix("\n"))
        return done.stdout

    run.Refusal = Refusal
    return run
