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
    wave=(-4.77, 0.93, 0.07, 0.93, 0.8, 0.58, 0.41, 0.93, 0.67, 0.42, 0.3, 0.38),
    handshake=(-2.7, 1.06, 0.25, 1.12, 0.32, 0.7, 0.22, 0.0, 0.84, 0.29, 0.64),
    nod=(-3.45, 0.27, 0.25, 0.06),
    dip=(-4.09, 0.06, 0.29, 0.52, 0.3, 0.6, 0.2, 0.47),
    bow=(-3.28, 1.11, 0.42),
)
