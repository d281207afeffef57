"""What a robot does, a line each: printed when it changes, not each time that it is sent."""

from __future__ import annotations

from collections.abc import Iterable

from kendon.cli.options import note, out
from kendon.greeter import describe
from kendon.robots.base import CHANNELS, Command, CommandStatus


class RobotLines:
    """Prints commands as they change; a drive is followed up ten times a second."""

    def __init__(self) -> None:
        self._doing: dict[str, str] = {}  # by channel
        self._going: list[Command] = []
        self._failed: dict[str, str] = {}  # by channel, why the last command failed

    def begin(self) -> None:
        """What follows answers to something new: print it though it is the same."""
        self._doing.clear()

    def show(self, commands: Iterable[Command]) -> None:
        """Print what is new, of these commands and of those before that are under way."""
        for command in commands:
            channel, what = CHANNELS[command.kind], describe(command)
            if self._doing.get(channel) != what:
                out.print(f"  robot  {what}", highlight=False)
            self._doing[channel] = what
            self._going.append(command)
        for command in [command for command in self._going if not command.running]:
            self._going.remove(command)
            channel = CHANNELS[command.kind]
            failed = command.reason if command.status is CommandStatus.FAILED else ""
            if failed and failed != self._failed.get(channel):
                note(f"{describe(command)} failed: {failed}")
            if command.status is not CommandStatus.CANCELLED:
                self._failed[channel] = failed
