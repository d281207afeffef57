"""The UoL 3D Social Interaction dataset (Coppola et al. 2020): Kinect v2 skeletons of two people.

``skeletons.txt`` has one line a frame, ``<time>,<slot>,<slot>,…``; a slot is empty (nobody) or a
tracking id and 25 joints of x y z qx qy qz qw, separated by spaces. Seconds, metres, the
camera's frame, in the Kinect's terms x to the camera's left, y up, z away from it.

Gaze comes from the orientation of the head, seen in the partner's frame (thesis 3.5.1). A Kinect
quaternion turns the joint's own axes: y along the bone, z its normal, which for the spine, neck
and head points out of the front. Its SDK gives no orientation of the head itself, a leaf of the
skeleton, but zeros: then the neck's is read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.person import FloatArray, Track
from kendon.sources.base import SourceOptions, register
from kendon.sources.kinect_skeletons import KinectSkeletons, joint, read_kinect_skeletons
from kendon.sources.pairs import (
    Body,
    PairGreeting,
    choose_pair,
    floor_height,
    frozen_notes,
    greeting,
    shoulder_heading,
    split_spec,
)
from kendon.sources.recording import RecordedSource

_AXES: Mapping[str, tuple[float, float, float]] = {
    "x": (1, 0, 0), "-x": (-1, 0, 0), "y": (0, 1, 0), "-y": (0, -1, 0), "z": (0, 0, 1),
    "-z": (0, 0, -1),
}  # fmt: skip
#: The bone's axis of a joint, from Microsoft's description of joint orientations.
_BONE_AXIS = "y"
#: People this near who approach each other mostly face each other; where they seem not to,
#: an axis is doubtful [m, rad].
_NEAR = 2.5
_DOUBTFUL = math.radians(60)
#: Head to foot must be this much longer along the vertical than along the next axis.
_UPRIGHT = 2.0


@dataclass(frozen=True)
class UolOptions:
    """What a user may know of a recording that its file does not say."""

    vertical: str | None = None  # the axis that points up, such as "y" or "-y"; None = found out
    face_axis: str = "z"  # the axis of the head joint that points out of the face
    mirrored: bool = False  # whether the labels left and right are those of a mirror image
    base: Literal["torso", "head"] = "torso"  # where the robot stands; the thesis took heads (3.14)
    time_unit: float = 1.0  # [s], of the file's stamps

    def __post_init__(self) -> None:
        for axis in (self.vertical, self.face_axis):
            if axis is not None and axis not in _AXES:
                raise UnknownNameError("axis", axis, _AXES)
        if self.face_axis.removeprefix("-") == _BONE_AXIS:
            raise ParameterError(
                f"the face axis cannot be {self.face_axis}, which runs along the bone;"
                " valid: x, -x, z, -z"
            )
        if self.base not in ("torso", "head"):
            raise UnknownNameError("base", self.base, ("torso", "head"))
        if not (math.isfinite(self.time_unit) and self.time_unit > 0):
            raise ParameterError(f"the time unit must be positive seconds, not {self.time_unit}")


@register
class UolSource(RecordedSource):
    """One person of a UoL recording, the robot in the place of the other."""

    name = "uol"
    reads = "UoL 3D Social Interaction skeletons.txt; #2 or #2-1 picks the person and the partner"
    example = "skeletons.txt#1-2"

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """A file named ``skeletons.txt``, or with ``#person`` or ``#person-partner`` behind it."""
        return split_spec(spec)[0].name.lower() == "skeletons.txt"

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> UolSource:
        """Read the pair; by default the first person greets the second.

        Raises:
            DataError: the file is missing, torn, unsorted, or there is no such pair.
        """
        path, person, partner = split_spec(spec)
        skeletons = read_kinect_skeletons(path)
        pair = choose_pair(path, list(skeletons.people), person, partner)
        found = _greeting(skeletons, *pair, UolOptions())
        source = cls(found.track)
        source.notes = found.notes
        return source


