"""The body of a simulated person: stature, proportions, and habits of standing and walking."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kendon.errors import ParameterError

#: Lengths and heights as shares of stature: Drillis & Contini (1966), as Winter's Biomechanics
#: and Motor Control of Human Movement prints them (figure 4.1).
UPPER_ARM, FOREARM = 0.186, 0.146
SHOULDER_HEIGHT, HIP_HEIGHT = 0.818, 0.530
_EYE_HEIGHT, _CHIN_HEIGHT = 0.936, 0.870
#: The face, midway between eyes and chin, above the middle of the neck about which heads bend,
#: and before it: about half the length of a head.
FACE_HEIGHT = (_EYE_HEIGHT + _CHIN_HEIGHT) / 2
NECK_HEIGHT = 0.86
FACE_AHEAD = 0.055
#: From joint centre to joint centre: shoulders lie 2 to 3 cm inside the acromia, which are 0.259
#: apart; hips 36 % of the way between the front spines of the pelvis from each (Bell et al. 1990).
SHOULDER_WIDTH, HIP_WIDTH = 0.215, 0.105
#: Length of a step over steps a second, at a stature of 1.7 m [m s]: what people keep constant
#: from slow to fast (Sekiya & Nagasaki 1998: 0.0064 m a step a minute).
WALK_RATIO = 0.384


@dataclass(frozen=True)
class Body:
    """Somebody's measures and habits.

    Raises:
        ParameterError: a measure is not positive, or the preferred hand is none.
    """

    stature: float = 1.7  # [m]
    arms: float = 1.0  # length of the arms, as a share of what the stature lets expect
    trunk: float = 1.0  # from hips to shoulders, likewise
    breadth: float = 1.0  # of shoulders and hips, likewise
    handed: str = "r"  # the preferred hand
    swing: float = 1.0  # of the arms in walking, as a share of the usual
    pace: float = 1.0  # length of steps at a speed, likewise
    outward: float = 0.12  # [rad], how far the arms hang from the body
    elbow: float = 0.25  # [rad], how far the elbows bend when the arms hang
    stoop: float = 0.03  # [rad], how far the trunk leans forward
    sway: float = 1.0  # of a standing person, as a share of the usual
    bob: float = 0.02  # [rad], how far the head pitches each way at usual steps
    phase: float = 0.0  # [rad], where in their sway they are at time 0

    def __post_init__(self) -> None:
        for name in ("stature", "arms", "trunk", "breadth", "pace"):
            if not 0 < getattr(self, name) < math.inf:
                raise ParameterError(f"a body's {name} must be positive, not {getattr(self, name)}")
        if self.handed not in ("l", "r"):
            raise ParameterError(f"a body's preferred hand is l or r, not {self.handed!r}")

    @cached_property
    def upper_arm(self) -> float:
        """From shoulder to elbow [m]."""
        return UPPER_ARM * self.stature * self.arms

    @cached_property
    def forearm(self) -> float:
        """From elbow to wrist [m]."""
        return FOREARM * self.stature * self.arms

    @cached_property
    def reach(self) -> float:
        """From shoulder to wrist of a straight arm [m]."""
        return self.upper_arm + self.forearm

    @cached_property
    def torso(self) -> float:
        """From the hips' height to the shoulders' [m]."""
        return (SHOULDER_HEIGHT - HIP_HEIGHT) * self.stature * self.trunk

    @cached_property
    def hip_height(self) -> float:
        """Above the floor, standing [m]. What the trunk lacks the legs have."""
        return SHOULDER_HEIGHT * self.stature - self.torso

    @cached_property
    def half_shoulders(self) -> float:
        """From the middle of the trunk to a shoulder [m]."""
        return SHOULDER_WIDTH / 2 * self.stature * self.breadth

    @cached_property
    def half_hips(self) -> float:
        """From the middle of the pelvis to a hip [m]."""
        return HIP_WIDTH / 2 * self.stature * self.breadth

    @cached_property
    def neck(self) -> float:
        """From the shoulders' height to the middle of the neck [m]."""
        return (NECK_HEIGHT - SHOULDER_HEIGHT) * self.stature

    @cached_property
    def face(self) -> tuple[float, float]:
        """How far the face is before the middle of the neck, and above it [m]."""
        return FACE_AHEAD * self.stature, (FACE_HEIGHT - NECK_HEIGHT) * self.stature

    def steps_per_second(self, speed: float) -> float:
        """At a walking speed [m/s]."""
        return math.sqrt(max(speed, 0.0) / self.walk_ratio)

    @cached_property
    def walk_ratio(self) -> float:
        """Length of a step over steps a second [m s]; longer legs take longer steps."""
        return WALK_RATIO * self.stature / 1.7 * self.pace


def draw_body(rng: np.random.Generator, stature: float | None = None) -> Body:
    """Draw somebody.

    Statures of adults of both sexes, and some taller children; proportions within about 4 %; one
    in ten left-handed (Papadatou-Pastou et al. 2020). The habits' ranges are ours.

    Args:
        rng: chance.
        stature: if it is known [m].
    """
    drawn = float(np.clip(rng.normal(1.69, 0.1), 1.4, 2.02))
    arms, trunk, breadth = np.clip(rng.normal(1.0, 0.035, 3), 0.9, 1.1)
    return Body(
        stature=drawn if stature is None else stature,
        arms=float(arms),
        trunk=float(trunk),
        breadth=float(breadth) * float(rng.uniform(0.85, 1.1)),
        handed="l" if rng.random() < 0.106 else "r",
        swing=float(rng.uniform(0.4, 1.3)),
        pace=float(rng.uniform(0.9, 1.1)),
        outward=float(rng.uniform(0.06, 0.25)),
        elbow=float(rng.uniform(0.12, 0.5)),
        stoop=float(rng.uniform(-0.02, 0.10)),
        sway=float(rng.uniform(0.4, 1.6)),
        bob=float(rng.spawn(1)[0].uniform(0.0, 0.05)),
        phase=float(rng.uniform(0, 2 * math.pi)),
    )


def draw_walker(rng: np.random.Generator, brisk: float, stature: float | None = None) -> Body:
    """Draw somebody; some walk with bent elbows, so that their hands swing up to the chest.

    Args:
        rng: chance.
        brisk: the share of those; the numbers are ours.
        stature: if it is known [m].
    """
    body = draw_body(rng, stature)
    if rng.random() < brisk:
        elbow, swing = float(rng.uniform(0.5, 1.4)), float(rng.uniform(1.0, 2.2))
        body = replace(body, elbow=elbow, swing=swing)
    return body
