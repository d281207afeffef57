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
    wave=(-5.71, 0.72, 0.3, 0.83, 0.38, 0.59, 0.72, 0.67, 0.68, 0.48, 0.44),
    handshake=(-1.99, 0.88, 0.44, 0.9, 0.43, 0.65, 0.28, 0.21, 0.82, 0.4),
    nod=(-2.79, 0.34, 0.32, 0.46),
    dip=(-3.61, 0.37, 0.49, 0.46, 0.53, 0.61),
    bow=(-3.43, 0.95, 0.66),
)
