"""What ROS4HRI (REP-155) tells of people: who is whose face and body, where, and their smiles.

A face is the frame ``face_<id>`` (x out of the face, z to the scalp, at the point between the
eyes) with ``gaze_<id>`` (z along the gaze), a body ``body_<id>`` with ``head_<id>``,
``l_wrist_<id>`` and so on. Face and body ids are given anew whenever somebody was lost; persons
keep theirs, and ``/humans/persons/<id>/face_id`` and ``body_id`` say which face and body they
have, or else ``/humans/candidate_matches``. A face or body without a person is one by itself.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kendon.features.smile import smile
from kendon.person import JOINTS, FloatArray, IntArray
from kendon.sources.ros_stamps import nanoseconds
from kendon.sources.transforms import TransformTree

#: Matches less sure than this are none (REP-155's ``/human/match_threshold``).
MATCH_THRESHOLD = 0.5
#: The Action Units of a smile (thesis 3.11); messages hold one number for each code.
_AU06, _AU12 = 6, 12
#: The greatest intensity on the scale of FACS, A to E, and on that of shares.
_FACS, _SHARE = 5.0, 1.0
#: A smile is known so long before and after it was told [ns].
_SMILE_HOLDS = 200_000_000
#: Stamps and receipt farther apart than this are two clocks [s].
TWO_CLOCKS = 1.0
#: So many lags are kept when the rest is forgotten.
_LAGS = 1000
#: Likewise so many faces and bodies of which it is known whose they are.
_MATCHES = 1000

_TRANSFORMS = {"/tf": False, "/tf_static": True}
_TRACKED = re.compile(r"/humans/(faces|bodies|persons)/tracked")
_MATCH = re.compile(r"/humans/persons/([^/]+)/(face_id|body_id|alias)")
_FACS_TOPIC = re.compile(r"/humans/faces/([^/]+)/facs")
_CANDIDATES = "/humans/candidate_matches"
_KINDS = {1: "persons", 2: "faces", 3: "bodies"}  # IdsMatch's constants
_NANO = 10**9


@dataclass(frozen=True)
class Person:
    """Somebody, by the ids that they went by."""

    name: str  # the person's id, or else that of the face or body
    faces: tuple[str, ...]  # face ids with a frame, the one told of most often first
    bodies: tuple[str, ...]  # body ids with a head's frame, likewise

    @property
    def ids(self) -> set[str]:
        """All the ids that stand for this person."""
        return {self.name, *self.faces, *self.bodies}


class HumansLog:
    """Takes in messages as they come, and tells who was there."""

    def __init__(self) -> None:
        self.transforms = TransformTree()
        self.unstamped = 0  # transforms without a stamp, which cannot be placed in time
        self._ids: dict[str, set[str]] = defaultdict(set)  # kind -> ids
        self._told: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
        self._candidates: dict[tuple[str, str], dict[tuple[str, str], float]] = defaultdict(dict)
        self._aliases: dict[str, str] = {}
        self._facs: dict[str, list[tuple[int, float, float]]] = defaultdict(list)
        self._strongest = 0.0  # the greatest intensity of any Action Unit
        self._lags: list[int] = []  # [ns], from stamp to receipt

    @staticmethod
    def wanted(topic: str) -> bool:
        """Whether `take` makes use of a topic's messages."""
        patterns = (_TRACKED, _MATCH, _FACS_TOPIC)
        return topic in (*_TRANSFORMS, _CANDIDATES) or any(p.fullmatch(topic) for p in patterns)

    def take(self, topic: str, message: Any, received: int) -> bool:
        """Take in a message, as a ROS library gives it.

        Args:
            topic: its name, with the slash before it.
            message: with the fields of its type.
            received: when it came [ns].

        Returns:
            Whether it may have told something new of who is there, apart from where.

        Raises:
            DataError: the clock of the transforms has gone back.
        """
        if topic in _TRANSFORMS:
            self._take_transforms(message, received, static=_TRANSFORMS[topic])
            return _TRANSFORMS[topic]
        if face := _FACS_TOPIC.fullmatch(topic):
            new = face[1] not in self._ids["faces"]
            self._take_facs(face[1], message)
            return new
        if tracked := _TRACKED.fullmatch(topic):
            new = not self._ids[tracked[1]].issuperset(message.ids)
            self._ids[tracked[1]].update(message.ids)
            return new
        if match := _MATCH.fullmatch(topic):
            self._take_match(match[1], match[2], message.data)
        elif topic == _CANDIDATES and hasattr(message, "id1_type"):
            ends = [
                (_KINDS.get(int(kind), ""), str(name))
                for kind, name in ((message.id1_type, message.id1), (message.id2_type, message.id2))
            ]
            if all(kind and name for kind, name in ends):
                for one, two in (ends, ends[::-1]):
                    self._ids[one[0]].add(one[1])
                    self._candidates[one][two] = float(message.confidence)
        return True

    @property
    def lags(self) -> int:
        """From how many transforms `lag` is told."""
        return len(self._lags)

    @property
    def lag(self) -> float:
        """How long after its stamp a transform was received, in the median [s]; 0 if none was."""
        return float(np.median(self._lags)) / _NANO if self._lags else 0.0

    def notes(self) -> list[str]:
        """What a user should know about how it was told, one sentence each."""
        tree, notes = self.transforms, []
        if abs(self.lag) > TWO_CLOCKS:
            way = "behind" if self.lag > 0 else "ahead of"
            notes.append(
                f"The messages' stamps are {abs(self.lag):.1f} s {way} the recorder's clock"
                " in the median; the stamps are used."
            )
        for number, what in (
            (tree.refused, "no poses (NaN, or a quaternion without length 1)"),
            (self.unstamped, "not stamped"),
        ):
            if number:
                notes.append(f"{number} of the transforms are {what}; they are left out.")
        if tree.late:
            notes.append(
                f"{tree.late} of the transforms came late; they are sorted by their stamps."
            )
        return notes

    def people(self) -> list[Person]:
        """Everybody whose face or head has a place, in the order in which they were first seen."""
        tree = self.transforms
        frames = set(tree.frames)
        # Robots have frames called head_camera or face_link: a pair of frames tells a person's.
        self._ids["faces"] |= _paired(frames, "face_", "gaze_")
        self._ids["bodies"] |= _paired(frames, "head_", "body_")
        found: dict[str, dict[str, list[str]]] = defaultdict(lambda: {"faces": [], "bodies": []})
        first: dict[str, int] = {}
        for kind, prefix in (("faces", "face_"), ("bodies", "head_")):
            ids = [i for i in self._ids[kind] if len(tree.stamps(prefix + i))]
            for part in sorted(ids, key=lambda i: (-len(tree.stamps(prefix + i)), i)):
                name = self._name(kind, part)
                found[name][kind].append(part)
                start = int(tree.stamps(prefix + part)[0])
                first[name] = min(start, first.get(name, start))
        return [
            Person(name, tuple(found[name]["faces"]), tuple(found[name]["bodies"]))
            for name in sorted(found, key=lambda n: (first[n], n))
        ]

    def unplaced(self) -> list[str]:
        """The ids of persons, faces and bodies that were tracked but have no place, sorted."""
        placed = {i for person in self.people() for i in person.ids}
        return sorted(set().union(*self._ids.values()) - placed)

    def smile_awaited(self, face: str, stamp: int, within: int) -> bool:
        """Whether a face's Action Units are still to come for a stamp; see `TransformTree`."""
        told = self._facs.get(face)
        return told is not None and told[-1][0] < stamp <= told[-1][0] + within

    def forget(self, before: int) -> None:
        """Drop what is stamped before a time [ns]; who is whose is remembered for long."""
        self.transforms.forget(before)
        known: list[dict[Any, Any]] = [self._told, self._aliases, self._candidates]
        for one in (*known, *self._candidates.values()):
            _keep_newest(one)
        del self._lags[:-_LAGS]
        for face, told in list(self._facs.items()):
            self._facs[face] = [row for row in told if row[0] >= before]
            if not self._facs[face]:
                del self._facs[face]
        frames = set(self.transforms.frames)
        for kind, prefix in (("faces", "face_"), ("bodies", "head_")):
            self._ids[kind] = {i for i in self._ids[kind] if prefix + i in frames}
        self._ids["persons"].clear()

    def restart(self) -> None:
        """Drop all that is stamped, as the clock has been set; who is whose is remembered."""
        self.transforms.restart()
        self._facs.clear()
        self._lags.clear()

    def smiles(self, face: str, stamps: IntArray) -> tuple[FloatArray | None, str]:
        """A face's smile at stamps, and what a user should know of it.

        The scale of the intensities is nowhere written: it is that of FACS, 0 to 5, unless no
        Action Unit of anybody ever exceeds 1.

        Args:
            face: its id.
            stamps: shape (N,) [ns], growing.

        Returns:
            Shape (N,) [0-5], NaN = unknown, or None if nothing was told; a sentence or "".
        """
        told = self._facs.get(face)
        if not told:
            return None, ""
        if self._strongest > _FACS:
            return None, (
                f"Action Units reach {self._strongest:g}, on a scale that is neither 0 to 5 nor"
                " 0 to 1: smiles are unknown."
            )
        note, factor = "", 1.0
        if self._strongest <= _SHARE:
            factor = _FACS / _SHARE
            note = "No Action Unit exceeds 1: they are taken as shares of the full intensity, 5."
        when, first = np.unique([row[0] for row in told], return_index=True)
        units = np.array([row[1:] for row in told])[first] * factor
        nearest = np.clip(np.searchsorted(when, stamps), 1, max(len(when) - 1, 1))
        before, after = when[nearest - 1], when[np.minimum(nearest, len(when) - 1)]
        row = np.where(stamps - before <= after - stamps, nearest - 1, nearest)
        row = np.minimum(row, len(when) - 1)
        near = np.abs(when[row] - stamps) <= _SMILE_HOLDS
        return np.where(near, smile(units[row, 0], units[row, 1]), np.nan), note

    def _take_transforms(self, message: Any, received: int, *, static: bool) -> None:
        for told in message.transforms:
            stamp = nanoseconds(told.header.stamp)
            if not static:
                if stamp == 0:
                    self.unstamped += 1
                    continue
                self._lags.append(received - stamp)
            place, turn = told.transform.translation, told.transform.rotation
            self.transforms.add(
                told.header.frame_id.lstrip("/"),
                told.child_frame_id.lstrip("/"),
                stamp,
                (place.x, place.y, place.z),
                (turn.x, turn.y, turn.z, turn.w),
                static=static,
            )

    def _take_match(self, person: str, what: str, other: str) -> None:
        if not other:
            return
        self._ids["persons"].add(person)
        if what == "alias":
            self._aliases[person] = other
            return
        kind = {"face_id": "faces", "body_id": "bodies"}[what]
        self._ids[kind].add(other)
        self._told[kind, other][person] += 1

    def _take_facs(self, face: str, message: Any) -> None:
        intensity = np.asarray(message.intensity, dtype=float)
        sure = np.asarray(message.confidence, dtype=float)
        self._ids["faces"].add(face)
        stamp = nanoseconds(message.header.stamp)
        if stamp == 0 or len(intensity) <= _AU12:
            return
        if len(sure) == len(intensity) and (sure > 0).any():  # else nobody filled it in
            intensity = np.where(sure > 0, intensity, np.nan)
        intensity = np.where(np.isfinite(intensity), intensity, np.nan)
        if np.isfinite(intensity).any():
            self._strongest = max(self._strongest, float(np.nanmax(intensity)))
        self._facs[face].append((stamp, float(intensity[_AU06]), float(intensity[_AU12])))

    def _name(self, kind: str, part: str) -> str:
        """What the person is called to whom a face or body belongs."""
        name = self._person_of(kind, part)
        if name is None:  # by way of the face that the body belongs to, or the body of the face
            other = "bodies" if kind == "faces" else "faces"
            partner = self._likeliest((kind, part), other)
            if partner is not None:
                name = self._person_of(other, partner)
                if name is None:
                    name = partner if other == "faces" else part
        if name is None:
            name = part
        seen = {name}
        while self._aliases.get(name, name) not in seen:
            name = self._aliases[name]
            seen.add(name)
        return name

    def _person_of(self, kind: str, part: str) -> str | None:
        told = self._told.get((kind, part))
        if told:
            return max(sorted(told), key=lambda person: told[person])
        return self._likeliest((kind, part), "persons")

    def _likeliest(self, one: tuple[str, str], kind: str) -> str | None:
        matches = {n: sure for (k, n), sure in self._candidates.get(one, {}).items() if k == kind}
        best = max(sorted(matches), key=lambda name: matches[name], default=None)
        return best if best is not None and matches[best] >= MATCH_THRESHOLD else None


def joint_frames(body: str, frames: Iterable[str]) -> dict[str, str]:
    """The frames of a body's joints by kendon's names, which are REP-155's."""
    there = set(frames)
    return {joint: f"{joint}_{body}" for joint in JOINTS if f"{joint}_{body}" in there}


def _keep_newest(known: dict[Any, Any]) -> None:
    """Drop the oldest entries beyond `_MATCHES`."""
    for old in list(known)[:-_MATCHES]:
        del known[old]


def _paired(frames: set[str], one: str, two: str) -> set[str]:
    """The ids for which frames with both prefixes exist."""
    ids = {frame.removeprefix(one) for frame in frames if frame.startswith(one)}
    return {i for i in ids if two + i in frames}
