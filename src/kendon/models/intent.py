"""Whether a person means to greet the robot at all, or is only passing.

The thesis assumes that everybody does (3.6.4), and its six phases have none for those who do not.
Here two hypotheses are weighed, observation by observation, by what tells the two apart: where
the way leads, whether the look is at the robot, and what is shown.
"""

from __future__ import annotations

import math
from collections import deque

from kendon.observations import Observation

#: The way is read off this much of the past [s]: two steps, so that sway cancels.
_SPAN = 1.0
#: Who walks more slowly than this has no course yet [m/s].
_WALKS = 0.35
#: How near a greeter's way leads past the robot's middle [m], standard deviation: half a body's
#: breadth. The greeter's share of detours is `_DETOUR`.
_MISS, _DETOUR = 0.25, 0.1
#: Passers-by pass anywhere up to here [m]: Hall's (1966) social distance, beyond which nobody
#: is taken for a greeter.
_PASSING = 3.6
#: The odds that a greeter walks off from the robot, and that a passer-by does at any instant.
_OFF = (0.03, 0.5)
#: The odds that the look is at the robot: greeters' in the approach about half (thesis 2.1.4) and
#: more in the rest; passers-by glance.
_LOOKS = (0.65, 0.3)
#: On the rim of the cone either is as likely (thesis 3.3.3); so near to it rounding would decide.
_RIM = 1e-6
#: Salutations are seen in so many intervals of those who greet, and wrongly in so few of others.
_SHOWS = (0.05, 0.005)
#: Observations a second, by the second that a course is read from: neighbours share evidence.
_SHARED = 0.2
#: Nobody is ever surer than this [log odds]: people change their minds.
_SURE = 2.5
_COMING_WIDTH = 2 / (math.sqrt(2 * math.pi) * _MISS)


class Intent:
    """The belief that a person means to greet, followed over time.

    Args:
        prior: the probability for somebody who has just been noticed.
    """

    def __init__(self, prior: float = 0.5) -> None:
        self._prior = math.log(prior / (1 - prior))
        self._places: deque[tuple[float, float, float]] = deque()  # t [s], x, y [m] in the world
        self._odds = self._prior

    @property
    def probability(self) -> float:
        """That the person means to greet."""
        return 1 / (1 + math.exp(-self._odds))

    def reset(self) -> None:
        """Somebody else has come."""
        self._places.clear()
        self._odds = self._prior

    def see(self, t: float, x: float, y: float) -> None:
        """Take in where the person is in the world [m]."""
        places = self._places
        places.append((t, x, y))
        while t - places[0][0] > _SPAN:
            places.popleft()

    def step(self, observation: Observation, robot: tuple[float, float]) -> float:
        """Weigh the next observation; the robot stands at a place in the world [m].

        Returns:
            The probability that the person means to greet.
        """
        evidence = self._course(robot) + _look(observation.gaze)
        for shown in (observation.dsal, observation.csal):
            if shown == shown:
                greets = shown * _SHOWS[0] + (1 - shown) * (1 - _SHOWS[0])
                passes = shown * _SHOWS[1] + (1 - shown) * (1 - _SHOWS[1])
                evidence += math.log(greets / passes)
        self._odds = min(max(self._odds + _SHARED * evidence, -_SURE), _SURE)
        return self.probability

    def _course(self, robot: tuple[float, float]) -> float:
        """The log odds of where the way leads; 0 for those who stand."""
        velocity = self._velocity()
        if velocity is None:
            return 0.0
        vx, vy = velocity
        speed = math.hypot(vx, vy)
        if speed < _WALKS:
            return 0.0
        _, x, y = self._places[-1]
        dx, dy = robot[0] - x, robot[1] - y
        if dx * vx + dy * vy <= 0:
            return math.log(_OFF[0] / _OFF[1])
        miss = abs(dx * vy - dy * vx) / speed
        coming = (1 - _DETOUR) * _COMING_WIDTH * math.exp(-0.5 * (miss / _MISS) ** 2)
        elsewhere = 1 / _PASSING
        return math.log((coming + _DETOUR * elsewhere) / elsewhere)

    def _velocity(self) -> tuple[float, float] | None:
        """The slopes of straight lines through the places [m/s]."""
        places = self._places
        n = len(places)
        if n < 3 or places[-1][0] - places[0][0] < 0.3:
            return None
        mean_t, mean_x, mean_y = (sum(column) / n for column in zip(*places, strict=True))
        square = cross_x = cross_y = 0.0
        for t, x, y in places:
            off = t - mean_t
            square += off * off
            cross_x += off * (x - mean_x)
            cross_y += off * (y - mean_y)
        return cross_x / square, cross_y / square


def _look(gaze: float) -> float:
    if gaze != gaze or abs(gaze - 1.0) < _RIM:
        return 0.0
    looks = gaze < 1.0  # within the 60 degree cone (thesis 3.3.3)
    greets, passes = _LOOKS
    return math.log(greets / passes) if looks else math.log((1 - greets) / (1 - passes))
