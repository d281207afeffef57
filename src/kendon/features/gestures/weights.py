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
    wave=(-5.61, 0.73, 0.24, 0.78, 0.71, 0.56, 0.77, 0.67, 0.65, 0.51, 0.36, 0.48),
    handshake=(-2.54, 0.94, 0.45, 0.93, 0.44, 0.65, 0.34, 0.15, 0.81, 0.42, 0.61),
    nod=(-3.16, 0.43, 0.4, 0.45),
    dip=(-3.91, 0.09, 0.32, 0.58, 0.4, 0.47, 0.28, 0.48),
    bow=(-3.34, 0.97, 0.63),
)
