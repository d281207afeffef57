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
    wave=(-4.16, 0.6, 0.2, 0.66, 0.54, 0.75, 0.77, 0.76, 0.5, 0.42, 0.47),
    handshake=(-2.92, 1.06, 0.39, 1.14, 0.36, 0.67, 0.32, 0.08, 0.81, 0.38, 0.63),
    nod=(-3.34, 0.26, 0.31, 0.17),
    dip=(-4.06, 0.14, 0.29, 0.66, 0.27, 0.42, 0.15, 0.36),
    bow=(-3.34, 1.07, 0.59),
)
