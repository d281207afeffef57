"""Which of several people is greeted.

A greeting begins when two people have sighted each other and one turns to the other (Kendon 1990,
chapter 6); robots in public therefore judge who wants to engage by how near people are and whether
they face the robot (Michalowski, Sabanovic and Simmons 2006, "A spatial model of engagement for a
social robot"). The rule:

1. *Start* with the nearest of those who face the robot; if nobody does, with the nearest.
2. *Keep* to that person, seen or not, until they have been out of sight for `PATIENCE`. Looking
   away is no reason to leave them: people look away as they approach (Kendon 1990).
3. *Change* only to somebody who is nearer by `NEARER` and faces the robot while the present one
   does not, and this for `INSISTENCE` without a break.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

#: So long a person may be out of sight and still be waited for [s].
PATIENCE = 1.5
#: So much nearer somebody must be who takes the place of the greeted one [m].
NEARER = 0.5
#: And so long must they face the robot, and the greeted one not [s].
INSISTENCE = 2.0
#: A head that points past the robot by less than this faces it: the half of the cone of visual
#: attention (thesis 3.3.3) [rad].
FACING = math.radians(30.0)


@dataclass(frozen=True)
class Candidate:
    """One of the people before the robot."""

    number: int
    distance: float  # [m]
    facing: bool  # whether the head points to the robot


class GreetedChoice:
    """Chooses the greeted person, frame by frame.

    Args:
        only: the number of the one person to follow; None to choose by the rule.
    """

    def __init__(self, only: int | None = None) -> None:
        self._only = only
        self._greeted: int | None = None
        self._seen = -math.inf  # [s], the greeted one
        self._rival: tuple[int, float] | None = None  # who insists, and since when [s]

    def choose(self, people: Sequence[Candidate], t: float) -> int | None:
        """The number of the greeted person at `t` [s]; None where they are not seen."""
        there = {person.number: person for person in people}
        if self._only is not None:
            return self._only if self._only in there else None
        if self._greeted in there:
            self._seen = t
            self._give_way(there, there[self._greeted], t)
        elif self._greeted is None or t - self._seen > PATIENCE:
            self._greeted = _first(people)
            self._seen, self._rival = t, None
        return self._greeted if self._greeted in there else None

    def _give_way(self, there: dict[int, Candidate], greeted: Candidate, t: float) -> None:
        """Change to somebody who insists."""
        rivals = [
            person
            for person in there.values()
            if person.facing and person.distance < greeted.distance - NEARER
        ]
        if greeted.facing or not rivals:
            self._rival = None
            return
        number = min(rivals, key=lambda person: person.distance).number
        if self._rival is None or self._rival[0] != number:
            self._rival = number, t
        elif t - self._rival[1] >= INSISTENCE:
            self._greeted, self._rival = number, None


def _first(people: Sequence[Candidate]) -> int | None:
    chosen = min(people, key=lambda person: (not person.facing, person.distance), default=None)
    return chosen.number if chosen else None
