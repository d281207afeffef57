"""Two recorded people as two greetings: each of them once the person, once the robot.

Datasets of people who meet know no robot. kendon puts the robot where the partner stands: its
``base_footprint`` follows the partner over the ground, its x axis along the partner's body, or
toward the person where nothing is known of the body (thesis 3.5.1: one sequence per greeter).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kendon.errors import DataError
from kendon.features import ROBOT_FACE
from kendon.geometry import Vec3
from kendon.person import FloatArray, Track

#: A tracker that saw nothing new repeats its last numbers to the last digit; a person who only
#: stands still never does. So long a repetition is no measurement any more [s].
FROZEN = 2.0

#: How a spec names the person, and the partner, in a file of several people.
_SPEC = re.compile(r"(?P<path>.*?)(?:#(?P<person>\d{1,6})(?:-(?P<partner>\d{1,6}))?)?", re.DOTALL)
_WHO = ("person", "partner")


@dataclass(frozen=True, eq=False)
class Body:
    """One of the people of a recording over time, T frames, in the world that they share.

    World: x and y on the ground, z up from the floor, right-handed, metres. NaN = unknown.
    """

    head: FloatArray  # (T, 3) [m], the face
    stand: FloatArray  # (T, 2) [m], where the person stands: the robot's base, in turn
    heading: FloatArray  # (T,) [rad], of the body in the ground plane
    joints: Mapping[str, FloatArray] = field(default_factory=dict)  # name -> (T, 3) [m]
    head_rotation: FloatArray | None = None  # (T, 4) quaternion x y z w: x out of the face, z up


@dataclass(frozen=True, eq=False)
class PairGreeting:
    """One person's greeting of a partner, who stands for the robot."""

    track: Track
    robot_face: Vec3 = ROBOT_FACE  # [m], the partner's face in the robot's base frame (median)
    notes: tuple[str, ...] = ()  # what a user should know about how it was read


def greeting(t: FloatArray, person: Body, partner: Body, name: str = "") -> PairGreeting:
    """The greeting of `person`, seen by a robot that stands where `partner` stands.

    Where the partner is unknown, so is the person's place before them; the robot's pose is
    interpolated there, as it must be known in every frame.

    Args:
        t: stamps, shape (T,) [s].
        person: who greets.
        partner: whose place the robot takes.
        name: of the track.

    Raises:
        DataError: the two are never seen together.
        ParameterError: the stamps do not grow.
    """
    together = np.isfinite(partner.stand).all(axis=1) & np.isfinite(person.head[:, :2]).all(axis=1)
    if not together.any():
        raise DataError(f"{name}: the two people are never seen at the same time")
    stand = _filled(partner.stand)
    way = person.head[:, :2] - partner.stand
    toward = np.arctan2(way[:, 1], way[:, 0])
    yaw = np.where(np.isnan(partner.heading), toward, partner.heading)
    # Angles must not be interpolated across the half turn; directions can.
    east, north = _filled(np.stack([np.cos(yaw), np.sin(yaw)], axis=1)).T
    yaw = np.arctan2(north, east)
    c, s = np.cos(yaw), np.sin(yaw)

    def local(points: FloatArray) -> FloatArray:
        x, y = (points[:, :2] - partner.stand).T
        return np.stack([c * x + s * y, -s * x + c * y, points[:, 2]], axis=1)

    rotation = None
    if person.head_rotation is not None:
        rotation = _turned(person.head_rotation, -yaw)
    track = Track.build(
        t,
        local(person.head),
        head_rotation=rotation,
        joints={joint: local(points) for joint, points in person.joints.items()},
        robot=np.column_stack([stand, yaw]),
        name=name,
    )
    faces = local(partner.head)
    known = faces[np.isfinite(faces).all(axis=1)]
    x, y, z = np.median(known, axis=0).tolist() if len(known) else ROBOT_FACE
    return PairGreeting(track, (x, y, z))


