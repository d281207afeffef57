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
    toss: tuple[float, ...]
    dip: tuple[float, ...]
    dip_of_pitch: tuple[float, ...]  # from where the face points alone
    bow: tuple[float, ...]
    bow_of_height: tuple[float, ...]  # where the hips are not seen


WEIGHTS = Weights(
    wave=(-4.58, 0.67, 0.34, 0.74, 0.72, 0.65, 0.75, 0.75, 0.39, 0.43, 0.45, 0.42, 0.41, 0.54),
    handshake=(-2.86, 0.96, 0.5, 1.07, 0.35, 0.65, 0.18, 0.08, 0.42, 0.22, 0.62, 0.31, 0.43,
        0.3, 0.6),
    nod=(-4.01, 0.51, 0.34, 0.65, 0.49),
    toss=(-4.55, 0.51, 0.55, 0.62),
    dip=(-3.81, 0.11, 0.26, 0.56, 0.34, 0.48, 0.18, 0.47),
    dip_of_pitch=(-3.39, 0.33, 0.36, 0.49, 0.49, 0.74),
    bow=(-0.77, 1.25, 0.61),
    bow_of_height=(-3.25, 1.16, 0.72),
)  # fmt: skip