def read_uol(
    path: str | Path,
    options: UolOptions | None = None,
    *,
    person: int | None = None,
    partner: int | None = None,
) -> PairGreeting:
    """One person's greeting of another, with the partner's face and the notes on the reading.

    Heights are above the floor, on which the lower foot of everybody stands in the median.

    Args:
        path: of ``skeletons.txt``.
        options: what is known of axes, labels and stamps.
        person: the slot of the person; the first that is used by default.
        partner: the slot of the partner, in whose place the robot stands; by default the first
            that is used by somebody else.

    Raises:
        DataError: the file is missing, torn, unsorted, or there is no such pair.
    """
    options = options or UolOptions()
    skeletons = read_kinect_skeletons(path, options.time_unit)
    pair = choose_pair(Path(path), list(skeletons.people), person, partner)
    return _greeting(skeletons, *pair, options)


def read_uol_pairs(path: str | Path, options: UolOptions | None = None) -> list[Track]:
    """The greetings of everybody with everybody else who is seen at the same time.

    Args:
        path: of ``skeletons.txt``.
        options: what is known of axes, labels and stamps.

    Raises:
        DataError: the file is missing, torn, unsorted, or has no two people at the same time.
    """
    options = options or UolOptions()
    skeletons = read_kinect_skeletons(path, options.time_unit)
    people = list(skeletons.people)
    choose_pair(Path(path), people, None, None)
    seen = {p: np.isfinite(joints[:, joint("Head"), 0]) for p, joints in skeletons.people.items()}
    pairs = [(a, b) for a in people for b in people if a != b and (seen[a] & seen[b]).any()]
    if not pairs:
        raise DataError("no two people are ever seen at the same time", file=path)
    return [_greeting(skeletons, a, b, options).track for a, b in pairs]


def _greeting(skeletons: KinectSkeletons, one: int, two: int, options: UolOptions) -> PairGreeting:
    notes = list(skeletons.notes)
    both = [skeletons.people[one], skeletons.people[two]]
    axis = options.vertical
    if axis is None:
        axis, sure = _find_vertical(both, skeletons.path)
        doubt = "" if sure else ", but hardly so: name it with read_uol"
        notes.append(f"Up is taken to be {axis}, the axis that spans foot to head{doubt}.")
    to_world = _world_from_camera(axis)
    worlds = [joints[:, :, :3] @ to_world.T for joints in both]
    feet = [world[:, [joint("FootLeft"), joint("FootRight")], 2] for world in worlds]
    floor = floor_height(feet, skeletons.path)
    bodies = []
    for number, joints, world in zip((one, two), both, worlds, strict=True):
        world[:, :, 2] -= floor
        notes.extend(frozen_notes(skeletons.t, joints[:, :, :3], f"Person {number}"))
        rotations, from_neck = _head_quaternions(joints)
        if not np.isfinite(rotations).any():
            notes.append(f"Person {number}'s head has no orientation: their gaze is unknown.")
        elif from_neck:
            notes.append(f"Person {number}'s head orientation is the neck's, as Kinects give none.")
        bodies.append(_body(world, _head_rotation(rotations, to_world, options), options))
    notes.extend(_doubts(bodies, options))
    name = f"{skeletons.path.parent.name or skeletons.path.stem}_p{one}_p{two}"
    found = greeting(skeletons.t, bodies[0], bodies[1], name)
    x, y, z = found.robot_face
    if bodies[0].head_rotation is not None:
        notes.append(
            f"The partner's face is at {x:.2f},{y:.2f},{z:.2f}: for gaze give it as the robot's"
            f" face (--robot-face {x:.2f},{y:.2f},{z:.2f})."
        )
    return replace(found, notes=tuple(notes))


def _body(world: FloatArray, rotation: FloatArray | None, options: UolOptions) -> Body:
    named = {}
    for own, label in (("l", "Left"), ("r", "Right")):
        side = {"Left": "Right", "Right": "Left"}[label] if options.mirrored else label
        for part, word in (
            ("shoulder", "Shoulder"), ("elbow", "Elbow"), ("wrist", "Wrist"), ("hip", "Hip"),
        ):  # fmt: skip
            named[f"{own}_{part}"] = world[:, joint(word + side)]
    heading = shoulder_heading(named["l_shoulder"], named["r_shoulder"])
    head = world[:, joint("Head")]
    stand = head if options.base == "head" else world[:, joint("SpineMid")]
    return Body(head, stand[:, :2], heading, named, rotation)


