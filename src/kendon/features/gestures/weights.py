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
    wave=(-4.41, 0.67, 0.34, 0.69, 0.73, 0.64, 0.72, 0.73, 0.41, 0.42, 0.38, 0.45, 0.44),
    handshake=(-3.29, 0.96, 0.51, 1.06, 0.28, 0.65, 0.21, 0.09, 0.86, 0.21, 0.63, 0.32, 0.43, 0.3),
    nod=(-3.24, 0.5, 0.28, 0.57),
    dip=(-3.77, 0.11, 0.25, 0.59, 0.35, 0.52, 0.22, 0.4),
    dip_of_pitch=(-3.41, 0.32, 0.35, 0.5, 0.49, 0.75),
    bow=(-3.23, 1.1, 0.47),
)
