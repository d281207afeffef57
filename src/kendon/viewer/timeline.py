"""An encounter in the terminal as it happens, one line an observation."""

from __future__ import annotations

import math

from rich.console import Console
from rich.text import Text

from kendon.greeter import Moment, describe
from kendon.observations import Observation
from kendon.phases import Phase
from kendon.robots import CHANNELS, Command, CommandKind

_EIGHTHS = " ▏▎▍▌▋▊▉█"
_BAR = 5  # letters of one probability's bar
_HEADER = "   time  dist. speed  gaze smile  "
_UNITS = "      s      m   m/s     1   0-5  "


class Timeline:
    """Prints a moment's observation, belief and commands as one line each.

    Args:
        console: where to.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last_phase: Phase | None = None
        self._said: dict[str, str] = {}  # the last words about each part of the body
        self._waiting: list[str] = []

    def header(self) -> None:
        """Print what the columns are."""
        head = Text(_HEADER)
        for phase in Phase:
            head.append(f"{phase.name:<{_BAR + 1}}", style=f"bold {phase.color}")
        head.append("phase  the robot")
        self._print(head)
        self._print(Text(_UNITS + "probability, 0 to 1", style="dim"))

    def show(self, moment: Moment) -> None:
        """Print the moment if it brought an observation; keep its commands for then if not."""
        self._waiting += [words for c in moment.commands if (words := self._news(c))]
        if not moment.is_new or moment.observation is None or moment.belief is None:
            return
        line = Text(_numbers(moment.observation))
        for phase, p in zip(Phase, moment.belief.probabilities.tolist(), strict=True):
            line.append(bar(p), style=f"{phase.color} on grey15")
            line.append(" ")
        phase = moment.belief.phase
        entered = phase is not self._last_phase
        line.append(f"{phase.name:<5}", style=f"bold {phase.color}" if entered else phase.color)
        line.append("  " + ", ".join(self._waiting))
        self._print(line)
        self._last_phase, self._waiting = phase, []

    def _news(self, command: Command) -> str:
        """The command in a few words, or nothing when it only follows up the one before."""
        channel, words = CHANNELS[command.kind], describe(command)
        followed_up = command.kind in (CommandKind.GO_TO, CommandKind.LOOK_AT)
        if followed_up and self._said.get(channel) == words:
            return ""
        self._said[channel] = words
        return words

    def _print(self, line: Text) -> None:
        if self._console.is_terminal:
            line.truncate(max(60, self._console.width), overflow="ellipsis")
        self._console.print(line, soft_wrap=True, highlight=False)


def bar(share: float, width: int = _BAR) -> str:
    """A horizontal bar of `width` letters for a share between 0 and 1.

    >>> bar(0.5, 4), bar(1.0, 2)
    ('██  ', '██')
    """
    eighths = round(share * width * 8)
    full, rest = divmod(eighths, 8)
    return ("█" * full + (_EIGHTHS[rest] if rest else "")).ljust(width)


def _numbers(observation: Observation) -> str:
    cells = [f"{observation.t:7.1f}"]
    for value, digits, width in (
        (observation.distance, 2, 7),
        (observation.speed, 2, 6),
        (observation.gaze, 2, 6),
        (observation.smile, 1, 6),
    ):
        if math.isnan(value):
            cells.append(f"{'–':>{width}}")
        else:  # adding zero turns a minus zero into zero
            cells.append(f"{round(value, digits) + 0.0:{width}.{digits}f}")
    return "".join(cells) + "  "
