"""Messages that come by several subscriptions of a topic, each handed on once.

In DDS a reader hears only writers that offer at least what it asks for, and gets no more than it
asked for. Where one writer of a topic is reliable or latched and another is not, only one reader
for each way loses nothing of any; what is offered with more then comes by several of them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable

#: So many messages are remembered, more than can wait for a reader.
_REMEMBERED = 5000


class Overlap:
    """Tells of each message whether it has not come yet by another subscription."""

    def __init__(self) -> None:
        self._counts: dict[bytes, Counter[Hashable]] = {}  # the newest message last

    def is_new(self, way: Hashable, raw: bytes) -> bool:
        """Whether a message is to be handed on.

        The same bytes sent twice come twice by each subscription that hears their writer.

        Args:
            way: the subscription by which it came.
            raw: the message.
        """
        counts = self._counts.pop(raw, Counter())
        self._counts[raw] = counts
        if len(self._counts) > _REMEMBERED:
            del self._counts[next(iter(self._counts))]
        before = max(counts.values(), default=0)
        counts[way] += 1
        return counts[way] > before
