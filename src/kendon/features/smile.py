"""The smile of a person (thesis 3.3.4)."""

from __future__ import annotations

import numpy as np

from kendon.person import FloatArray


def smile(au06: FloatArray, au12: FloatArray) -> FloatArray:
    """The mean of cheek raiser and lip corner puller (thesis 3.11), kept within 0 to 5.

    Args:
        au06: intensity of Action Unit 6, shape (...) [0-5].
        au12: intensity of Action Unit 12, shape (...) [0-5].

    Returns:
        Shape (...) [0-5]; NaN where either is unknown.
    """
    return np.clip((np.asarray(au06) + np.asarray(au12)) / 2, 0, 5)
