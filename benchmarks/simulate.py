"""How many greetings a second `kendon simulate` makes, on one core.

    python benchmarks/simulate.py [--n 3000] [--repeats 3]

Drawing people and observing them alone, then the whole command in a process of its own with its
start, one observations CSV a greeting and the index; people as they are, and seen through various
sensors. Rates are by process time, which what else the machine does disturbs less, and by the
clock; the fastest run counts.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

# One core; read when numpy is imported, and by the command.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

from recorded_people import print_table  # noqa: E402

from kendon.simulation import Seeing, simulate  # noqa: E402


class Timing(NamedTuple):
    """How long a run took [s]."""

    process: float
    clock: float


def time_drawing(n: int, seeing: Seeing) -> Timing:
    """Drawing and observing, without files."""
    process, clock = time.process_time(), time.perf_counter()
    simulate(n, seed=1, seeing=seeing)
    return Timing(time.process_time() - process, time.perf_counter() - clock)


def time_command(n: int, seeing: Seeing) -> Timing:
    """The whole command, its start and files included."""
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder) / "set")
        command = ["simulate", "--n", str(n), "--seed", "1", "--seeing", seeing, "--out", out]
        program = [sys.executable, "-c", "from kendon.cli import main; main()"]
        before, clock = os.times(), time.perf_counter()
        subprocess.run([*program, *command], check=True, stdout=subprocess.DEVNULL)
        after, elapsed = os.times(), time.perf_counter() - clock
    process = after.children_user + after.children_system
    return Timing(process - before.children_user - before.children_system, elapsed)


def row(
    what: str, job: Callable[[int, Seeing], Timing], n: int, seeing: Seeing, repeats: int
) -> list[str]:
    runs = [job(n, seeing) for _ in range(repeats)]
    process, clock = (n / min(times) for times in zip(*runs, strict=True))
    return [f"{what}, {seeing}", f"{process:.0f}", f"{clock:.0f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--n", type=int, default=3000, help="greetings in each run (3000)")
    parser.add_argument("--repeats", type=int, default=3, help="of which the fastest counts (3)")
    arguments = parser.parse_args()
    print_table(
        ["greetings a second", "process time", "clock"],
        [
            row(what, job, arguments.n, seeing, arguments.repeats)
            for what, job in (
                ("drawing and observing", time_drawing),
                ("the whole command", time_command),
            )
            for seeing in (Seeing.CLEAN, Seeing.VARIED)
        ],
    )


if __name__ == "__main__":
    main()
