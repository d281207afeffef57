"""An encounter in the terminal as it happens: a line whenever there is something new to tell."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Console
from rich.text import Text

from kendon.greeter import Moment, describe
from kendon.observations import Observation
from kendon.phases import Phase
from kendon.robots import CHANNELS, Command, CommandKind

_EIGHTHS = " ▏▎▍▌▋▊▉█"
_BAR = 5  # letters of one probability's bar
#: What an observation's numbers must change by to be told before their time, as they are printed:
#: distance [m], speed [m/s], gaze [1], smile [0–5].
_NEWS = (0.5, 0.3, 0.3, 1.0)
#: And a phase's probability.
_LIKELIER = 0.2
#: A line comes at least so often [s].
_SILENCE = 1.0
_HEADER = "   time  dist. speed  gaze smile  "
_UNITS = "      s      m   m/s     1   0-5  "


class Timeline:
    """Prints moments as lines: what is observed, how likely each phase is, what the robot does.

    A moment is told when the robot does something, another phase is entered or becomes likelier,
    or the person has moved, turned or been lost since the last line; and once a second anyway.

    Args:
        console: where to.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last_phase: Phase | None = None
        self._said: dict[str, str] = {}  # the last words about each part of the body
        self._waiting: list[str] = []
        self._told: tuple[float, ...] = ()  # the numbers of the last line
        self._told_at = -math.inf  # [s]

    def header(self) -> None:
        """Print what the columns are."""
        head = Text(_HEADER)
        for phase in Phase:
            head.append(f"{phase.name:<{_BAR + 1}}", style=f"bold {phase.color}")
        head.append("phase  the robot")
        self._print(head)
        self._print(Text(_UNITS + "probability, 0 to 1", style="dim"))

    def show(self, moment: Moment) -> None:
        """Print the moment if it brought news; keep its commands for an observation if not."""
        self._waiting += [words for c in moment.commands if (words := self._news(c))]
        if not moment.is_new or moment.observation is None or moment.belief is None:
            return
        seen, phase = moment.observation, moment.belief.phase
        entered = phase is not self._last_phase
        probabilities = moment.belief.probabilities.tolist()
        numbers = (seen.distance, seen.speed, seen.gaze, seen.smile, *probabilities)
        if not (self._waiting or entered or self._is_news(seen.t, numbers)):
            return
        self._told, self._told_at = numbers, seen.t
        line = Text(_numbers(seen))
        for each, p in zip(Phase, probabilities, strict=True):
            line.append(bar(p), style=f"{each.color} on grey15")
            line.append(" ")
        line.append(f"{phase.name:<5}", style=f"bold {phase.color}" if entered else phase.color)
        line.append("  " + ", ".join(self._waiting))
        self._print(line)
        self._last_phase, self._waiting = phase, []

    def _is_news(self, t: float, numbers: Sequence[float]) -> bool:
        """Whether a line at `t` [s] with these numbers says more than the last one."""
        # The clock's seconds are sums of fifths, and round.
        if t - self._told_at > _SILENCE - 1e-6:
            return True
        limits = (*_NEWS, *[_LIKELIER] * len(Phase))
        return any(
            abs(now - told) >= limit or math.isnan(now) != math.isnan(told)
            for now, told, limit in zip(numbers, self._told, limits, strict=True)
        )

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
