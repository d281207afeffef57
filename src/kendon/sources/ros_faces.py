"""Faces as messages: `FaceExtraction` (thesis 3.3) to `PersonFrame`, and back."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from kendon.errors import DataError
from kendon.features.smile import smile
from kendon.geometry import UNKNOWN_POINT, UNKNOWN_ROTATION, Pose2D, Quaternion, Vec3, compose
from kendon.person import GESTURES, JOINTS, PersonFrame
from kendon.tracks import MAX_COORDINATE


def frame_of_face(
    message: Any, t: float, robot: Pose2D, *, bases: tuple[str, ...], who: int | None = None
) -> PersonFrame:
    """The person of a `FaceExtraction`, of ROS 1 or ROS 2.

    Args:
        message: with the fields of its definition.
        t: when it holds [s].
        robot: where the robot was then.
        bases: the names that its base frame may have; no name is one of them.
        who: which of several people it is.

    Raises:
        DataError: it is not given in the robot's base frame, its lists do not fit, or a number is
            out of its range.
    """
    frame = message.header.frame_id.lstrip("/")
    if frame and frame not in bases:
        raise DataError(
            f"faces are given in the robot's base frame, {' or '.join(bases)}, not in {frame!r}"
        )
    if len(message.joint_names) != len(message.joints):
        raise DataError(
            f"a face has {len(message.joint_names)} joint_names but {len(message.joints)} joints"
        )
    _check(message)
    gaze = _direction(message.left_eye_gaze), _direction(message.right_eye_gaze)
    eyes = _middle(message.left_eye_borders), _middle(message.right_eye_borders)
    looks = all(math.isfinite(v) for pair in (*gaze, *eyes) for v in pair)
    # An intensity without an end is none.
    au06, au12 = (v if math.isfinite(v) else math.nan for v in map(float, message.action_units))
    turn = message.face_rotation
    given = {key: getattr(message, key) for key in GESTURES} if message.gestures_given else {}
    return PersonFrame(
        t,
        _point(message.face),
        rotation_of(turn.x, turn.y, turn.z),
        eyes if looks else None,
        gaze if looks else None,
        {
            name: _point(point)
            for name, point in zip(message.joint_names, message.joints, strict=True)
            if name in JOINTS
        },
        float(smile(np.array(au06), np.array(au12))),
        robot=robot,
        who=who,
        **given,
    )


def _check(message: Any) -> None:
    """Refuse what cannot be, before it is measured or believed; NaN is unknown.

    Raises:
        DataError: a number is out of its range.
    """
    borders = (*message.left_eye_borders, *message.right_eye_borders)
    for point in (message.face, *borders, *message.joints):
        if far := [value for value in _point(point) if abs(value) > MAX_COORDINATE]:
            raise DataError(
                f"a coordinate of {far[0]:g} is not within {MAX_COORDINATE:g} m (ROS counts in"
                " metres; are these millimetres?)"
            )
    for key in GESTURES if message.gestures_given else ():
        if not (0 <= (value := getattr(message, key)) <= 1 or math.isnan(value)):
            raise DataError(f"{key} is a probability, from 0 to 1, not {value:g}")


def fill_face(message: Any, frame: PersonFrame, point: Callable[..., Any]) -> Any:
    """Write a person into a `FaceExtraction`, except its header; return it.

    Args:
        message: an empty one.
        frame: the person, in the robot's base frame.
        point: the class of ``geometry_msgs/Point``.
    """
    eyes = frame.eyes or (UNKNOWN_POINT, UNKNOWN_POINT)
    gaze = frame.eye_gaze or (UNKNOWN_POINT, UNKNOWN_POINT)
    for side, eye, look in zip(("left", "right"), eyes, gaze, strict=True):
        _set(getattr(message, f"{side}_eye_gaze"), look)
        # Only the eyes' centres are known: both borders lie there.
        setattr(message, f"{side}_eye_borders", [point(*eye), point(*eye)])
    _set(message.face, frame.head)
    _set(message.face_rotation, angles_of(frame.head_rotation))
    message.action_units = [frame.smile, frame.smile]
    message.face_id = "" if frame.who is None else str(frame.who)
    message.joint_names = list(frame.joints)
    message.joints = [point(*place) for place in frame.joints.values()]
    given = {key: getattr(frame, key) for key in GESTURES}
    message.gestures_given = any(math.isfinite(value) for value in given.values())
    for key, value in given.items():
        setattr(message, key, value)
    return message


def rotation_of(roll: float, pitch: float, yaw: float) -> Quaternion:
    """The rotation about the fixed axes x, then y, then z [rad]; unknown if one is NaN."""
    if not all(map(math.isfinite, (roll, pitch, yaw))):
        return UNKNOWN_ROTATION
    about = [(math.sin(angle / 2), math.cos(angle / 2)) for angle in (roll, pitch, yaw)]
    (sx, cx), (sy, cy), (sz, cz) = about
    return compose((0.0, 0.0, sz, cz), compose((0.0, sy, 0.0, cy), (sx, 0.0, 0.0, cx)))


def angles_of(rotation: Quaternion) -> Vec3:
    """The angles about the fixed axes x, then y, then z [rad]; NaN if the rotation is unknown."""
    x, y, z, w = rotation
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    sine = 2 * (w * y - z * x)
    pitch = math.asin(min(max(sine, -1.0), 1.0)) if math.isfinite(sine) else math.nan
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return roll, pitch, yaw


def _point(point: Any) -> Vec3:
    return (point.x, point.y, point.z)


def _direction(vector: Any) -> Vec3:
    x, y, z = direction = _point(vector)
    # One that no float can measure is as unknown as one of length 0.
    return direction if 0 < math.hypot(x, y, z) < math.inf else UNKNOWN_POINT


def _middle(borders: Any) -> Vec3:
    outer, inner = map(_point, borders)
    return (
        (outer[0] + inner[0]) / 2, (outer[1] + inner[1]) / 2, (outer[2] + inner[2]) / 2
    )  # fmt: skip


def _set(vector: Any, value: Vec3) -> None:
    vector.x, vector.y, vector.z = value
