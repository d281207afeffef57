"""A simple body for the person in pictures, of capsules.

They lie where joints are known, else where a standing or walking body of that height has them.
Proportions are those of Drillis and Contini (1966) as shares of the stature.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kendon.geometry import Quaternion, Vec3
from kendon.person import FloatArray

#: Heights and lengths as shares of the stature.
EYES, SHOULDERS, HIPS = 0.936, 0.818, 0.530
_SHOULDER_HALF, _HIP_HALF = 0.12, 0.055
_UPPER_ARM, _FOREARM, _HAND = 0.186, 0.146, 0.075
_THIGH, _SHANK, _ANKLE, _FOOT = 0.245, 0.246, 0.039, 0.10
#: The way of two steps as a share of the stature, at an easy walk.
STRIDE = 0.8
#: How far the legs swing at full stride, and the arms against them [rad].
_LEG_SWING, _ARM_SWING = 0.42, 0.3

_UP: FloatArray = np.array([0.0, 0.0, 1.0])

Color = tuple[float, float, float, float]
_SKIN: Color = (0.87, 0.68, 0.56, 1)
_HAIR: Color = (0.25, 0.17, 0.12, 1)
_SHIRT: Color = (0.87, 0.56, 0.23, 1)
_TROUSERS: Color = (0.24, 0.28, 0.40, 1)
_SHOES: Color = (0.16, 0.14, 0.14, 1)
_DARK: Color = (0.10, 0.08, 0.08, 1)
_LIPS: Color = (0.66, 0.30, 0.29, 1)


class Shape(NamedTuple):
    """A capsule between two points, or a ball where they are the same."""

    start: FloatArray  # (3,) [m], world
    end: FloatArray
    radius: float  # [m]
    color: Color


@dataclass(frozen=True, slots=True)
class Stance:
    """How the person holds themselves at one instant, as far as joints do not tell."""

    head: Vec3  # [m], the face, world
    head_rotation: Quaternion  # x out of the face
    heading: float  # [rad], where the body faces
    joints: Mapping[str, Vec3]  # [m], world; by the names of `kendon.person.JOINTS`
    smile: float = 0.0  # [0-5]
    walked: float = 0.0  # [m] so far
    stride: float = 0.0  # how much they walk, 0 stands, 1 strides
    wave: float = 0.0  # how far the right hand is raised, 0 to 1
    swing: float = 0.0  # where a waving hand is, -1 to 1
    reach: float = 0.0  # how far it is held out, 0 to 1
    target: Vec3 | None = None  # [m], to what, world
    stature: float = math.nan  # [m]; NaN = as the face's height tells of one who stands upright

    @property
    def size(self) -> float:
        """How tall the person is [m]."""
        return self.head[2] / EYES if math.isnan(self.stature) else self.stature


def shapes(stance: Stance) -> list[Shape]:
    """The body as capsules and balls."""
    place = _Skeleton(stance).points
    size = stance.size
    drawn = list(_head(stance, size))
    ls, rs, lh, rh = (place[n] for n in ("l_shoulder", "r_shoulder", "l_hip", "r_hip"))
    neck, pelvis = (ls + rs) / 2, (lh + rh) / 2
    r = size / 1.72
    drawn.append(Shape(neck, neck + 0.07 * size * _UP, 0.052 * r, _SKIN))
    chest = neck - 0.09 * size * _UP
    drawn.append(Shape(chest + (ls - neck) * 0.42, chest + (rs - neck) * 0.42, 0.125 * r, _SHIRT))
    drawn.append(Shape(chest, pelvis + 0.06 * size * _UP, 0.130 * r, _SHIRT))
    drawn.append(Shape(lh, rh, 0.115 * r, _TROUSERS))
    for side in "lr":
        shoulder, elbow, wrist = (place[f"{side}_{n}"] for n in ("shoulder", "elbow", "wrist"))
        hip, knee, ankle, toe = (place[f"{side}_{n}"] for n in ("hip", "knee", "ankle", "toe"))
        hand = wrist + _unit(wrist - elbow) * _HAND * size
        drawn += [
            Shape(shoulder, elbow, 0.052 * r, _SHIRT),
            Shape(elbow, wrist, 0.040 * r, _SKIN),
            Shape(wrist + (hand - wrist) * 0.3, hand, 0.038 * r, _SKIN),
            Shape(hip, knee, 0.078 * r, _TROUSERS),
            Shape(knee, ankle, 0.056 * r, _TROUSERS),
            Shape(ankle - 0.02 * r * _UP, toe, 0.044 * r, _SHOES),
        ]
    return drawn


class _Skeleton:
    """All points of the body: those that are known, and those that follow from the stance."""

    def __init__(self, stance: Stance) -> None:
        self.stance = stance
        self.size = stance.size
        c, s = math.cos(stance.heading), math.sin(stance.heading)
        self.ahead = np.array([c, s, 0.0])
        self.left = np.array([-s, c, 0.0])
        # The face looks out of the front of the head; the body hangs below its middle.
        middle = np.array(stance.head) - 0.055 * self.size * self.ahead
        self.column = np.array([middle[0], middle[1], 0.0])
        self.points: dict[str, FloatArray] = {}
        for side, sign in (("l", 1.0), ("r", -1.0)):
            self._trunk(side, sign)
            self._leg(side, sign)
            self._arm(side, sign)

    def _take(self, name: str, otherwise: FloatArray) -> FloatArray:
        known = self.stance.joints.get(name)
        point = np.array(known) if known is not None and np.isfinite(known).all() else otherwise
        self.points[name] = point
        return point

    def _trunk(self, side: str, sign: float) -> None:
        size, out = self.size, sign * self.left
        shoulder = self.column + size * (SHOULDERS * _UP + _SHOULDER_HALF * out)
        if side == "r":
            shoulder = shoulder + size * self.stance.reach * (0.09 * self.ahead - 0.01 * _UP)
        self._take(f"{side}_shoulder", shoulder)
        self._take(f"{side}_hip", self.column + size * (HIPS * _UP + _HIP_HALF * out))

    def _leg(self, side: str, sign: float) -> None:
        stance, size = self.stance, self.size
        hip = self.points[f"{side}_hip"]
        beat = 2 * math.pi * stance.walked / (STRIDE * size)
        swing = sign * _LEG_SWING * stance.stride * math.sin(beat)
        # The knee bends while the leg comes forward.
        bend = 0.08 + 1.0 * stance.stride * max(0.0, sign * math.cos(beat)) ** 2
        knee = hip + _THIGH * size * self._down(swing + 0.4 * bend)
        ankle = knee + _SHANK * size * self._down(swing - 0.6 * bend)
        lift = max(0.0, _ANKLE * size - float(ankle[2]))
        knee, ankle = knee + lift / 2 * _UP, ankle + lift * _UP
        toe = ankle + _FOOT * size * (self.ahead - 0.12 * _UP)
        self.points |= {f"{side}_knee": knee, f"{side}_ankle": ankle, f"{side}_toe": toe}

    def _arm(self, side: str, sign: float) -> None:
        stance, size, out = self.stance, self.size, sign * self.left
        shoulder = self.points[f"{side}_shoulder"]
        beat = 2 * math.pi * stance.walked / (STRIDE * size)
        swing = -sign * _ARM_SWING * stance.stride * math.sin(beat)
        elbow = shoulder + _UPPER_ARM * size * _unit(self._down(swing) + 0.12 * out)
        wrist = elbow + _FOREARM * size * _unit(self._down(swing + 0.25) + 0.05 * out)
        if side == "r" and stance.wave > 0:
            tip = out * (0.25 + 0.45 * stance.swing) + _UP
            raised = shoulder + _UPPER_ARM * size * _unit(0.75 * out + 0.35 * self.ahead)
            hand = raised + _FOREARM * size * _unit(tip + 0.1 * self.ahead)
            wrist = wrist + stance.wave * (hand - wrist)
            elbow = self._bend(shoulder, wrist, out - 0.6 * _UP)
        if side == "r" and stance.reach > 0:
            target = np.array(stance.target) if stance.target is not None else (
                shoulder + size * (0.28 * self.ahead + 0.06 * self.left - 0.16 * _UP)
            )  # fmt: skip
            grip = target - _HAND * size * _unit(target - shoulder)
            wrist = wrist + stance.reach * (grip - wrist)
            elbow = self._bend(shoulder, wrist, 0.5 * out - _UP)
        elbow = self._take(f"{side}_elbow", elbow)
        self._take(f"{side}_wrist", self._within(shoulder, wrist) if stance.reach else wrist)

    def _down(self, swing: float) -> FloatArray:
        """The direction of a limb that hangs, swung ahead by an angle [rad]."""
        direction: FloatArray = math.sin(swing) * self.ahead - math.cos(swing) * _UP
        return direction

    def _within(self, shoulder: FloatArray, wrist: FloatArray) -> FloatArray:
        """The wrist, or the nearest place to it that the arm reaches."""
        way = wrist - shoulder
        length = float(np.linalg.norm(way))
        reach: FloatArray = shoulder + way * min(1.0, (_UPPER_ARM + _FOREARM) * self.size / length)
        return reach

    def _bend(self, shoulder: FloatArray, wrist: FloatArray, toward: FloatArray) -> FloatArray:
        """The elbow of an arm whose wrist is given, on the side of a direction (law of cosines)."""
        way = self._within(shoulder, wrist) - shoulder
        d = float(np.linalg.norm(way))
        upper, fore = _UPPER_ARM * self.size, _FOREARM * self.size
        along = (upper**2 - fore**2 + d**2) / (2 * d)
        aside = math.sqrt(max(0.0, upper**2 - along**2))
        axis = way / d
        elbow: FloatArray = shoulder + along * axis + aside * _unit(toward - (toward @ axis) * axis)
        return elbow


def _head(stance: Stance, size: float) -> list[Shape]:
    from scipy.spatial.transform import Rotation  # half a second: not for those who need none

    known = np.isfinite(stance.head_rotation).all()
    turn = Rotation.from_quat(stance.head_rotation) if known else (
        Rotation.from_euler("z", stance.heading)
    )  # fmt: skip
    r = size / 1.72
    face = np.array(stance.head)

    def at(x: float, y: float, z: float) -> FloatArray:
        place: FloatArray = face + r * turn.apply([x - 0.015, y, z])
        return place

    drawn = [
        Shape(at(-0.09, 0, 0.035), at(-0.085, 0, -0.03), 0.098 * r, _SKIN),
        Shape(at(-0.115, 0, 0.055), at(-0.125, 0, 0.0), 0.100 * r, _HAIR),
        Shape(at(0.005, 0, 0.0), at(0.017, 0, -0.022), 0.012 * r, _SKIN),
    ]
    for y in (0.035, -0.035):
        drawn.append(Shape(at(-0.002, y, 0.022), at(-0.002, y, 0.022), 0.013 * r, _DARK))
        drawn.append(Shape(at(-0.093, 2.75 * y, 0.0), at(-0.093, 2.75 * y, 0.0), 0.022 * r, _SKIN))
        # A smile lifts the corners of the mouth.
        lift = 0.006 * min(stance.smile, 3.0)
        corner = at(-0.006, 0.85 * y, -0.065 + lift)
        drawn.append(Shape(at(0.003, 0, -0.068), corner, 0.006 * r, _LIPS))
    return drawn


def _unit(v: FloatArray) -> FloatArray:
    unit: FloatArray = v / np.linalg.norm(v)
    return unit
