"""What simulated people do, act by act.

The timings, distances, looks and smiles follow Kendon as the thesis reads him (2.1, 3.4); the
gestures are switched on and off with the acts, as the thesis's keys were (3.3.5).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from kendon.errors import ParameterError, UnknownNameError
from kendon.phases import Phase
from kendon.simulation.movements import MOVEMENTS

#: A medium-to-slow walk (thesis 3.4) [m/s].
WALKING_SPEED = 1.2


#: What people do unless told otherwise.
_USUAL = {Phase.DS: "wave", Phase.HD: "dip", Phase.CS: "handshake"}


@dataclass(frozen=True)
class Act:
    """One stretch of a greeting: a phase that lasts for a time or down to a distance.

    Raises:
        ParameterError: neither or both of `seconds` and `until_distance` are given, or a value
            is out of range.
        UnknownNameError: there is no such movement.
    """

    phase: Phase
    seconds: float = math.nan  # [s], how long it lasts
    until_distance: float = math.nan  # [m] to the robot, when it ends
    walking: bool = False
    gaze: float = 1.0  # [1], the gaze feature the head's direction makes (3.8)
    smile: float = 1.0  # [0-5]
    looks_down: bool = False  # away from the robot's face downward instead of to the side
    movement: str | None = None  # what the body does; None = the phase's usual, "" = nothing

    def __post_init__(self) -> None:
        if self.movement and self.movement not in MOVEMENTS:
            raise UnknownNameError("movement", self.movement, MOVEMENTS)
        by_time, by_place = math.isfinite(self.seconds), math.isfinite(self.until_distance)
        if by_time == by_place:
            raise ParameterError("an act ends after a time or at a distance: give one of the two")
        if (by_time and self.seconds <= 0) or (by_place and self.until_distance <= 0):
            raise ParameterError("an act's time or distance must be positive")
        if by_place and not self.walking:
            raise ParameterError("an act that ends at a distance needs a person who walks")
        if not 0 <= self.gaze <= 1 / math.tan(math.radians(30)) or not 0 <= self.smile <= 5:
            raise ParameterError(
                f"an act's gaze lies between 0 and 1.73, its smile between 0 and 5;"
                f" not {self.gaze}, {self.smile}"
            )

    @property
    def plays(self) -> str:
        """The movement the body makes, "" for none."""
        return _USUAL.get(self.phase, "") if self.movement is None else self.movement


@dataclass(frozen=True)
class Script:
    """A whole greeting: where the person starts and the acts in order.

    Raises:
        ParameterError: there is no act, or a value is out of range.
    """

    start: float  # [m] straight in front of the robot
    acts: tuple[Act, ...]
    speed: float = WALKING_SPEED  # [m/s]
    stop_distance: float = 1.0  # [m], where the person stops before the robot (thesis 3.6.4)
    bearing: float = 0.0  # [rad], direction of the start from the robot, positive left
    height: float = 1.6  # [m], of the face
    title: str = ""

    def __post_init__(self) -> None:
        if not self.acts:
            raise ParameterError("a script needs at least one act")
        for name in ("start", "speed", "stop_distance", "height"):
            if not 0 < getattr(self, name) < math.inf:
                raise ParameterError(
                    f"a script's {name} must be positive, not {getattr(self, name)}"
                )
        if not math.isfinite(self.bearing):
            raise ParameterError(f"a script's bearing must be finite, not {self.bearing}")


_SIGHTING = Act(Phase.IA, seconds=1.6, gaze=1.0, smile=1.0)
_WAVE = Act(Phase.DS, seconds=1.2, walking=True, gaze=0.4, smile=2.0)
_DIP = Act(Phase.HD, seconds=0.7, walking=True, gaze=1.4, smile=1.0, looks_down=True)
_ARRIVAL = Act(Phase.FA, until_distance=1.0, walking=True, gaze=0.4, smile=2.0)
_HANDSHAKE = Act(Phase.CS, seconds=5.0, gaze=0.4, smile=2.0)


def _approach(until: float) -> Act:
    """Walking up without a smile and with the eyes on the ground (thesis 2.1.4)."""
    return Act(Phase.APP, until_distance=until, walking=True, gaze=1.1, smile=1.0, looks_down=True)


#: The scripts users can name; the first is the default.
SCRIPTS: dict[str, Script] = {
    "normal": Script(
        7.0,
        bearing=math.radians(25),
        acts=(
            _SIGHTING,
            _approach(6.0),
            _WAVE,
            _DIP,
            _approach(3.0),
            _ARRIVAL,
            _HANDSHAKE,
        ),
        title="every phase, in Kendon's order",
    ),
    "plain": Script(
        6.0,
        (_SIGHTING, _approach(3.0), _ARRIVAL, _HANDSHAKE),
        title="no salutation from afar",
    ),
    "late-wave": Script(
        6.0,
        (
            _SIGHTING,
            _approach(3.0),
            replace(_ARRIVAL, until_distance=2.4),
            replace(_WAVE, seconds=0.6),
            _ARRIVAL,
            _HANDSHAKE,
        ),
        title="a wave just before the handshake",
    ),
    "short": Script(
        2.2,
        (_SIGHTING, _ARRIVAL, _HANDSHAKE),
        title="sighted at two metres",
    ),
}


def script(name: str) -> Script:
    """The script of a name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in SCRIPTS:
        raise UnknownNameError("simulated greeting", name, SCRIPTS)
    return SCRIPTS[name]
