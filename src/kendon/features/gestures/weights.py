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
    wave=(-4.11, 0.78, 0.22, 1.01, 0.42, 0.73, 0.78),
    handshake=(-1.06, 0.89, 0.56, 0.78, 0.49, 0.7),
    nod=(-3.21, 0.16, 0.37),
    dip=(-3.92, 0.51, 0.66, 0.32, 0.56),
    bow=(-3.24, 0.97, 0.52),
)
