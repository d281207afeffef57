"""Greetings to evaluate on, made by hand, and readers whose mistakes are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kendon.estimate import Decoder
from kendon.evaluation import Reader
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray
from kendon.phases import Phase

PERIOD = 0.2
#: [m/s], and how near the person comes [m]
WALK, STOP = 1.2, 1.0


def numbers(letters: str) -> IntArray:
    """Phases by one letter each: I D H A F C, ``-`` = not greeting, ``?`` = not labelled."""
    return np.array([{"-": 0, "?": -1}.get(x, "IDHAFC".find(x) + 1) for x in letters])


def stamps(rows: int) -> FloatArray:
    """The ends of intervals of 0.2 s."""
    return np.round(PERIOD * np.arange(1, rows + 1), 6)


def unknown(letters: str, name: str = "") -> Observations:
    """Observations of nothing, with true phases."""
    return Observations(stamps(len(letters)), np.full((len(letters), 7), np.nan),
                        numbers(letters), name)  # fmt: skip


def walk_up(name: str, start: float = 6.0) -> Observations:
    """Somebody who stands for 1 s, walks up and shakes hands for 2 s."""
    rows = [(start, 0.0, Phase.IA)] * 5
    distance = start
    while distance > STOP + 1e-9:
        distance = max(STOP, distance - WALK * PERIOD)
        rows.append((distance, WALK, Phase.APP if distance > 3 else Phase.FA))
    rows += [(STOP, 0.0, Phase.CS)] * 10
    return _observed(rows, name)


def pass_by(name: str) -> Observations:
    """Somebody who walks past, never nearer than 2 m."""
    along = np.arange(-4, 4, WALK * PERIOD)
    distance = np.hypot(along, 2.0)
    speed = -np.gradient(distance, PERIOD)
    rows = list(zip(distance.tolist(), speed.tolist(), [0] * len(along), strict=True))
    return _observed(rows, name)


def _observed(rows: Sequence[tuple[float, float, int]], name: str) -> Observations:
    distance, speed, phases = np.array(rows, dtype=float).T
    values = np.full((len(rows), 7), np.nan)
    values[:, 0], values[:, 1] = distance, speed
    values[:, 2:4] = (1.0, 1.0)
    values[:, 4:] = np.stack([phases == p for p in (Phase.DS, Phase.CS, Phase.HD)], axis=1)
    return Observations(stamps(len(rows)), values, phases.astype(np.int64), name)


@dataclass(frozen=True)
class Scripted:
    """Reads what it was told to, greeting by greeting by their names; the truth if not told."""

    name: str
    told: tuple[tuple[str, str], ...] = ()
    causal: bool = True

    def read(self, observations: Observations) -> IntArray:
        """The phases it was told, shape (T,)."""
        for name, letters in self.told:
            if name == observations.name:
                return numbers(letters)
        assert observations.phases is not None
        return np.maximum(observations.phases, 1)


@dataclass(frozen=True)
class Nearest:
    """Reads the phase whose mean distance is nearest."""

    distances: tuple[float, ...]
    name: str = "nearest"
    causal: bool = True

    def read(self, observations: Observations) -> IntArray:
        """The phases, shape (T,)."""
        away = np.abs(observations.values[:, :1] - np.array(self.distances))
        return np.asarray(away.argmin(axis=1) + 1)


def learn_distances(
    greetings: Sequence[Observations], seed: int, decoders: Sequence[Decoder] = ()
) -> Sequence[Reader]:
    """Learn each phase's mean distance; the seed shifts it, to show that it arrives."""
    values = np.concatenate([g.values[:, 0] for g in greetings])
    phases = np.concatenate([g.phases for g in greetings if g.phases is not None])
    shift = np.random.default_rng(seed).normal(0, 0.5)
    means = [
        float(values[phases == p].mean()) + shift if (phases == p).any() else 1e9 for p in Phase
    ]
    return [Nearest(tuple(means))]
