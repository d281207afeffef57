"""The simulated person as a source: one that sees the robot and reacts to where it is."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from kendon.errors import UnknownNameError
from kendon.geometry import Pose2D
from kendon.person import PersonFrame, pressed
from kendon.phases import Phase
from kendon.robots.base import Appearance, Robot
from kendon.robots.point import PointRobot
from kendon.simulation.live_sensor import LiveSensor
from kendon.simulation.person import SimulatedPerson
from kendon.simulation.reacting import ReactingPerson
from kendon.simulation.scripts import SCRIPTS, Script, script
from kendon.simulation.temperaments import TEMPERAMENTS, temperament
from kendon.sources.base import Source, SourceOptions, register

_PREFIX = "simulated"


@register
class SimulatedSource(Source):
    """A person who plays a script, in closed loop with the robot it is attached to.

    Args:
        script: what the person does.
        keys: whether the gestures are given by hand, or left to detectors.
    """

    name = _PREFIX
    reads = f"nothing: a built-in person; {', '.join([*SCRIPTS, *TEMPERAMENTS])}"
    example = "simulated:late-wave"
    reacts = True

    def __init__(self, script: Script, *, keys: bool = True) -> None:
        self.script = script
        self.keys = keys
        self._robot: Robot | None = None

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """``simulated`` or ``simulated:NAME``."""
        return spec == _PREFIX or spec.startswith(f"{_PREFIX}:")

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> Source:
        """The person of a script or a temperament; the options do not matter.

        Raises:
            UnknownNameError: there is no such script or temperament.
        """
        name = spec.removeprefix(_PREFIX).removeprefix(":")
        if name in TEMPERAMENTS:
            return ReactingSource(ReactingPerson(temperament(name), Pose2D(6.0, 0.0, math.pi)))
        if name and name not in SCRIPTS:
            raise UnknownNameError("simulated greeting", name, [*SCRIPTS, *TEMPERAMENTS])
        return cls(script(name or next(iter(SCRIPTS))))

    def attach(self, robot: Robot) -> None:
        """Walk up to this robot, wherever it goes."""
        self._robot = robot

    def frames(self) -> Iterator[PersonFrame]:
        """The person until the script is over."""
        person = SimulatedPerson(self.script, keys=self.keys)
        while not person.finished:
            if self._robot is None:
                yield person.frame()
                person.step()
            else:
                yield person.frame(self._robot.pose, self._robot.face)
                person.step(self._robot.pose)


class ReactingSource(Source):
    """A person with a mind of their own, in closed loop with the robot it is attached to.

    Args:
        person: who.
        sensor: through what they are seen; None = as they are, wherever they are.
        keys: whether the gestures are given by hand, or left to detectors.
    """

    name = "reacting"
    reacts = True

    def __init__(
        self, person: ReactingPerson, sensor: LiveSensor | None = None, *, keys: bool = False
    ) -> None:
        self.person = person
        self.sensor = sensor
        self.keys = keys
        self.truth: list[Station] = []
        self._robot: Robot = PointRobot()

    def attach(self, robot: Robot) -> None:
        """React to this robot."""
        self._robot = robot

    def frames(self) -> Iterator[PersonFrame]:
        """The person until they have greeted, or left."""
        person = self.person
        while not person.finished:
            robot = self._robot.appearance
            lived = person.live(robot)
            self.truth.append(Station(person.t, person.phase, person.actor.place, robot))
            for frame in lived:
                seen = frame.seen_from(robot.pose)
                if self.sensor:
                    seen = self.sensor.see(seen, robot)
                yield _with_keys(seen, person.phase) if self.keys and seen.seen else seen


def _with_keys(frame: PersonFrame, phase: Phase | None) -> PersonFrame:
    dsal, csal, hdip = pressed(phase)
    return frame._replace(dsal=dsal, csal=csal, hdip=hdip)


class Station(NamedTuple):
    """What is true of a person and a robot at one instant."""

    t: float  # [s], of the person
    phase: Phase | None  # what the person is really doing; None = not greeting
    place: tuple[float, float]  # of the person in the world [m]
    robot: Appearance  # as the person could see it