def shoulder_heading(left: FloatArray, right: FloatArray) -> FloatArray:
    """Where the body points in the ground plane, from the person's own shoulders [rad].

    Args:
        left: left shoulder, shape (T, 3), z up [m].
        right: right shoulder, shape (T, 3), z up [m].

    Returns:
        Shape (T,); NaN where a shoulder is unknown or they lie above each other.
    """
    across = (left - right)[:, :2]
    across = np.where((across == 0).all(axis=1, keepdims=True), np.nan, across)
    # Left x up = forward.
    return np.asarray(np.arctan2(-across[:, 0], across[:, 1]))


def floor_height(feet: Sequence[FloatArray], path: Path) -> float:
    """The median height of the lower foot of people on one floor [m].

    The lower foot is the one that carries; the median withstands a tracker's slips.

    Args:
        feet: heights of each person's left and right foot, shapes (T, 2) [m].
        path: of the file, for the message.

    Raises:
        DataError: no foot is ever seen.
    """
    lower = np.concatenate([np.fmin(pair[:, 0], pair[:, 1]) for pair in feet])
    if not np.isfinite(lower).any():
        raise DataError("no foot is ever seen, so that the floor is unknown", file=path)
    return float(np.nanmedian(lower))


def frozen_notes(t: FloatArray, points: FloatArray, who: str) -> tuple[str, ...]:
    """A sentence for every time that a tracker repeats itself for longer than `FROZEN`.

    Args:
        t: stamps, shape (T,) [s].
        points: all coordinates of one person, shape (T, ...); NaN = unknown.
        who: how the sentence calls the person.
    """
    flat = points.reshape(len(points), -1)
    same = (flat[1:] == flat[:-1]) | (np.isnan(flat[1:]) & np.isnan(flat[:-1]))
    still = same.all(axis=1) & np.isfinite(flat[1:]).any(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    notes = []
    for start, stop in edges.reshape(-1, 2).tolist():
        if t[stop] - t[start] > FROZEN:
            notes.append(
                f"{who} does not move to the last digit from {t[start]:.1f} to {t[stop]:.1f} s:"
                " the tracker had lost them, their place is not measured there."
            )
    return tuple(notes)


def split_spec(spec: str) -> tuple[Path, int | None, int | None]:
    """The parts of ``path``, ``path#person`` or ``path#person-partner``."""
    match = _SPEC.fullmatch(spec)
    if match is None or Path(spec).exists():  # a file may well have such a name
        return Path(spec), None, None
    person, partner = (None if match[who] is None else int(match[who]) for who in _WHO)
    return Path(match["path"]), person, partner


def choose_pair(
    path: Path, people: Sequence[int], person: int | None, partner: int | None
) -> tuple[int, int]:
    """Which person greets which partner; by default the first the second, others the first.

    Args:
        path: of the file, for the message.
        people: the numbers of the people in it.
        person: the number asked for, if any.
        partner: the partner's number asked for, if any.

    Raises:
        DataError: there are fewer than two people, there is none of that number, or the person
            and the partner are the same.
    """
    there = ", ".join(map(str, people)) or "none"
    if len(people) < 2:
        raise DataError(
            f"a greeting needs two people; there {'is' if len(people) == 1 else 'are'} only"
            f" {there} in this file",
            file=path,
        )
    for number in (person, partner):
        if number is not None and number not in people:
            raise DataError(f"there is no person {number}; valid: {there}", file=path)
    first = people[0] if person is None else person
    second = next(p for p in people if p != first) if partner is None else partner
    if first == second:
        raise DataError(
            f"person {first} cannot greet themselves; write {path.name}#PERSON-PARTNER with two"
            f" of {there}",
            file=path,
        )
    return first, second


def _filled(values: FloatArray) -> FloatArray:
    """Columns without gaps: straight lines between known rows, the nearest beyond; (T, k)."""
    rows = np.arange(len(values))
    known = np.isfinite(values).all(axis=1)
    return np.stack([np.interp(rows, rows[known], column[known]) for column in values.T], axis=1)


def _turned(rotation: FloatArray, yaw: FloatArray) -> FloatArray:
    """Rotations (T, 4), then each turned by its yaw (T,) about the vertical."""
    x, y, z, w = rotation.T
    c, s = np.cos(yaw / 2), np.sin(yaw / 2)
    return np.stack([c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z], axis=1)
