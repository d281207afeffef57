"""How much faster than real time an encounter runs, with physics and without, on one core.

    python benchmarks/physics.py

Each built-in greeting is run with a PointRobot and with Vizzy's body in MuJoCo. The body alone is
timed too: performing a gesture while it drives and looks, and at rest. All times are process
times, the fastest of several runs: what else the machine does counts little.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import sys
import time
from collections.abc import Callable
from functools import partial

from recorded_people import print_table

from kendon import Greeter, open_source
from kendon.geometry import Pose2D
from kendon.robots import make_robot
from kendon.robots.mujoco import MujocoRobot
from kendon.simulation import SCRIPTS

ROBOTS = ("point", "mujoco")


def encounter(script: str, robot: str) -> float:
    """Run one; how long it was [s]."""
    t = 0.0
    for moment in Greeter(open_source(f"simulated:{script}"), robot=make_robot(robot)).run():
        t = moment.t
    return t


def busy_body() -> float:
    """A body that does everything at once; for how long [s]."""
    robot = MujocoRobot()
    robot.go_to(Pose2D(1.5, 0.5, 0.0))
    robot.express("smile")
    robot.gesture("wave")
    for i in range(1, 41):
        robot.look_at((3.0, 1.0 - i / 40, 1.6))
        robot.update(i / 10)
    return robot.time


def resting_body() -> float:
    """A body that has nothing to do; for how long [s]."""
    robot = MujocoRobot()
    for i in range(1, 101):
        robot.update(i / 10)
    return robot.time


def fastest(run: Callable[[], float], repeats: int) -> tuple[float, float]:
    """How long it was [s], and the process time of the fastest of several runs [s]."""
    times = []
    seconds = 0.0
    for _ in range(repeats):
        start = time.process_time()
        seconds = run()
        times.append(time.process_time() - start)
    return seconds, min(times)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=7, help="of each run; the fastest counts")
    parser.add_argument("--profile", action="store_true", help="show where the time goes")
    arguments = parser.parse_args()
    if arguments.repeats < 1:
        print("--repeats is at least 1", file=sys.stderr)
        return 2
    for robot in ROBOTS:
        encounter("short", robot)  # imports and caches
    rows = []
    for script in SCRIPTS:
        row = [script]
        for robot in ROBOTS:
            seconds, spent = fastest(partial(encounter, script, robot), arguments.repeats)
            row += [f"{seconds:.1f}", f"{spent:.3f}", f"{seconds / spent:.0f}"]
        rows.append(row)
    columns = [
        f"{robot} {what}" for robot in ROBOTS for what in ("[s]", "takes [s]", "x real time")
    ]
    print_table(["encounter", *columns], rows)
    print()
    rows = []
    for name, run in (("driving, waving, looking", busy_body), ("at rest", resting_body)):
        seconds, spent = fastest(run, arguments.repeats)
        rows.append([name, f"{seconds:.1f}", f"{spent:.3f}", f"{seconds / spent:.0f}"])
    print_table(["the body alone", "[s]", "takes [s]", "x real time"], rows)
    if arguments.profile:
        profile = cProfile.Profile()
        profile.runcall(encounter, "normal", "mujoco")
        pstats.Stats(profile).sort_stats("tottime").print_stats(20)
    return 0


if __name__ == "__main__":
    sys.exit(main())
