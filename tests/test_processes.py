"""Work in several processes, and what an interrupt makes of it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import warnings

import pytest

from kendon.processes import each

posix = pytest.mark.skipif(os.name == "nt", reason="processes see interrupts there")


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_the_order_of_their_tasks(jobs: int) -> None:
    assert list(each(pow, [(i, 2) for i in range(7)], jobs)) == [i * i for i in range(7)]


def test_the_caller_s_warnings_are_left_as_they_were() -> None:
    filters = list(warnings.filters)
    assert len(list(each(pow, [(i, 2) for i in range(7)], 2))) == 7
    assert list(warnings.filters) == filters


def _blocked() -> bool:
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())


@posix
def test_only_the_caller_sees_an_interrupt() -> None:
    # A blocked signal stays blocked in what a process starts: also while it is starting.
    assert list(each(_blocked, [()] * 3, 2)) == [True] * 3
    assert not _blocked()


_PROGRAM = """
import os, signal, time
from kendon.processes import each

def work(number):
    os.write(1, b"at work\\n")  # in one piece, as both write
    time.sleep(600)

signal.signal(signal.SIGINT, signal.default_int_handler)  # shells have background jobs ignore it
try:
    list(each(work, ((i,) for i in range(8)), 2))
except KeyboardInterrupt:
    print("stopped")
"""


@posix
def test_an_interrupt_ends_processes_at_work_without_a_word_of_theirs() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _PROGRAM], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True,
    ) as program:  # fmt: skip
        assert program.stdout is not None
        assert program.stdout.readline() == "at work\n"
        os.killpg(program.pid, signal.SIGINT)  # as a terminal does, to all at once
        out, err = program.communicate()
    assert "stopped" in out.splitlines()
    assert err == ""
    assert program.returncode == 0
