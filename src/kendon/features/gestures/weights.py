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
    dip_of_pitch: tuple[float, ...]  # from where the face points alone
    bow: tuple[float, ...]


WEIGHTS = Weights(
    wave=(-4.21, 0.7, 0.19, 0.7, 0.55, 0.75, 0.76, 0.76, 0.57, 0.46, 0.42),
    handshake=(-2.8, 1.01, 0.41, 1.17, 0.37, 0.66, 0.34, 0.07, 0.75, 0.33, 0.62),
    nod=(-3.28, 0.53, 0.31, 0.54),
    dip=(-3.96, 0.11, 0.23, 0.66, 0.29, 0.5, 0.37, 0.19, 0.45),
    dip_of_pitch=(-3.54, 0.3, 0.33, 0.6, 0.41, 0.79, 0.41),
    bow=(-3.39, 1.05, 0.67),
)
