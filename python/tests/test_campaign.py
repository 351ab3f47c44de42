"""Parts of a campaign, computed and kept: the command line's, to the bit."""

import os
import signal
import threading
import time
from pathlib import Path

import pytest

import touchcal


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> touchcal.Campaign:
    return touchcal.Campaign(tmp_path_factory.mktemp("campaign"), "mukca", 60, 7, contacts=10)


def test_parts_computed_elsewhere_are_those_of_the_command_line(
    campaign: touchcal.Campaign, run, tmp_path: Path
) -> None:
    assert (campaign.trials, campaign.seed, campaign.parts) == (60, 7, 2)
    elsewhere = touchcal.Campaign.from_files(tmp_path / "elsewhere", campaign.files, 60, 7)
    assert elsewhere.files == campaign.files
    for part, threads in ((1, 1), (0, 2)):
        assert not campaign.has(part)
        campaign.keep(part, elsewhere.compute(part, threads))
        assert campaign.has(part) and not elsewhere.has(part)
    campaign.write_rows(tmp_path / "rows.parquet")

    arguments = ["--preset", "mukca", "--trials", 60, "--contacts", 10, "--seed", 7]
    run("experiment", "campaign", *arguments, "--out", tmp_path / "command")
    folder = repr(campaign).split('"')[1]
    told = run("experiment", "merge", folder, tmp_path / "command", "--out", tmp_path, "--rows")
    assert told.count("are identical in two files and counted once") == 2


def test_another_part_is_refused(tmp_path: Path) -> None:
    one = touchcal.Campaign(tmp_path / "one", "mukca", 60, 7, contacts=10)
    other = touchcal.Campaign(tmp_path / "other", "mukca", 60, 8, contacts=10)
    content = one.compute(1)
    one.keep(1, content)
    for campaign, part, wrong in ((other, 1, content), (one, 0, content), (one, 1, content[:-50])):
        with pytest.raises(touchcal.InputError, match=f"part-00000{part}.parquet: expected a part of"):
            campaign.keep(part, wrong)
    assert one.has(1) and not one.has(0) and not other.has(1)
    with pytest.raises(touchcal.InputError, match="part-000000.parquet: expected a part of this campaign, found none"):
        one.write_rows(tmp_path / "rows.parquet")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "other"]
    assert sorted(path.name for path in (tmp_path / "one" / "parts").iterdir()) == [
        "part-000001.parquet",
        "scenario.toml",
    ]


def test_arguments_out_of_range(campaign: touchcal.Campaign, tmp_path: Path) -> None:
    with pytest.raises(touchcal.InputError, match="trials: expected a number from 1 to 100000000, found 0"):
        touchcal.Campaign(tmp_path, "mukca", 0)
    with pytest.raises(touchcal.InputError, match="part: expected a number below 2, found 2"):
        campaign.compute(2)
    with pytest.raises(touchcal.InputError, match="threads: expected a number from 1 to 1024, found 0"):
        campaign.compute(0, 0)


def test_ctrl_c_ends_a_part(tmp_path: Path) -> None:
    long_one = touchcal.Campaign(tmp_path, "paper", 50, contacts=3000)
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        long_one.compute(0, 2)
    # The trials that have begun are ended; fifty of them take far longer.
    assert time.monotonic() - begin < 30
