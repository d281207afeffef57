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
    wave=(-5.59, 0.73, 0.28, 0.84, 0.41, 0.6, 0.69, 0.68, 0.68, 0.47, 0.33),
    handshake=(-1.89, 0.91, 0.44, 0.96, 0.45, 0.65, 0.35, 0.14, 0.78, 0.4),
    nod=(-3.18, 0.41, 0.41, 0.43),
    dip=(-3.54, 0.37, 0.48, 0.45, 0.52, 0.63),
    bow=(-3.53, 0.98, 0.68),
)
