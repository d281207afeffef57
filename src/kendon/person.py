"""What kendon knows of one person: at one instant (`PersonFrame`) and over time (`Track`).

Points are in the robot's ``base_footprint`` at that instant (REP-105: x forward, y left, z
up, on the floor under the robot), unless said otherwise. What is not known is NaN.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, ItemsView, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kendon.errors import ParameterError
from kendon.geometry import (
    ORIGIN,
    UNKNOWN_POINT,
    UNKNOWN_ROTATION,
    Pose2D,
    Quaternion,
    Vec3,
    compose,
    yaw_quaternion,
)
from kendon.phases import Phase

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: The joints of the upper body, the person's own left and right.
JOINTS: tuple[str, ...] = tuple(
    f"{side}_{joint}" for side in "lr" for joint in ("shoulder", "elbow", "wrist", "hip")
)

#: The gesture probabilities that can be given by hand, as the thesis's keys gave them (3.3.5).
GESTURES: tuple[str, ...] = ("dsal", "csal", "hdip")
#: The phases that press those keys, in the same order.
_KEYED = (Phase.DS, Phase.CS, Phase.HD)
#: The gestures as the keys give them in each phase; None = not greeting.
_PRESSED: dict[Phase | None, tuple[float, ...]] = {
    phase: tuple(float(phase is keyed) for keyed in _KEYED) for phase in (None, *Phase)
}


def pressed(phase: Phase | None) -> tuple[float, ...]:
    """The gestures as given by hand, with the thesis's keys, in a phase (3.3.5)."""
    return _PRESSED[phase]


class LateJoints(Mapping[str, Vec3]):
    """The joints of a frame, worked out when somebody looks at them.

    Most frames' joints are looked at by nobody, and they cost more than all the rest.

    Args:
        names: of the joints.
        work_out: gives the joints by these names [m].
    """

    __slots__ = ("_joints", "_names", "_work_out")

    def __init__(self, names: Collection[str], work_out: Callable[[], Mapping[str, Vec3]]) -> None:
        self._names, self._work_out = names, work_out
        self._joints: Mapping[str, Vec3] | None = None

    def _worked_out(self) -> Mapping[str, Vec3]:
        if self._joints is None:
            self._joints = self._work_out()
        return self._joints

    def __getitem__(self, name: str) -> Vec3:
        return self._worked_out()[name]

    def items(self) -> ItemsView[str, Vec3]:
        """The joints by their names [m]."""
        return self._worked_out().items()

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return repr(self._worked_out())


#: The joints of somebody none of whose joints are known; nobody can add to it.
_NO_JOINTS = LateJoints((), dict)


class PersonFrame(NamedTuple):
    """One person at one instant, seen from the robot."""

    t: float  # [s]
    head: Vec3 = UNKNOWN_POINT  # [m], the face
    head_rotation: Quaternion = UNKNOWN_ROTATION  # of the head: x out of the face, y left, z up
    eyes: tuple[Vec3, Vec3] | None = None  # [m], centres of the person's left and right eye
    eye_gaze: tuple[Vec3, Vec3] | None = None  # directions out of those eyes
    joints: Mapping[str, Vec3] = _NO_JOINTS  # [m], by the names in JOINTS
    smile: float = math.nan  # [0-5], the mean of AU06 and AU12 (thesis 3.11)
    dsal: float = math.nan  # [probability], given by hand
    csal: float = math.nan  # [probability], given by hand
    hdip: float = math.nan  # [probability], given by hand
    robot: Pose2D = ORIGIN  # the robot's pose in the world at that instant
    who: int | None = None  # which of the people that a source tells apart; None = it does not

    @property
    def seen(self) -> bool:
        """Whether the face's place on the ground is known."""
        return math.isfinite(self.head[0]) and math.isfinite(self.head[1])

    def seen_from(self, robot: Pose2D) -> PersonFrame:
        """The same person at the same instant, seen from a robot that stands at `robot`."""
        if robot == self.robot:
            return self
        # One planar motion for all points; this runs for every frame of a flow.
        old = self.robot
        turn = old.yaw - robot.yaw
        c, s = math.cos(turn), math.sin(turn)
        shift_x, shift_y, _ = robot.to_local((old.x, old.y, 0.0))

        def move(point: Vec3) -> Vec3:
            x, y, z = point
            return (shift_x + c * x - s * y, shift_y + s * x + c * y, z)

        def rotate(direction: Vec3) -> Vec3:
            x, y, z = direction
            return (c * x - s * y, s * x + c * y, z)

        return PersonFrame(
            self.t,
            move(self.head),
            compose(yaw_quaternion(turn), self.head_rotation),
            self.eyes and (move(self.eyes[0]), move(self.eyes[1])),
            self.eye_gaze and (rotate(self.eye_gaze[0]), rotate(self.eye_gaze[1])),
            self.joints
            and LateJoints(self.joints, partial(_moved, self.joints, c, s, shift_x, shift_y)),
            self.smile,
            self.dsal,
            self.csal,
            self.hdip,
            robot,
            self.who,
        )


