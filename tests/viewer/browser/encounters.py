"""Encounters for the tests of the page."""

from __future__ import annotations

from kendon.greeter import Greeter
from kendon.models import load_model
from kendon.robots import make_robot
from kendon.sources import SourceOptions, open_source
from kendon.viewer.browser.played import PlayedSource
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.session import Choices, Session
from kendon.viewer.browser.stage import Stage


def make(choices: Choices) -> tuple[Stage, Player | None]:
    """The encounter of some choices."""
    player = Player(keys=choices.keys) if choices.source == "played" else None
    source = PlayedSource(player) if player else open_source(choices.source, SourceOptions())
    greeter = Greeter(source, load_model(choices.model), make_robot(choices.robot))
    return Stage(greeter, "A greeting"), player


def played(robot: str = "point", *, keys: bool = True) -> Session:
    """A session whose person is the user's."""
    return Session(make, Choices("played", "kendon", robot, keys))


def simulated(spec: str = "simulated", robot: str = "point") -> Session:
    """A session with a built-in person."""
    return Session(make, Choices(spec, "kendon", robot))


def pass_time(session: Session, seconds: float) -> None:
    """Let so much time pass, a tick at a time."""
    for _ in range(round(seconds * 10)):
        session.step(0.1)
