"""When messages came, which may be long before a busy computer takes them in."""

from __future__ import annotations

#: Clocks drift apart by no more than this share (a cheap quartz: 0.01 %).
_DRIFT = 1e-4


class Arrivals:
    """Tells by when messages were sent when they came.

    The quickest message shows how far the senders' clock is ahead of this one or behind it. One
    that took longer may have waited here, while nobody looked: it counts as if it had been as
    quick, so that a computer that stood still for a while does not take what came meanwhile for
    late. Times grow, and never lie before one that all had been taken in by.
    """

    def __init__(self) -> None:
        self.newest = 0  # [ns], all that came until then has been taken in
        self._lag: tuple[int, int] | None = None  # [ns], from sending to here at best, and when

    def take(self, sent: int, now: int) -> int:
        """When a message came [ns].

        Args:
            sent: by its sender's clock, 0 = unknown [ns].
            now: when it is taken in [ns].
        """
        came = now
        if sent:
            lag = now - sent
            if self._lag is not None:
                best, when = self._lag
                lag = min(lag, best + round((now - when) * _DRIFT))
            self._lag = lag, now
            came = sent + lag
        self.newest = max(self.newest + 1, min(came, now))
        return self.newest

    def pass_time(self, until: int) -> int:
        """Note that all that came until a time has been taken in; returns the newest time [ns]."""
        self.newest = max(self.newest + 1, until)
        return self.newest