def _find_vertical(people: Sequence[FloatArray], path: Path) -> tuple[str, bool]:
    """The axis from foot to head, and whether it is clearly longer than the other two."""
    spans = np.concatenate(
        [
            joints[:, joint("Head"), :3]
            - (joints[:, joint("FootLeft"), :3] + joints[:, joint("FootRight"), :3]) / 2
            for joints in people
        ]
    )
    spans = spans[np.isfinite(spans).all(axis=1)]
    if not len(spans):
        raise DataError("head and feet are never seen together: which axis is up?", file=path)
    span = np.median(spans, axis=0)
    longest = int(np.argmax(np.abs(span)))
    others = np.delete(np.abs(span), longest)
    axis = ("-" if span[longest] < 0 else "") + "xyz"[longest]
    return axis, bool(abs(span[longest]) >= _UPRIGHT * others.max())


def _world_from_camera(axis: str) -> FloatArray:
    """The rotation (3, 3) that takes the axis named up to z; it mirrors nothing."""
    up = np.array(_AXES[axis], dtype=float)
    ahead = np.roll(np.abs(up), 1)
    return np.stack([ahead, np.cross(up, ahead), up])


def _head_quaternions(joints: FloatArray) -> tuple[FloatArray, bool]:
    """The head's quaternions (T, 4) of length 1 or NaN, and whether they are the neck's."""
    for name in ("Head", "Neck"):
        rotation = joints[:, joint(name), 3:]
        length = np.linalg.norm(rotation, axis=1, keepdims=True)
        rotation = rotation / np.where(length > 0, length, np.nan)
        if np.isfinite(rotation).any():
            return rotation, name == "Neck"
    return rotation, False


def _head_rotation(
    rotation: FloatArray, to_world: FloatArray, options: UolOptions
) -> FloatArray | None:
    """Kinect joint quaternions as kendon's head rotations in the world, (T, 4)."""
    from scipy.spatial.transform import Rotation  # half a second: not for those who need none

    known = np.isfinite(rotation).all(axis=1)
    if not known.any():
        return None
    face, up = np.array(_AXES[options.face_axis]), np.array(_AXES[_BONE_AXIS])
    axes = np.stack([face, np.cross(up, face), up], axis=1)  # out of the face, left, up
    turned = to_world @ Rotation.from_quat(rotation[known]).as_matrix() @ axes
    result = np.full((len(rotation), 4), np.nan)
    result[known] = Rotation.from_matrix(turned).as_quat()
    return result


def _doubts(bodies: Sequence[Body], options: UolOptions) -> list[str]:
    """Sentences where near people seem to turn away from each other: an axis may be wrong."""
    one, two = bodies
    way = two.head[:, :2] - one.head[:, :2]
    near = np.hypot(way[:, 0], way[:, 1]) < _NEAR
    toward = np.arctan2(way[:, 1], way[:, 0])

    def off(headings: Sequence[FloatArray]) -> float:
        """The median angle between where people point and where the other is [rad]."""
        errors = [headings[0][near] - toward[near], headings[1][near] - toward[near] - math.pi]
        wrapped = np.abs(np.angle(np.exp(1j * np.concatenate(errors))))
        return float(np.median(wrapped[np.isfinite(wrapped)])) if np.isfinite(wrapped).any() else 0

    notes = []
    body = off([b.heading for b in bodies])
    if body > math.pi - _DOUBTFUL:
        notes.append(
            "The two stand back to back by their shoulders: left and right may be those of a"
            " mirror image (mirrored=True of UolOptions)."
        )
    rotations = [b.head_rotation for b in bodies]
    if not any(r is None for r in rotations):
        faces = [_face_yaw(r) for r in rotations if r is not None]
        found = off(faces)
        if found > _DOUBTFUL:
            turns = {
                math.degrees(turn): off([yaw + turn for yaw in faces])
                for turn in (math.pi / 2, math.pi, -math.pi / 2)
            }
            best = min(turns, key=lambda turn: turns[turn])
            notes.append(
                f"Near each other the two look {math.degrees(found):.0f} degrees past each other"
                f" in the median, but only {math.degrees(turns[best]):.0f} if faces are turned by"
                f" {best:g} degrees: {options.face_axis} may not be the axis out of the face"
                " (face_axis of UolOptions)."
            )
    return notes


def _face_yaw(rotation: FloatArray) -> FloatArray:
    x, y, z, w = rotation.T
    return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
