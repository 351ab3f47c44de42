"""Progress on a terminal or in a notebook."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from touchcal._touchcal import Progress


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
