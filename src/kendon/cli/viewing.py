"""What the commands that show an encounter in a browser share: their options, and the showing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from kendon.cli.options import note, out
from kendon.errors import MissingExtraError, ParameterError
from kendon.geometry import Vec3
from kendon.greeter import Greeter
from kendon.models import load_model
from kendon.robots import RobotOptions, make_robot
from kendon.sources import RecordedSource, Source, SourceOptions, open_source
from kendon.trees import GreetingTree
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.session import Choices, Session
from kendon.viewer.browser.stage import Stage

PAGE = "The page in the browser"
#: The robot that is shown unless another is asked for: one with a body.
SHOWN_ROBOT = "mujoco"

RecordOption = Annotated[
    Path | None,
    typer.Option(
        help="Save the encounter as this .html page, which replays it without kendon or a network.",
        rich_help_panel=PAGE,
    ),
]
HostOption = Annotated[
    str,
    typer.Option(
        help="The address the page is served at; 0.0.0.0 lets other machines see it.",
        rich_help_panel=PAGE,
    ),
]
PortOption = Annotated[
    int, typer.Option(help="Likewise; 0 for any that is free.", rich_help_panel=PAGE)
]
OpenOption = Annotated[
    bool,
    typer.Option(
        "--open/--no-open", help="Whether to open the page in a browser.", rich_help_panel=PAGE
    ),
]
#: Where a page is served unless asked otherwise.
HOST, PORT = "127.0.0.1", 8080


@dataclass(frozen=True)
class Stages:
    """Makes an encounter with a source's person, anew as often as it is asked to."""

    options: SourceOptions
    name: str | None  # of the source, if it is not to be recognised
    tree: Path | None
    face: Vec3 | None  # the robot's, see `RobotOptions`
    gestures_from_phases: bool

    def make(self, choices: Choices) -> tuple[Stage, Player | None]:
        """The encounter of some choices.

        Raises:
            KendonError: it cannot be made.
        """
        source = open_source(choices.source, self.options, name=self.name)
        if self.gestures_from_phases:
            source = with_gestures(source, choices.source)
        for sentence in source.notes:
            note(sentence)
        robot = make_robot(choices.robot, RobotOptions(self.face, None if source.reacts else 0.0))
        tree = GreetingTree(self.tree) if self.tree else None
        greeter = Greeter(source, load_model(choices.model), robot, tree)
        return Stage(greeter, encounter_title(choices.source)), None


def with_gestures(source: Source, spec: str) -> Source:
    """A source whose gestures are given by its true phases.

    Raises:
        ParameterError: it has none.
    """
    if not isinstance(source, RecordedSource):
        raise ParameterError(f"{spec} has no true phases to press the gesture keys by")
    return source.with_gestures_from_phases()


def encounter_title(spec: str) -> str:
    """What an encounter with the person of a source is called."""
    return Path(spec).stem if Path(spec).exists() else f"{spec} greeting"


def check_replay(path: Path) -> None:
    """Refuse, before anything runs, a replay that could not be written.

    Raises:
        MissingExtraError: viser is not installed.
        DataError: the file cannot be written.
    """
    _require_viser()
    from kendon.viewer.browser.replay import check_replay as check

    check(path)


def show(
    make: Callable[[Choices], tuple[Stage, Player | None]],
    choices: Choices,
    host: str,
    port: int,
    opened: bool,
    record: Path | None,
) -> None:
    """Show an encounter in a browser until Ctrl-C, then save it where that is asked.

    Raises:
        MissingExtraError: viser is not installed.
        ParameterError: nothing can listen at that address.
        DataError: the file to record into cannot be written, or the source cannot be read.
    """
    _require_viser()
    from kendon.viewer.browser.replay import replay_page, write_replay
    from kendon.viewer.browser.server import Page, check_address

    if record:
        check_replay(record)
    check_address(host, port)
    session = Session(make, choices)
    page = Page(session, lambda: replay_page(session.stage), host, port)
    out.print(f"The encounter is at {page.address} (Ctrl-C ends it).", highlight=False)
    if opened:
        page.open()
    try:
        page.run()
    except KeyboardInterrupt:
        pass
    finally:
        page.close()
    if record:
        write_replay(session.stage, record)
        out.print(f"The replay is {record}; any browser shows it.", highlight=False)


def _require_viser() -> None:
    """Viser takes a second to import: only those who need it wait for it."""
    try:
        import viser  # noqa: F401
    except ImportError:
        raise MissingExtraError("showing or recording an encounter", "view", "viser") from None
