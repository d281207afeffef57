"""Kendon's six greeting phases: their numbers, names and colours."""

from __future__ import annotations

from enum import IntEnum

from kendon.errors import UnknownNameError


class Phase(IntEnum):
    """A phase of a greeting (Kendon 1990; thesis 2.1).

    The values are the numbers of the thesis's ``/state`` topic.
    """

    IA = 1
    DS = 2
    HD = 3
    APP = 4
    FA = 5
    CS = 6

    @property
    def title(self) -> str:
        """The phase in words: ``Phase.DS.title == 'Distance Salutation'``."""
        return _TITLES[self]

    @property
    def color(self) -> str:
        """The colour of the phase in every figure and page, as ``#rrggbb``."""
        return _COLORS[self]

    @property
    def index(self) -> int:
        """The place of the phase in arrays of length six, 0 to 5."""
        return self.value - 1

    @classmethod
    def parse(cls, text: str) -> Phase:
        """The phase of a name (``"DS"``, ``"distance salutation"``) or a number (``"2"``).

        Raises:
            UnknownNameError: the text names no phase.

        >>> Phase.parse("app")
        <Phase.APP: 4>
        """
        wanted = str(text).strip().upper()
        for phase in cls:
            if wanted in (phase.name, str(phase.value), phase.title.upper()):
                return phase
        raise UnknownNameError("phase", text, [p.name for p in cls])


_TITLES = {
    Phase.IA: "Initiation of Approach",
    Phase.DS: "Distance Salutation",
    Phase.HD: "Head Dip",
    Phase.APP: "Approach",
    Phase.FA: "Final Approach",
    Phase.CS: "Close Salutation",
}

# Okabe & Ito's palette (2008): distinguishable with every common colour vision.
_COLORS = {
    Phase.IA: "#999999",
    Phase.DS: "#E69F00",
    Phase.HD: "#CC79A7",
    Phase.APP: "#56B4E9",
    Phase.FA: "#0072B2",
    Phase.CS: "#009E73",
}

#: The names of the phases in the order of their numbers.
PHASE_NAMES: tuple[str, ...] = tuple(p.name for p in Phase)

#: The phases in which somebody salutes: the others are ways of coming closer.
SALUTATIONS: tuple[Phase, ...] = (Phase.DS, Phase.HD, Phase.CS)
