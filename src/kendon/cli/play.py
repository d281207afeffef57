"""`kendon play`: take the person's part in a greeting, in a browser."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from kendon.cli.options import ModelOption
from kendon.cli.viewing import (
    HOST,
    PORT,
    SHOWN_ROBOT,
    HostOption,
    OpenOption,
    PortOption,
    RecordOption,
    show,
)
from kendon.greeter import Greeter
from kendon.models import DEFAULT_MODEL, load_model
from kendon.robots import make_robot
from kendon.trees import GreetingTree
from kendon.viewer.browser.played import PlayedSource
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.session import Choices
from kendon.viewer.browser.stage import Stage

EPILOG = """
**Examples**

`kendon play` · be the person: walk about, wave, and see what the robot makes of it

`kendon play --robot point --model data-driven` · another robot, another reading

`kendon play --gestures told` · the buttons tell kendon what you do, as the thesis's keys did

`kendon play --record mine.html` · keep it as a page that replays it

`kendon play --host 0.0.0.0 --no-open` · play on a phone in the same network
"""


class Gestures(StrEnum):
    """How kendon learns of a played person's gestures."""

    READ = "read"
    TOLD = "told"


def play_command(
    model: ModelOption = DEFAULT_MODEL,
    robot: Annotated[
        str, typer.Option(help="A robot's name (see `kendon robots`) or .toml file.")
    ] = SHOWN_ROBOT,
    tree: Annotated[
        Path | None, typer.Option(help="A BehaviorTree.CPP XML file instead of kendon's own.")
    ] = None,
    gestures: Annotated[
        Gestures,
        typer.Option(help="Whether gestures are read off the body, or told by the buttons."),
    ] = Gestures.READ,
    record: RecordOption = None,
    host: HostOption = HOST,
    port: PortOption = PORT,
    opened: OpenOption = True,
) -> None:
    """Be the person: greet the robot in a browser and see what it reads and does."""

    def make(choices: Choices) -> tuple[Stage, Player | None]:
        player = Player(keys=choices.keys)
        greeter = Greeter(
            PlayedSource(player),
            load_model(choices.model),
            make_robot(choices.robot),
            GreetingTree(tree) if tree else None,
        )
        return Stage(greeter, "A person greets a robot"), player

    choices = Choices("played", model, robot, gestures is Gestures.TOLD)
    show(make, choices, host, port, opened, record)
