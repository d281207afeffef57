"""What a simulated person can be told to do: by a script, by chance, or by somebody at a page.

person.act(WalkTo(2.0, 0.5))
person.act(parse_deed("wave"))
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kendon.errors import ParameterError, UnknownNameError
from kendon.geometry import Vec3
from kendon.simulation.movements import MOVEMENTS, Movement


@dataclass(frozen=True)
class WalkTo:
    """Walk to a place, and stop there.

    Raises:
        ParameterError: a number is not finite, or the speed is not positive.
    """

    x: float  # [m], world
    y: float  # [m]
    speed: float = math.nan  # [m/s]; NaN = their usual one
    backward: bool = False  # step back without turning

    def __post_init__(self) -> None:
        _finite("walk", self.x, self.y)
        if self.speed == self.speed and not 0 < self.speed < math.inf:
            raise ParameterError(f"a walking speed must be positive, not {self.speed}")


@dataclass(frozen=True)
class Stand:
    """Stop walking, as fast as one does."""


@dataclass(frozen=True)
class Turn:
    """Turn the body on the spot to a heading in the world."""

    yaw: float  # [rad]

    def __post_init__(self) -> None:
        _finite("turn", self.yaw)


@dataclass(frozen=True)
class Look:
    """Turn the head to a point in the world, or straight ahead."""

    at: Vec3 | None = None  # [m]; None = where the body points
    aside: float = 0.0  # [rad], to the left of it
    down: float = 0.0  # [rad], below it

    def __post_init__(self) -> None:
        _finite("look", *(self.at or ()), self.aside, self.down)


@dataclass(frozen=True)
class Smile:
    """Smile, or stop smiling."""

    level: float  # [0-5]

    def __post_init__(self) -> None:
        if not 0 <= self.level <= 5:
            raise ParameterError(f"a smile lies between 0 and 5, not {self.level}")


@dataclass(frozen=True)
class Gesture:
    """Make a movement of a kind, drawn for this person, or exactly the one given.

    Raises:
        UnknownNameError: there is no such kind.
    """

    kind: str  # one of MOVEMENTS
    movement: Movement | None = None  # its times count from when it is made

    def __post_init__(self) -> None:
        if self.kind not in MOVEMENTS:
            raise UnknownNameError("movement", self.kind, MOVEMENTS)


Deed = WalkTo | Stand | Turn | Look | Smile | Gesture

_WORDS = {
    "walk": "walk X Y", "stand": "stand", "turn": "turn DEGREES", "look": "look [X Y Z]",
    "smile": "smile LEVEL",
}  # fmt: skip


def parse_deed(text: str) -> Deed:
    """A deed in words: ``walk 2 0.5``, ``look 0 0 1.2``, ``smile 2``, ``wave``, ``handshake``.

    Raises:
        UnknownNameError: the first word is none of those, and no movement's name.
        ParameterError: the numbers after it do not fit.

    >>> parse_deed("walk 2 0.5")
    WalkTo(x=2.0, y=0.5, speed=nan, backward=False)
    """
    word, *rest = text.split() or [""]
    try:
        numbers = [float(part) for part in rest]
    except ValueError:
        numbers = [math.nan]
    match word, numbers:
        case "walk", [x, y]:
            return WalkTo(x, y)
        case "stand", []:
            return Stand()
        case "turn", [degrees]:
            return Turn(math.radians(degrees))
        case "look", []:
            return Look()
        case "look", [x, y, z]:
            return Look((x, y, z))
        case "smile", [level]:
            return Smile(level)
        case kind, [] if kind in MOVEMENTS:
            return Gesture(kind)
    if word in _WORDS:
        raise ParameterError(f"say {_WORDS[word]!r}, with finite numbers, not {text!r}")
    if word in MOVEMENTS:
        raise ParameterError(f"{word!r} takes no numbers: not {text!r}")
    raise UnknownNameError("deed", word, [*_WORDS, *MOVEMENTS])


def _finite(what: str, *numbers: float) -> None:
    if not all(math.isfinite(n) for n in numbers):
        raise ParameterError(f"{what} needs finite numbers, not {', '.join(map(str, numbers))}")
