"""The time of a stream of stamped messages: one clock that grows, whatever the stamps do."""

from __future__ import annotations

import statistics
from collections.abc import Container
from typing import Any

#: A stamp that steps back by less is a message that came late [s].
MAX_LATE = 1.0
#: A stamp that leaps ahead of the time that has passed by more is of another clock [s].
MAX_LEAP = 10.0
#: A stamp that is ahead of the time that has passed by more, but less than that, is believed when
#: the next one agrees [s]: until then it is a stray, which would make the greeting seem over.
MAX_AHEAD = 1.0
#: Stamps and this machine's clock farther apart than this, in the median, are two clocks [s].
TWO_CLOCKS = 1.0
#: From so many messages that median is taken.
_JUDGED = 10
#: So many notes are kept of a clock that begins again and again.
_NOTES = 20
#: So many messages in a row by a clock of their own are a clock that began again.
_AGREED = 3
#: Stamps nearer to each other than this are the same [s]: finer than any camera, coarser than a
#: float of seconds since 1970.
_SHORTEST = 1e-5


def nanoseconds(stamp: Any) -> int:
    """A time of ROS 1 (secs, nsecs) or ROS 2 (sec, nanosec) as whole nanoseconds."""
    if hasattr(stamp, "nsecs"):
        return int(stamp.secs) * 10**9 + int(stamp.nsecs)
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def seconds(stamp: Any) -> float:
    """Likewise in seconds."""
    whole, rest = divmod(nanoseconds(stamp), 10**9)
    return whole + rest * 1e-9


class StreamClock:
    """Turns the stamps of one topic into times that grow.

    Messages count at their stamps. One that is not stamped counts when it came. One that came
    late, after a newer one, is left out, as all that could be said of its time has been said.
    Where a few in a row tell of quite another time, the sender's clock has begun again (a
    simulation that was reset, a recording played from the start): times go on from where they
    were. A single one that does is left out, and so is one that is seconds ahead, unless the next
    one is, too: then messages had been held up, or nothing was told for a while.

    Args:
        topic: its name, for the notes.
    """

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.late = 0  # messages left out as late
        self.strange = 0  # messages left out as of another clock
        self.restarts = 0  # how often the sender's clock began again
        self.notes: list[str] = []  # what a user should know, one sentence each
        self._stamp: float | None = None  # [s], the newest that counted
        self._now = 0.0  # [s], when it came
        self._shift = 0.0  # [s], from stamps to times
        self._lags: list[float] = []  # [s], from stamp to receipt
        self._others: list[float] = []  # stamps in a row that are of another clock
        self._ahead: float | None = None  # the last stamp, if it was left out as ahead [s]

    def take(self, stamp: float, now: float) -> float | None:
        """The time of a message [s], or None if it must be left out.

        Args:
            stamp: the message's; 0 = it has none [s].
            now: when it came, by the node's clock [s].
        """
        if stamp == 0:
            self._note_once(
                f"The messages of {self.topic} are not stamped: they count as they come."
            )
            stamp = now
        self._judge(now - stamp)
        if self._stamp is not None:
            step, passed = stamp - self._stamp, max(0.0, now - self._now)
            if step < -MAX_LATE or step > passed + MAX_LEAP:
                if not self._begins_again(stamp, passed):
                    return None
            elif step > passed + MAX_AHEAD and not self._is_believed(stamp, passed):
                return None
            elif step < _SHORTEST:
                self.late += 1
                self._note_once(
                    f"Messages of {self.topic} come late or twice; the newer ones count."
                )
                return None
        self._others.clear()
        self._ahead = None
        self._stamp, self._now = stamp, now
        return stamp + self._shift

    def at(self, now: float) -> float | None:
        """What the sender's clock shows now, in the times that `take` gives; None before that.

        Args:
            now: by the node's clock [s].
        """
        if self._stamp is None:
            return None
        return self._stamp + self._shift + max(0.0, now - self._now)

    def _is_believed(self, stamp: float, passed: float) -> bool:
        """Whether a stamp that is ahead follows another one that was."""
        before, self._ahead = self._ahead, stamp
        if before is not None and -MAX_LATE <= stamp - before <= passed + MAX_AHEAD:
            return True
        self.strange += 1
        return False

    def _begins_again(self, stamp: float, passed: float) -> bool:
        """Whether enough messages agree on another time; the first of them are left out."""
        others = self._others
        if others and not -MAX_LATE <= stamp - others[-1] <= passed + MAX_LEAP:
            others.clear()
        others.append(stamp)
        if len(others) < _AGREED:
            self.strange += 1
            if self.strange > _AGREED * (self.restarts + 1):
                self._note_once(
                    f"The messages of {self.topic} carry two clocks (does one of its senders use"
                    " simulated time?); those of the clock that came first count."
                )
            return False
        assert self._stamp is not None
        self._shift += self._stamp + max(passed, _SHORTEST) - stamp
        self.restarts += 1
        self.notes.append(
            f"The clock of {self.topic} went from {self._stamp:.1f} s to {stamp:.1f} s: it began"
            " again, and so does the greeting."
        )
        del self.notes[:-_NOTES]
        return True

    def _judge(self, lag: float) -> None:
        if len(self._lags) == _JUDGED:
            return
        self._lags.append(lag)
        off = statistics.median(self._lags)
        if len(self._lags) == _JUDGED and abs(off) > TWO_CLOCKS:
            way = "behind" if off > 0 else "ahead of"
            self._note_once(
                f"The stamps of {self.topic} are {abs(off):.1f} s {way} this node's clock: these"
                " are two clocks (is use_sim_time set for one side only, or a recording played"
                " without --clock?); the stamps count."
            )

    def _note_once(self, sentence: str) -> None:
        if sentence not in self.notes:
            self.notes.append(sentence)


class StampGuard:
    """Tells single stamps of quite another time from a clock that has been set.

    As in `StreamClock`, a few in a row that agree on another time are a clock that was set, and
    one that is only seconds ahead is believed when the next one agrees.
    """

    def __init__(self) -> None:
        self._newest: dict[str, tuple[int, int]] = {}  # by name: stamp, and when it came [ns]
        self._others: dict[str, list[int]] = {}  # stamps in a row that are of another time [ns]

    def fits(self, name: str, stamp: int, received: int) -> bool:
        """Whether a stamp counts.

        Args:
            name: what is stamped, such as a frame.
            stamp: when it holds [ns].
            received: when it came [ns].
        """
        if name in self._newest:
            before, when = self._newest[name]
            passed = max(0, received - when)
            if not _follows(stamp, before, passed + _ns(MAX_AHEAD)):
                needed = 2 if _follows(stamp, before, passed + _ns(MAX_LEAP)) else _AGREED
                if self._agreed(name, stamp, passed) < needed:
                    return False
        self._others.pop(name, None)
        self._newest[name] = stamp, received
        return True

    def forget(self, kept: Container[str]) -> None:
        """Forget all names but some."""
        for name in [name for name in self._newest if name not in kept]:
            del self._newest[name]
            self._others.pop(name, None)

    def _agreed(self, name: str, stamp: int, passed: int) -> int:
        """How many in a row agree on another time, with this one."""
        others = self._others.setdefault(name, [])
        if others and not _follows(stamp, others[-1], passed + _ns(MAX_AHEAD)):
            others.clear()
        others.append(stamp)
        return len(others)


def _follows(stamp: int, before: int, most: int) -> bool:
    """Whether a stamp may come after another one, so much later at most; all in ns."""
    return -_ns(MAX_LATE) <= stamp - before <= most


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)
