"""What a page's user does with an encounter: run it, hurry it, stop it, look back, start anew.

One thread owns a session and everything under it; others hand it what they want done with
`post`.
"""

from __future__ import annotations

import queue
from collections.abc import Callable
from dataclasses import dataclass, replace

from kendon.errors import KendonError, ParameterError
from kendon.trees import TICK_RATE
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.stage import Shown, Stage

#: How fast time may run, as a multiple of real time.
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0)
#: Ticks made up for at once, before a slow machine lets time run slower instead.
_CATCH_UP = 5


@dataclass(frozen=True, slots=True)
class Choices:
    """What an encounter is made of."""

    source: str  # what `kendon greet` reads, or "played"
    model: str  # a model's name or file
    robot: str  # a robot's name or file
    keys: bool = True  # whether a played person's gestures are given by hand


class Session:
    """Runs an encounter in time with a clock.

    Args:
        make: makes the encounter of some choices; for a played one, with its person.
        choices: of the first encounter.

    Raises:
        KendonError: it cannot be made.
    """

    def __init__(
        self, make: Callable[[Choices], tuple[Stage, Player | None]], choices: Choices
    ) -> None:
        self._make = make
        self._posted: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.choices = choices
        self.paused = False
        self.speed = 1.0
        self.trouble = ""  # why the last wish could not be fulfilled, one sentence
        self.generation = 0  # how often an encounter was begun
        self._ahead = 0.0  # [ticks] that time has run since the newest tick
        self._back: int | None = None  # the snapshot looked back at; None = the newest
        self.stage, self.player = make(choices)
        self.stage.advance()

    # ---- what the user wants

    def post(self, wish: Callable[[], None]) -> None:
        """Have something done by the thread that owns the session, before its next step."""
        self._posted.put(wish)

    def restart(self, **changes: str | bool) -> None:
        """Begin a new encounter, with other choices where they are given."""
        wanted = replace(self.choices, **changes)  # type: ignore[arg-type]
        if self.stage.live:
            self.stage.close()  # a device is opened by one at a time
        try:
            stage, player = self._make(wanted)
        except KendonError as error:
            self.trouble = str(error)
            return
        self.stage.close()
        self.stage, self.player, self.choices = stage, player, wanted
        self.trouble = ""
        self.generation += 1
        self._ahead, self._back, self.paused = 0.0, None, False
        self.stage.advance()

    def pause(self) -> None:
        """Stop time."""
        self.paused = True

    def resume(self) -> None:
        """Let time run on from the newest tick; an encounter that is over plays from its start."""
        if self.stage.over:
            self._back = 0
        self.paused = False
        if not self.stage.over:
            self._back = None

    def hurry(self, speed: float) -> None:
        """Let time run at a multiple of real time.

        Raises:
            ParameterError: the speed is not one of `SPEEDS`.
        """
        if speed not in SPEEDS:
            raise ParameterError(f"the speed is one of {SPEEDS}, not {speed}")
        self.speed = speed

    def look_back(self, t: float) -> None:
        """Show an earlier instant, and stop time; the newest when there is nothing later."""
        self.paused = True
        place = self.stage.place_of(t)
        self._back = None if place >= len(self.stage.snapshots) - 1 else place

    # ---- time

    @property
    def looking_back(self) -> bool:
        """Whether an earlier instant is shown."""
        return self._back is not None

    @property
    def place(self) -> int:
        """Which of the stage's snapshots is shown."""
        newest = len(self.stage.snapshots) - 1
        return newest if self._back is None else min(self._back, newest)

    def step(self, passed: float) -> None:
        """Do what is wanted, then let time run.

        Args:
            passed: real time since the step before [s].

        Raises:
            DataError: there is something wrong with what the source reads.
        """
        while True:
            try:
                wish = self._posted.get_nowait()
            except queue.Empty:
                break
            wish()
        if self.paused:
            return
        if self.stage.live:
            self.stage.advance()
            return
        self._ahead += passed * self.speed * TICK_RATE
        due = int(self._ahead)
        self._ahead -= due
        for _ in range(min(due, _CATCH_UP)):
            if not self._tick():
                break

    def _tick(self) -> bool:
        """One tick on, in the encounter or, once it is over, in its replay."""
        newest = len(self.stage.snapshots) - 1
        if self._back is None and not self.stage.over:
            self.stage.advance()
        elif self._back is not None and self._back < newest:
            self._back += 1
        if self.stage.over and self.place >= len(self.stage.snapshots) - 1:
            self.paused, self._ahead, self._back = True, 0.0, None
        return not self.paused

    def shown(self) -> Shown:
        """The instant to draw: as far behind the newest tick as time has not yet reached it."""
        share = 1.0 if self.paused or self.stage.live else self._ahead
        return self.stage.shown(self.place, share)
