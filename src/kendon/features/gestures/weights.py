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
    wave=(-4.48, 0.61, 0.34, 0.69, 0.65, 0.69, 0.78, 0.73, 0.47, 0.47, 0.42, 0.42, 0.4),
    handshake=(-3.04, 0.98, 0.55, 1.14, 0.41, 0.67, 0.34, 0.16, 0.75, 0.27, 0.62, 0.4, 0.46),
    nod=(-3.25, 0.52, 0.31, 0.54),
    dip=(-3.85, 0.13, 0.24, 0.64, 0.31, 0.5, 0.23, 0.43),
    dip_of_pitch=(-3.43, 0.35, 0.35, 0.57, 0.41, 0.74),
    bow=(-3.4, 1.04, 0.67),
)
