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
    wave=(-4.87, 0.86, 0.14, 0.84, 0.8, 0.79, 0.4, 0.73, 0.71, 0.46, 0.2, 0.38),
    handshake=(-2.87, 0.97, 0.4, 1.17, 0.18, 0.68, 0.32, 0.05, 0.88, 0.36, 0.62),
    nod=(-3.34, 0.36, 0.36, 0.15),
    dip=(-4.13, 0.08, 0.2, 0.73, 0.34, 0.52, 0.17, 0.38),
    bow=(-3.49, 1.13, 0.52),
)
