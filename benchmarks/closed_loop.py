"""How much faster than real time an encounter in closed loop runs, on one core.

    python benchmarks/closed_loop.py [--n 20] [--profile]

A `PointRobot` greets drawn people who react to it, seen as they are: the whole (the people's minds
and bodies, thirty frames a second, and the flow that reads and answers them), and the people alone
before a robot that stands still. By process time; the fastest of several runs counts.
"""

from __future__ import annotations

import argparse
import cProfile
import os
import pstats
import time
from collections.abc import Callable

# One core; read when numpy is imported.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

import numpy as np  # noqa: E402
from recorded_people import print_table  # noqa: E402

from kendon.experiments.encounters import TRUTH, Setting, draw_person, hold  # noqa: E402
from kendon.robots import PointRobot  # noqa: E402


def with_the_flow(n: int, *, keys: bool) -> float:
    """Hold encounters; how long they last in their own time [s]."""
    setting = Setting(sensor=TRUTH, keys=keys)
    return sum(hold(number, setting)[0].duration for number in range(n))


def people_alone(n: int) -> float:
    """Let people live before a robot that does nothing; how long, in their own time [s]."""
    robot = PointRobot().appearance
    total = 0.0
    for number in range(n):
        person = draw_person(np.random.default_rng(number), 0.2, number)
        while not person.finished:
            person.live(robot)
        total += person.t
    return total


def speed(job: Callable[[], float], repeats: int) -> list[str]:
    """Seconds of life, of work, and their ratio."""
    job()
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        lived = job()
        best = min(best, time.process_time() - start)
    return [f"{lived:.0f}", f"{best:.2f}", f"{lived / best:.0f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--n", type=int, default=20, help="encounters in each run (20)")
    parser.add_argument("--repeats", type=int, default=3, help="of which the fastest counts (3)")
    parser.add_argument("--profile", action="store_true", help="show where the time goes")
    arguments = parser.parse_args()
    n, repeats = arguments.n, arguments.repeats
    print_table(
        ["encounters", "life [s]", "work [s]", "x real time"],
        [
            ["whole, gestures detected", *speed(lambda: with_the_flow(n, keys=False), repeats)],
            ["whole, gestures by keys", *speed(lambda: with_the_flow(n, keys=True), repeats)],
            ["people alone", *speed(lambda: people_alone(n), repeats)],
        ],
    )
    if arguments.profile:
        profile = cProfile.Profile()
        profile.runcall(with_the_flow, n, keys=False)
        pstats.Stats(profile).sort_stats("tottime").print_stats(25)


if __name__ == "__main__":
    main()
