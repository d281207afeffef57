"""The same work on many tasks, in whatever number of processes."""

from __future__ import annotations

import contextlib
import signal
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from typing import Any, TypeVar

_Result = TypeVar("_Result")


def each(
    work: Callable[..., _Result], tasks: Iterable[tuple[Any, ...]], jobs: int | None = None
) -> Generator[_Result, None, None]:
    """What comes of each task, in their order and as soon as it is there.

    An interrupt (Ctrl-C) reaches the caller alone: processes at work are ended by the caller then,
    rather than each telling of it in its own words.

    Args:
        work: called with each task's values; it and they must be picklable for several processes.
        tasks: the values.
        jobs: processes at work; 1 for this one, -1 for one on each core, None for what
            `joblib.parallel_config` says.
    """
    if jobs == 1:
        yield from (work(*task) for task in tasks)
        return
    from joblib import Parallel, delayed  # half a second: not for those who need none

    with _uninterruptible():
        results = Parallel(n_jobs=jobs, return_as="generator")(
            delayed(work)(*task) for task in tasks
        )
    try:
        for result in results:  # noqa: UP028 - "from" would close it before the filter is set
            yield result
    finally:
        with warnings.catch_warnings():
            # Whoever stops early, by an interrupt or otherwise, means to.
            warnings.filterwarnings("ignore", r"\d+ tasks (which|have)", UserWarning, "joblib")
            results.close()


@contextlib.contextmanager
def _uninterruptible() -> Iterator[None]:
    """Processes and threads started meanwhile never see an interrupt, except on Windows."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    # Started on the way, it would lift the block in Python 3.11.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
