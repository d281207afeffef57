"""How well a model reads the experiments, online and label by label (thesis table 3.8)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kendon.experiments.scenes import Scene
from kendon.features import observe
from kendon.geometry import Pose2D
from kendon.models import GreetingModel
from kendon.models.intent import Intent
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray, Track

#: From this probability on somebody counts as greeting, as in the shipped trees.
GREETS = 0.6


@dataclass(frozen=True, eq=False)
class Reading:
    """What one model made of one person in one experiment."""

    scene: Scene
    observations: Observations
    probabilities: FloatArray  # (T, 6), the filtered belief
    greets: FloatArray  # (T,), the probability that the person means to greet

    @property
    def truth(self) -> IntArray:
        """The labels, 0 = not greeting, (T,)."""
        assert self.observations.phases is not None
        return self.observations.phases

    @property
    def read(self) -> IntArray:
        """The most probable phases, (T,)."""
        return np.asarray(self.probabilities.argmax(axis=1) + 1)

    @property
    def right(self) -> FloatArray:
        """Which labels were read: the phase, or that nobody greets; (T,), 0 or 1."""
        nobody = self.truth == 0
        return np.where(nobody, self.greets < GREETS, self.read == self.truth).astype(float)

    @property
    def correct(self) -> int:
        """How many."""
        return int(self.right.sum())

    @property
    def labels(self) -> int:
        """Of how many."""
        return len(self.truth)


def read(scene: Scene, model: GreetingModel, *, keys: bool, seed: int = 0) -> Reading:
    """Play an experiment and filter it as it goes.

    Args:
        scene: which.
        model: reads the phases.
        keys: whether gestures are given by hand, as the thesis's keys gave them, or detected.
        seed: whose body.
    """
    track = scene.record(keys=keys, seed=seed)
    observations = observe(track)
    tracker = model.tracker()
    beliefs = [tracker.step(row).probabilities for row in observations.values]
    return Reading(scene, observations, np.array(beliefs), _intent(track, observations))


def _intent(track: Track, observations: Observations) -> FloatArray:
    """The belief that the person means to greet, after each observation."""
    intent, place, found = Intent(), 0, []
    for row in observations:
        while place < len(track) and track.t[place] <= row.t + 1e-9:
            head, robot = track.head[place].tolist(), Pose2D(*track.robot[place].tolist())
            if np.isfinite(head).all():
                x, y, _ = robot.to_world((head[0], head[1], head[2]))
                intent.see(float(track.t[place]), x, y)
            place += 1
        found.append(intent.step(row, robot[:2]))
    return np.array(found)


@dataclass(frozen=True)
class Tally:
    """How many labels were read in an experiment, over several bodies."""

    scene: Scene
    labels: int
    correct: tuple[int, ...]  # one a body

    @property
    def mean(self) -> float:
        """Labels read, on average."""
        return float(np.mean(self.correct))

    @property
    def share(self) -> float:
        """Of all."""
        return self.mean / self.labels


def tally(
    scenes: Sequence[Scene],
    model: GreetingModel,
    *,
    keys: bool,
    bodies: int,
    progress: Callable[[], None] | None = None,
) -> list[Tally]:
    """Read experiments, each with so many bodies; with keys and no noise one tells all."""
    found = []
    for scene in scenes:
        seeds = range(1 if keys and scene.labels else bodies)
        readings = [read(scene, model, keys=keys, seed=seed) for seed in seeds]
        found.append(Tally(scene, readings[0].labels, tuple(r.correct for r in readings)))
        if progress:
            progress()
    return found
