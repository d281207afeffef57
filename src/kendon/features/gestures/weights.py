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
    wave=(-5.12, 0.67, 0.33, 0.85, 0.39, 0.63, 0.7, 0.74, 0.71, 0.43, 0.49),
    handshake=(-1.47, 0.89, 0.64, 0.84, 0.39, 0.7, 0.49, 0.19, 0.38),
    nod=(-2.88, 0.3, 0.33, 0.27),
    dip=(-3.64, 0.3, 0.52, 0.57, 0.61, 0.52),
    bow=(-3.32, 0.99, 0.65),
)
