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
    wave=(-2.8, 0.37, 0.2, 0.16, 0.65, 0.49, 0.39, 0.65),
    handshake=(-0.5, 0.47, 0.34, 0.0, 0.63, 0.48, 0.72),
    nod=(-2.0, 0.8, 0.8),
    dip=(-3.0, 0.8, 0.4, 0.5, 0.5),
    bow=(-2.5, 0.8, 0.4),
)
