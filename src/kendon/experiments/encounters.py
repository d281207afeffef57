"""Random encounters in closed loop: somebody comes, the robot reads and answers, they react."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kendon.errors import ParameterError, UnknownNameError
from kendon.experiments.verdict import Verdict, judge
from kendon.geometry import Pose2D
from kendon.greeter import Encounter, Greeter
from kendon.models import DEFAULT_MODEL, load_model
from kendon.processes import each
from kendon.robots import DEFAULT_ROBOT, make_robot
from kendon.simulation.live_sensor import LiveSensor, View
from kendon.simulation.reacting import ReactingPerson
from kendon.simulation.sensors import SENSORS
from kendon.simulation.temperaments import TEMPERAMENTS, Temperament, draw_temperament
from kendon.sources.simulated import ReactingSource
from kendon.trees import GreetingTree

#: "truth" sees everybody as they are, wherever they are; the others see through the camera in the
#: robot's moving head.
TRUTH = "truth"
#: Nobody goes on for longer [s]; a safeguard.
LONGEST = 120.0


@dataclass(frozen=True)
class Setting:
    """How encounters are held.

    Raises:
        UnknownNameError: there is no such robot or sensor.
        ParameterError: the share of passers-by is none.
    """

    seed: int = 0
    robot: str = DEFAULT_ROBOT  # a name or robot file, as `kendon.robots.make_robot` takes it
    sensor: str = "clean"
    model: str = DEFAULT_MODEL
    passersby: float = 0.2
    keys: bool = False  # gestures given by hand, not detected

    def __post_init__(self) -> None:
        make_robot(self.robot)
        if self.sensor not in (TRUTH, *SENSORS):
            raise UnknownNameError("sensor", self.sensor, [TRUTH, *SENSORS])
        if not 0 <= self.passersby <= 1:
            raise ParameterError(
                f"the share of passers-by lies between 0 and 1, not {self.passersby}"
            )
        if self.seed < 0:
            raise ParameterError(f"a seed is a number from 0 on, not {self.seed}")


def draw_person(rng: np.random.Generator, passersby: float, seed: int) -> ReactingPerson:
    """Somebody in view of a robot at the origin, 3 to 8 m away, looking more or less its way."""
    kind: Temperament
    kind = TEMPERAMENTS["ignoring"] if rng.random() < passersby else draw_temperament(rng)
    away, bearing = float(rng.uniform(3.0, 8.0)), float(rng.uniform(-0.6, 0.6))
    heading = bearing + math.pi + float(rng.normal(0, 0.2))
    start = Pose2D(away * math.cos(bearing), away * math.sin(bearing), heading)
    past = float(rng.uniform(0.8, 2.5))
    return ReactingPerson(kind, start, past=past, seed=seed)


def hold(number: int, setting: Setting) -> tuple[Encounter, ReactingSource]:
    """Hold the encounter of a number; the same setting gives the same one."""
    rng = np.random.default_rng([setting.seed, number])
    person = draw_person(rng, setting.passersby, int(rng.integers(2**31)))
    sensor = None
    if setting.sensor != TRUTH:
        sensor = LiveSensor(SENSORS[setting.sensor], View(), seed=int(rng.integers(2**31)))
    source = ReactingSource(person, sensor, keys=setting.keys)
    greeter = Greeter(source, load_model(setting.model), make_robot(setting.robot), GreetingTree())
    encounter = Encounter(f"encounter {number}: {person.temperament.name}")
    for moment in greeter.run():
        encounter.add(moment)
        if moment.t > LONGEST:
            break
    return encounter, source


def hold_all(
    count: int,
    setting: Setting,
    *,
    jobs: int = 1,
    progress: Callable[[int], None] | None = None,
) -> list[Verdict]:
    """Hold encounters and judge them, in whatever number of processes to the same verdicts.

    Args:
        count: how many.
        setting: how.
        jobs: processes at work; -1 for one on each core.
        progress: called with how many are done.

    Raises:
        ParameterError: there are none to hold.
    """
    if count < 1:
        raise ParameterError(f"hold at least one encounter, not {count}")
    found: list[Verdict] = []
    for verdict in each(_verdict, ((number, setting) for number in range(count)), jobs):
        found.append(verdict)
        if progress:
            progress(len(found))
    return found


def _verdict(number: int, setting: Setting) -> Verdict:
    return judge(number, *hold(number, setting))
