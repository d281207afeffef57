"""The user's person as a source, so that a greeting can be played like any other."""

from __future__ import annotations

from collections.abc import Iterator

from kendon.person import PersonFrame
from kendon.robots.base import Robot
from kendon.sources import Source
from kendon.viewer.browser.player import Player


class PlayedSource(Source):
    """A user's person as a source without an end.

    Args:
        player: the person.
    """

    name = "played"
    reads = "a person whom you move yourself (`kendon play`)"
    reacts = True

    def __init__(self, player: Player) -> None:
        self.player = player
        self._robot: Robot | None = None

    def attach(self, robot: Robot) -> None:
        """Stand before this robot."""
        self._robot = robot

    def frames(self) -> Iterator[PersonFrame]:
        """The person, for as long as somebody asks."""
        while True:
            if self._robot is None:
                yield self.player.frame()
                self.player.step()
            else:
                yield self.player.frame(self._robot.pose)
                self.player.step(self._robot.pose, self._robot.face)
