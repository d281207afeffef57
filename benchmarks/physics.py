"""How much faster than real time an encounter runs, with physics and without, on one core.

    python benchmarks/physics.py [--profile] [--out docs/speed.md]

Each built-in greeting is run with a PointRobot and with Vizzy's body in MuJoCo. The body alone is
timed too: performing a gesture while it drives and looks, and at rest. All times are process
times, the fastest of several runs: what else the machine does counts little. --profile adds where
the time goes, part by part of the flow; --out writes the tables as Markdown.
"""

from __future__ import annotations

import argparse
import cProfile
import math
import pstats
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from recorded_people import print_table

from kendon import Greeter, open_source
from kendon.geometry import Pose2D
from kendon.robots import make_robot
from kendon.robots.mujoco import MujocoRobot
from kendon.simulation import SCRIPTS

ROBOTS = ("point", "mujoco")
#: A person who reacts to the robot, and whose gestures are left to the detectors.
REACTING = "eager"
INTRODUCTION = """\
# How fast encounters run

One core, process times, the fastest of several runs; `python benchmarks/physics.py --profile --out
docs/speed.md` writes this page. In the scripted encounters the gestures are given by hand, as with
the thesis's keys; the reacting person's are detected. Shares are with what a part calls, so the
body is part of the person; the profiler itself weighs on parts that make many small calls. Process
times still depend on what else keeps the processor and its caches busy: the last line of the second
table, some 40 ms where nothing else runs, tells by how much."""


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


def additions() -> float:
    """A million additions in plain Python: how fast this machine is, at this moment."""
    total = 0.0
    for i in range(1_000_000):
        total += i
    return total


def fastest(runs: Mapping[str, Callable[[], float]], rounds: int) -> dict[str, list[str]]:
    """How long each run was [s], the process time of its fastest [ms], and one over the other.

    They take turns, so that a while in which the machine is slow meets all of them, not one.
    """
    seconds = dict.fromkeys(runs, 0.0)
    least = dict.fromkeys(runs, math.inf)
    for _ in range(rounds):
        for name, run in runs.items():
            start = time.process_time()
            seconds[name] = run()
            least[name] = min(least[name], time.process_time() - start)
    return {
        name: [f"{seconds[name]:.1f}", f"{1000 * spent:.0f}", f"{seconds[name] / spent:.0f}"]
        for name, spent in least.items()
    }


#: The parts of the flow, by the functions that begin them, those of a whole before its parts.
PARTS = (
    ("the person: walk, look, body", ("simulated.py", "frames")),
    ("of it, the joints of the body", ("motion.py", "move_now")),
    ("taking frames in: gaze, place", ("greeter.py", "_take_in")),
    ("observations: medians, speed, gestures", ("sampler.py", "_close")),
    ("the belief", ("greeting.py", "step")),
    ("the behaviour tree", ("tree.py", "tick")),
    ("the robot", ("base.py", "update")),
    ("building tree, model, robot", ("greeter.py", "__init__")),
)


def shares(source: str, robot: str, repeats: int = 4) -> list[float]:
    """The share of each of `PARTS` in an encounter, with what it calls [%]."""
    profile = cProfile.Profile(time.process_time)
    for _ in range(repeats):
        profile.runcall(encounter, source, robot)
    found = pstats.Stats(profile)
    times: dict[tuple[str, str], float] = {}
    for (file, _, name), (_, _, _, spent, _) in found.stats.items():  # type: ignore[attr-defined]
        key = (file.rpartition("/")[2], name)
        times[key] = max(times.get(key, 0.0), spent)
    whole = times["physics.py", "encounter"]
    return [100 * times.get(key, 0.0) / whole for _, key in PARTS]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=25, help="of each run; the fastest counts")
    parser.add_argument("--profile", action="store_true", help="show where the time goes")
    parser.add_argument("--out", type=Path, help="write the tables into this Markdown file")
    arguments = parser.parse_args()
    if arguments.repeats < 1:
        print("--repeats is at least 1", file=sys.stderr)
        return 2
    for robot in ROBOTS:
        encounter("short", robot)  # imports and caches
    scripts = (*SCRIPTS, REACTING)
    found = fastest(
        {
            **{
                f"{script}, {robot}": partial(encounter, script, robot)
                for script in scripts
                for robot in ROBOTS
            },
            "driving, waving, looking": busy_body,
            "at rest": resting_body,
            "a million additions in Python": additions,
        },
        arguments.repeats,
    )
    columns = [
        f"{robot} {what}" for robot in ROBOTS for what in ("[s]", "takes [ms]", "x real time")
    ]
    rows = [
        [script, *(cell for robot in ROBOTS for cell in found.pop(f"{script}, {robot}"))]
        for script in scripts
    ]
    tables = [(["encounter", *columns], rows)]
    rows = [[name, *cells] for name, cells in found.items()]
    rows[-1][1], rows[-1][3] = "", ""  # additions take no time of any world
    tables.append((["the body alone, and the machine", "[s]", "takes [ms]", "x real time"], rows))
    if arguments.profile:
        which = [("normal", "point"), (REACTING, "point"), ("normal", "mujoco")]
        parts = [shares(source, robot) for source, robot in which]
        rows = [
            [name, *(f"{share[k]:.0f}" for share in parts)] for k, (name, _) in enumerate(PARTS)
        ]
        tables.append((["share of the time [%]", *map(", ".join, which)], rows))
    for header, rows in tables:
        print_table(header, rows)
        print()
    if arguments.out:
        text = "\n\n".join(markdown(header, rows) for header, rows in tables)
        arguments.out.write_text(f"{INTRODUCTION}\n\n{text}\n", encoding="utf-8")
    return 0


def markdown(header: list[str], rows: list[list[str]]) -> str:
    """A table as Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


if __name__ == "__main__":
    sys.exit(main())