def _moved(
    joints: Mapping[str, Vec3], c: float, s: float, shift_x: float, shift_y: float
) -> dict[str, Vec3]:
    """Joints turned in the ground plane, by cosine and sine, and shifted [m]."""
    return {
        name: (shift_x + c * x - s * y, shift_y + s * x + c * y, z)
        for name, (x, y, z) in joints.items()
    }


@dataclass(frozen=True, eq=False)
class Track:
    """One person over time as arrays, one row a frame; T frames in the order of their stamps."""

    t: FloatArray  # (T,) [s]
    head: FloatArray  # (T, 3) [m]
    head_rotation: FloatArray  # (T, 4) quaternion x y z w of the head frame
    eyes: FloatArray  # (T, 2, 3) [m], left then right
    eye_gaze: FloatArray  # (T, 2, 3) directions, left then right
    joints: Mapping[str, FloatArray]  # name -> (T, 3) [m]; only joints that were tracked
    smile: FloatArray  # (T,) [0-5]
    gestures: FloatArray  # (T, 3) [probability] in the order of GESTURES, given by hand
    robot: FloatArray  # (T, 3) x y [m] yaw [rad] of the robot in the world
    phases: IntArray | None = None  # (T,) true phase 1-6, 0 = not greeting, -1 = not labelled
    name: str = ""

    @classmethod
    def build(
        cls,
        t: FloatArray,
        head: FloatArray,
        *,
        head_rotation: FloatArray | None = None,
        eyes: FloatArray | None = None,
        eye_gaze: FloatArray | None = None,
        joints: Mapping[str, FloatArray] | None = None,
        smile: FloatArray | None = None,
        gestures: FloatArray | None = None,
        robot: FloatArray | None = None,
        phases: IntArray | None = None,
        name: str = "",
    ) -> Track:
        """A track from what is known; the rest is unknown, and the robot stands at the origin.

        Raises:
            ParameterError: the shapes do not fit, or the stamps do not grow.
        """
        n = len(t)

        def known(values: FloatArray | None, *shape: int, fill: float = math.nan) -> FloatArray:
            if values is None:
                return np.full((n, *shape), fill)
            if np.shape(values) != (n, *shape):
                raise ParameterError(
                    f"a track of {n} frames needs arrays of shape {(n, *shape)},"
                    f" not {np.shape(values)}"
                )
            return np.asarray(values, dtype=float)

        if phases is not None and np.shape(phases) != (n,):
            raise ParameterError(
                f"a track of {n} frames needs {n} phases, not an array of shape {np.shape(phases)}"
            )
        if not (np.isfinite(t).all() and (np.diff(t) > 0).all()):
            raise ParameterError("the stamps of a track must be finite and grow from row to row")
        return cls(
            t=known(t),
            head=known(head, 3),
            head_rotation=known(head_rotation, 4),
            eyes=known(eyes, 2, 3),
            eye_gaze=known(eye_gaze, 2, 3),
            joints={joint: known(points, 3) for joint, points in (joints or {}).items()},
            smile=known(smile),
            gestures=known(gestures, len(GESTURES)),
            robot=known(robot, 3, fill=0.0),
            phases=phases,
            name=name,
        )

    @classmethod
    def from_frames(cls, frames: Iterable[PersonFrame], name: str = "") -> Track:
        """The track of frames in the order of their stamps.

        Raises:
            ParameterError: the stamps do not grow.
        """
        frames = list(frames)
        unknown_pair = (UNKNOWN_POINT, UNKNOWN_POINT)
        joints = {joint for frame in frames for joint in frame.joints}

        def column(values: list[object], *shape: int) -> FloatArray:
            return np.array(values, dtype=float).reshape(len(frames), *shape)

        return cls.build(
            column([f.t for f in frames]),
            column([f.head for f in frames], 3),
            head_rotation=column([f.head_rotation for f in frames], 4),
            eyes=column([f.eyes or unknown_pair for f in frames], 2, 3),
            eye_gaze=column([f.eye_gaze or unknown_pair for f in frames], 2, 3),
            joints={
                j: column([f.joints.get(j, UNKNOWN_POINT) for f in frames], 3)
                for j in sorted(joints)
            },
            smile=column([f.smile for f in frames]),
            gestures=column([(f.dsal, f.csal, f.hdip) for f in frames], 3),
            robot=column([f.robot for f in frames], 3),
            name=name,
        )

    def __len__(self) -> int:
        return len(self.t)

    @property
    def duration(self) -> float:
        """From the first frame to the last [s]."""
        return float(self.t[-1] - self.t[0]) if len(self.t) else 0.0

    def __iter__(self) -> Iterator[PersonFrame]:
        # Column by column, since this runs for every frame of a flow.
        has_eyes: Any = np.isfinite(self.eyes).any(axis=(1, 2)).tolist()
        names = tuple(self.joints)
        columns = [map(tuple, points.tolist()) for points in self.joints.values()]
        places: Iterable[tuple[Any, ...]] = (
            zip(*columns, strict=True) if names else itertools.repeat(())
        )
        rows: Iterator[tuple[Any, ...]] = zip(
            self.t.tolist(),
            map(tuple, self.head.tolist()),
            map(tuple, self.head_rotation.tolist()),
            _pairs(self.eyes, has_eyes),
            _pairs(self.eye_gaze, has_eyes),
            (dict(zip(names, place, strict=True)) for place in places),
            self.smile.tolist(),
            *self.gestures.T.tolist(),
            (Pose2D(*pose) for pose in self.robot.tolist()),
            strict=False,  # the joints of a track without any never end
        )
        return itertools.starmap(PersonFrame, rows)

    def with_gestures_from_phases(self) -> Track:
        """The track as if a person had pressed the thesis's keys (3.3.5) during each phase.

        dsal is 1 in a Distance Salutation and 0 elsewhere, csal in a Close Salutation, hdip in
        a Head Dip; frames that are not labelled stay as they are.

        Raises:
            ParameterError: the track has no true phases.
        """
        if self.phases is None:
            raise ParameterError(f"{self.name or 'the track'} has no true phases to press keys by")
        keys = self.phases[:, None] == np.array(_KEYED)
        labelled = self.phases[:, None] >= 0
        return replace(self, gestures=np.where(labelled, keys, self.gestures))


def _pairs(points: FloatArray, known: list[bool]) -> Iterator[Any]:
    """The rows of (T, 2, 3) as pairs of points, None where they are not known."""
    if not any(known):
        return itertools.repeat(None, len(known))
    return (
        (tuple(left), tuple(right)) if there else None
        for (left, right), there in zip(points.tolist(), known, strict=True)
    )
