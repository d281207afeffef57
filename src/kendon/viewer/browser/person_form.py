"""The person as the page draws them: what a source tells of them, in few numbers, and a body."""

from __future__ import annotations

import math

import numpy as np

from kendon.geometry import ORIGIN, quaternion_yaw, wrap_angle
from kendon.person import JOINTS, FloatArray, PersonFrame
from kendon.simulation.body import FACE_HEIGHT
from kendon.viewer.browser.forms import Float32Array, Pieces, rgb
from kendon.viewer.mannequin import Stance, shapes

#: Over how long a person's speed is smoothed, and a heading read off a face [s].
_SMOOTH, _TURN = 0.25, 0.6
#: Slower than this a person stands, and at this they stride fully [m/s].
_STANDS, _STRIDES = 0.12, 0.9
#: Faces whose height is unknown are drawn here [m].
_USUAL_HEIGHT = 1.6


class Follower:
    """Follows a person frame by frame: where their body faces, and how their legs go."""

    def __init__(self) -> None:
        self._lose()

    def _lose(self) -> None:
        self._t = math.nan
        self._place: FloatArray = np.full(2, math.nan)
        self._velocity: FloatArray = np.zeros(2)
        self._passed = 0.0  # [s], since the frame before
        self._walked = 0.0
        self._heading = math.nan
        self._tallest = math.nan  # [m], how high the face has been

    def take(self, frame: PersonFrame) -> Float32Array | None:
        """The person of a frame as a row of numbers for `draw_person`; None out of sight."""
        if not frame.seen:
            self._lose()
            return None
        frame = frame.seen_from(ORIGIN)
        joints = np.array(
            [frame.joints.get(name, (math.nan,) * 3) for name in JOINTS], dtype=np.float64
        )
        hips = joints[[JOINTS.index("l_hip"), JOINTS.index("r_hip")], :2].mean(axis=0)
        place = hips if np.isfinite(hips).all() else np.array(frame.head[:2])
        self._move(frame.t, place)
        self._turn(frame, joints)
        speed = float(np.hypot(*self._velocity))
        stride = float(np.clip((speed - _STANDS) / (_STRIDES - _STANDS), 0.0, 1.0))
        smile = 0.0 if math.isnan(frame.smile) else frame.smile
        self._tallest = float(np.fmax(self._tallest, frame.head[2]))  # who bows is no shorter
        return np.array(
            [*frame.head, *frame.head_rotation, self._heading, self._walked, stride, smile,
             self._tallest / FACE_HEIGHT, *joints.ravel()],
            dtype=np.float32,
        )  # fmt: skip

    def _move(self, t: float, place: FloatArray) -> None:
        passed = t - self._t
        if 0 < passed < 1.0:
            step = place - self._place
            share = -math.expm1(-passed / _SMOOTH)
            self._velocity += (step / passed - self._velocity) * share
            self._walked += float(np.hypot(*self._velocity)) * passed
            self._passed = passed
        else:
            self._velocity = np.zeros(2)
            self._passed = 0.0
        self._t, self._place = t, place

    def _turn(self, frame: PersonFrame, joints: FloatArray) -> None:
        """Square to the shoulders; without them where the face looks, more slowly."""
        across = joints[JOINTS.index("l_shoulder"), :2] - joints[JOINTS.index("r_shoulder"), :2]
        if np.isfinite(across).all() and across.any():
            self._heading = math.atan2(-across[0], across[1])
            return
        yaw = quaternion_yaw(frame.head_rotation)
        if math.isnan(yaw):  # as likely as not they face the robot
            yaw = math.atan2(frame.robot.y - frame.head[1], frame.robot.x - frame.head[0])
        if math.isnan(self._heading):
            self._heading = yaw
        self._heading += wrap_angle(yaw - self._heading) * -math.expm1(-self._passed / _TURN)


def draw_person(row: Float32Array) -> Pieces:
    """A person's body."""
    pieces = Pieces()
    for shape in shapes(stance(row)):
        pieces.capsule(shape.start, shape.end, shape.radius, rgb(shape.color))
    return pieces


def stance(row: Float32Array) -> Stance:
    """A row of `Follower.take` as the mannequin takes it."""
    numbers = row.astype(float).tolist()
    x, y, z = numbers[:3]
    joints = np.reshape(numbers[12:], (-1, 3))
    return Stance(
        head=(x, y, _USUAL_HEIGHT if math.isnan(z) else z),
        head_rotation=(numbers[3], numbers[4], numbers[5], numbers[6]),
        heading=numbers[7],
        joints={
            name: (p[0], p[1], p[2])
            for name, p in zip(JOINTS, joints.tolist(), strict=True)
            if not math.isnan(p[0])
        },
        walked=numbers[8],
        stride=numbers[9],
        smile=numbers[10],
        stature=numbers[11],
    )
