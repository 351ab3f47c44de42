"""Progress on a terminal or in a notebook."""

from __future__ import annotations

from contextlib import contextmanager

from touchcal._touchcal import Progress

# What types alone need takes longer to import than all else.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any


@contextmanager
def bar(**options: Any) -> Iterator[Callable[[Progress], None]]:
    """A tqdm line to give as ``progress``; needs tqdm.

    ::

        with touchcal.bar() as progress:
            calibration = touchcal.calibrate(problem, progress)

    Args:
        options: of tqdm.
    """
    from tqdm.auto import tqdm

    with tqdm(**{"unit": " steps", **options}) as line:

        def show(progress: Progress) -> None:
            line.set_postfix_str(f"{progress.stage}, cost {progress.cost:.4e}", refresh=False)
            line.update()

        yield show
