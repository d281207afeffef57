"""How much each kind of evidence counts: log odds without evidence, then one weight a kind.

Fitted to simulated bodies by ``python scripts/fit_gestures.py``, which prints this table.
"""

from __future__ import annotations

from typing import NamedTuple


class Weights(NamedTuple):
    """The weights of every gesture, each as `kendon.features.gestures.evidence.posterior` takes."""

    wave: tuple[float, ...]  # of one hand
    handshake: tuple[float, ...]  # of one hand
    nod: tuple[float, ...]
    dip: tuple[float, ...]
    bow: tuple[float, ...]


WEIGHTS = Weights(
    wave=(-4.17, 0.79, 0.24, 1.0, 0.45, 0.7, 0.75),
    handshake=(-0.71, 0.73, 0.49, 0.72, 0.42, 0.73),
    nod=(-3.26, 0.16, 0.28),
    dip=(-3.96, 0.51, 0.64, 0.28, 0.71),
    bow=(-3.16, 0.96, 0.43),
)
