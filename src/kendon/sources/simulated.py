"""The simulated person as a source: one that sees the robot and reacts to where it is."""

from __future__ import annotations

from collections.abc import Iterator

from kendon.person import PersonFrame
from kendon.robots.base import Robot
from kendon.simulation.person import SimulatedPerson
from kendon.simulation.scripts import SCRIPTS, Script, script
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
    reads = f"nothing: a built-in person; {', '.join(SCRIPTS)}"
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
    def open(cls, spec: str, options: SourceOptions) -> SimulatedSource:
        """The person of a script; the options do not matter.

        Raises:
            UnknownNameError: there is no such script.
        """
        name = spec.removeprefix(_PREFIX).removeprefix(":")
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
