"""ROS's tree of coordinate frames over time (TF), kept and asked without ROS.

Every frame has one parent at a time and a pose in it: a static one, or stamped ones between
which it is interpolated, positions along straight lines and rotations along great arcs. Stamps
are whole nanoseconds, as ROS counts them; metres; quaternions x y z w. What cannot be told is
NaN: nothing is extrapolated, and a hole longer than `MAX_HOLE` stays one.

The rules for doubtful cases are those of ROS's tf2: a stamp that comes twice keeps its first
pose, a static pose told again its last, a pose that is no pose is left out. Only one is not: a
frame that has both kinds of pose follows the stamped ones, whichever came first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kendon.errors import DataError
from kendon.person import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

#: A frame that is not told for so long is not known between [s].
MAX_HOLE = 1.0
#: Transforms may arrive so late; a larger step back is another recording, or a clock that was
#: set [s].
MAX_LATE = 1.0
#: How far from 1 the length of a quaternion may be (tf2's tolerance).
_UNIT = 1e-2
_NANO = 1e-9


class Poses(NamedTuple):
    """Where a frame is in another one, at N stamps."""

    position: FloatArray  # (N, 3) [m]; NaN = unknown
    rotation: FloatArray  # (N, 4) quaternions x y z w; NaN = unknown


@dataclass
class _Told:
    """What was told of one frame, in the order in which it came."""

    fixed: tuple[str, list[float]] | None = None  # the static parent and pose
    parents: list[str] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)  # [ns]
    poses: list[list[float]] = field(default_factory=list)  # x y z [m], x y z w
    newest: int = 0  # [ns]
    late: int = 0  # [ns], how late the latest one was


@dataclass(frozen=True)
class _Edge:
    """A frame's poses in its parents, sorted by stamps, each stamp once."""

    parents: tuple[str, ...]  # the names that occur
    parent: IntArray  # (S,) which of them
    stamps: IntArray  # (S,) [ns]; empty for a static one
    poses: FloatArray  # (S, 7), or (1, 7) for a static one

    def parents_at(self, stamps: IntArray) -> IntArray:
        """Which of the parents holds at each stamp, -1 where the frame is not known."""
        if not len(self.stamps):
            return np.zeros(len(stamps), dtype=np.int64)
        before, after = self._around(stamps)
        known = (before >= 0) & (after < len(self.stamps))
        low, high = np.maximum(before, 0), np.minimum(after, len(self.stamps) - 1)
        known &= (self.stamps[high] - self.stamps[low]) * _NANO <= MAX_HOLE
        # Under way from one parent to another, the old one holds (tf2).
        return np.where(known, self.parent[low], -1)

    def at(self, stamps: IntArray) -> tuple[FloatArray, Rotation]:
        """Position (N, 3) and rotation at stamps for which `parents_at` knows a parent."""
        from scipy.spatial.transform import Rotation

        if not len(self.stamps):
            pose = np.repeat(self.poses, len(stamps), axis=0)
            return pose[:, :3], Rotation.from_quat(pose[:, 3:])
        before, after = self._around(stamps)
        if np.array_equal(before, after):  # as for whoever asks for what was told
            return self.poses[before, :3], Rotation.from_quat(self.poses[before, 3:])
        after = np.where(self.parent[after] == self.parent[before], after, before)
        start, stop = self.poses[before], self.poses[after]
        whole = np.maximum(self.stamps[after] - self.stamps[before], 1)
        share = ((stamps - self.stamps[before]) / whole)[:, None]
        position = start[:, :3] + share * (stop[:, :3] - start[:, :3])
        first = Rotation.from_quat(start[:, 3:])
        turn = (first.inv() * Rotation.from_quat(stop[:, 3:])).as_rotvec()
        return position, first * Rotation.from_rotvec(share * turn)

    def _around(self, stamps: IntArray) -> tuple[IntArray, IntArray]:
        """The sample at or before each stamp (-1 = none), and the one at or after it (S = none)."""
        before = np.searchsorted(self.stamps, stamps, side="right") - 1
        return before, np.searchsorted(self.stamps, stamps, side="left")


class TransformTree:
    """All frames that were told of, and where one is in another."""

    def __init__(self) -> None:
        self._told: dict[str, _Told] = {}
        self._edges: dict[str, _Edge] = {}  # made when asked for
        self.refused = 0  # transforms that are no poses: NaN, or a quaternion without length 1
        self.late = 0  # transforms that came after a newer one of the same frame

    def add(
        self,
        parent: str,
        child: str,
        stamp: int,
        position: tuple[float, float, float],
        rotation: tuple[float, float, float, float],
        *,
        static: bool = False,
    ) -> None:
        """Take in one transform: the pose of `child` in `parent`.

        Args:
            parent: the frame it is given in.
            child: the frame it places.
            stamp: when it holds [ns]; of no matter for a static one.
            position: of the child's origin [m].
            rotation: quaternion x y z w.
            static: whether it holds for ever.

        Raises:
            DataError: the clock has gone back by more than `MAX_LATE`.
        """
        pose = [*position, *rotation]
        length = math.sqrt(sum(q * q for q in rotation))  # NaN fails the comparison as well
        if not (all(map(math.isfinite, pose)) and abs(length - 1) <= _UNIT) or parent == child:
            self.refused += 1
            return
        told = self._told.setdefault(child, _Told())
        self._edges.pop(child, None)
        if static:
            told.fixed = parent, pose
            return
        if told.stamps and stamp < told.newest:
            back = (told.newest - stamp) * _NANO
            if back > MAX_LATE:
                raise DataError(
                    f"the stamps of frame {child!r} go back by {back:.1f} s at"
                    f" {stamp * _NANO:.3f} s: are these two recordings in one?"
                )
            self.late += 1
            told.late = max(told.late, told.newest - stamp)
        told.newest = max(told.newest, stamp)
        told.parents.append(parent)
        told.stamps.append(stamp)
        told.poses.append(pose)

    @property
    def frames(self) -> list[str]:
        """The names of all frames, sorted."""
        parents = {p for told in self._told.values() for p in told.parents}
        fixed = {told.fixed[0] for told in self._told.values() if told.fixed}
        return sorted(parents | fixed | set(self._told))

    def stamps(self, frame: str) -> IntArray:
        """When a frame was told of [ns], sorted, each once; a static one moves with its parent."""
        edge = None
        for _ in self._told:  # no longer, even where frames lie in each other
            edge = self._edge(frame)
            if edge is None or len(edge.stamps):
                break
            frame = edge.parents[0]
        return np.empty(0, dtype=np.int64) if edge is None else edge.stamps

    def newest(self, frame: str) -> int:
        """The newest stamp of a frame [ns], 0 = none; a static one moves with its parent."""
        for _ in self._told:  # no longer, even where frames lie in each other
            told = self._told.get(frame)
            if told is None or told.stamps or told.fixed is None:
                return told.newest if told else 0
            frame = told.fixed[0]
        return 0

    def parents(self, frame: str) -> list[str]:
        """The parents that a frame ever had, the most frequent one first."""
        edge = self._edge(frame)
        if edge is None:
            return []
        counts = np.bincount(edge.parent, minlength=len(edge.parents))
        return [edge.parents[i] for i in np.argsort(-counts, kind="stable").tolist()]

    def connected(self, target: str, source: str) -> bool:
        """Whether there is any way between two frames, at whatever time."""
        seen, waiting = {source}, [source]
        links: dict[str, set[str]] = {}
        for child in self._told:
            for parent in self.parents(child):
                links.setdefault(child, set()).add(parent)
                links.setdefault(parent, set()).add(child)
        while waiting:
            for frame in links.get(waiting.pop(), set()) - seen:
                seen.add(frame)
                waiting.append(frame)
        return target in seen

    def awaited(self, frame: str, stamp: int, within: int) -> bool:
        """Whether a pose on the way up from a frame is still to come for a stamp, as things go.

        Args:
            frame: the lowest one of the way.
            stamp: for which it is wanted [ns].
            within: what was not told for so long is no longer told [ns].
        """
        passed: set[str] = set()
        while frame in self._told and frame not in passed:
            passed.add(frame)
            told = self._told[frame]
            if told.stamps:
                if told.newest < stamp <= told.newest + within:
                    return True
                frame = told.parents[-1]
            elif told.fixed is not None:
                frame = told.fixed[0]
        return False

    def lateness(self, frame: str) -> int:
        """By how much a pose of a frame ever came after a newer one [ns]."""
        return self._told[frame].late if frame in self._told else 0

    def restart(self) -> None:
        """Drop all stamped poses: the clock has been set, and begins anew."""
        for child, told in list(self._told.items()):
            if told.fixed is None:
                del self._told[child]
            else:
                self._told[child] = _Told(told.fixed)
        self._edges.clear()

    def forget(self, before: int) -> None:
        """Drop the poses stamped before a time [ns]; frames without any left are gone."""
        for child, told in list(self._told.items()):
            kept = [i for i, stamp in enumerate(told.stamps) if stamp >= before]
            if len(kept) == len(told.stamps):
                continue
            told.parents = [told.parents[i] for i in kept]
            told.stamps = [told.stamps[i] for i in kept]
            told.poses = [told.poses[i] for i in kept]
            self._edges.pop(child, None)
            if not kept and told.fixed is None:
                del self._told[child]

    def lookup(self, target: str, source: str, stamps: IntArray) -> Poses:
        """Where frame `source` is in frame `target`.

        Args:
            target: the frame in which the poses are given.
            source: the frame whose pose is asked for.
            stamps: shape (N,) [ns].

        Raises:
            DataError: frames are each other's parents.
        """
        stamps = np.asarray(stamps, dtype=np.int64)
        position = np.full((len(stamps), 3), math.nan)
        rotation = np.full((len(stamps), 4), math.nan)
        for rows, below in self._ways_up(source, stamps):
            for part, above in self._ways_up(target, stamps[rows]):
                common = next((frame for frame in below if frame in above), None)
                if common is None:
                    continue
                there = rows[part]
                place, turn = self._pose_in(common, below, stamps[there])
                base, base_turn = self._pose_in(common, above, stamps[there])
                back: Rotation = base_turn.inv()
                position[there] = back.apply(place - base)
                rotation[there] = (back * turn).as_quat()
        return Poses(position, rotation)

    def _edge(self, frame: str) -> _Edge | None:
        if frame not in self._edges and frame in self._told:
            self._edges[frame] = self._sorted(self._told[frame])
        return self._edges.get(frame)

    @staticmethod
    def _sorted(told: _Told) -> _Edge:
        if not told.stamps:
            assert told.fixed is not None
            parent, pose = told.fixed
            nothing = np.empty(0, dtype=np.int64)
            return _Edge((parent,), np.zeros(1, dtype=np.int64), nothing, np.array([pose]))
        # np.unique keeps the first of equal stamps.
        stamps, first = np.unique(np.array(told.stamps, dtype=np.int64), return_index=True)
        names = tuple(dict.fromkeys(told.parents))
        number = {name: i for i, name in enumerate(names)}
        parent_of = np.array([number[name] for name in told.parents], dtype=np.int64)
        return _Edge(names, parent_of[first], stamps, np.array(told.poses)[first])

    def _ways_up(self, frame: str, stamps: IntArray) -> Iterator[tuple[IntArray, tuple[str, ...]]]:
        """The frames from `frame` up to its root, for the rows of stamps that share them."""
        waiting: list[tuple[IntArray, tuple[str, ...]]] = [(np.arange(len(stamps)), (frame,))]
        while waiting:
            rows, way = waiting.pop()
            edge = self._edge(way[-1])
            if edge is None:
                yield rows, way
                continue
            at = edge.parents_at(stamps[rows])
            for number in np.unique(at).tolist():
                part = rows[at == number]
                if number < 0:
                    yield part, way
                    continue
                parent = edge.parents[number]
                if parent in way:
                    raise DataError(f"frames {way[-1]!r} and {parent!r} lie in each other")
                waiting.append((part, (*way, parent)))

    def _pose_in(
        self, ancestor: str, way: tuple[str, ...], stamps: IntArray
    ) -> tuple[FloatArray, Rotation]:
        """The pose of the first frame of a way up in one further up."""
        from scipy.spatial.transform import Rotation

        found: tuple[FloatArray, Rotation] | None = None
        for frame in way[: way.index(ancestor)]:
            edge = self._edge(frame)
            assert edge is not None
            place, turn = edge.at(stamps)
            if found is not None:
                place, turn = turn.apply(found[0]) + place, turn * found[1]
            found = place, turn
        return found or (np.zeros((len(stamps), 3)), Rotation.identity(len(stamps)))


def axis_of(rotation: FloatArray, number: int) -> FloatArray:
    """Where a rotated axis points, (T, 3); NaN where the rotation (T, 4) is unknown."""
    from scipy.spatial.transform import Rotation  # half a second: not for those who need none

    axis = np.full((len(rotation), 3), math.nan)
    known = np.isfinite(rotation).all(axis=1)
    if known.any():
        axis[known] = Rotation.from_quat(rotation[known]).as_matrix()[:, :, number]
    return axis


def turned_by(turn: FloatArray, rotation: FloatArray) -> FloatArray:
    """Rotations (T, 4), then all turned by a matrix (3, 3)."""
    from scipy.spatial.transform import Rotation  # half a second: not for those who need none

    result = np.full((len(rotation), 4), math.nan)
    known = np.isfinite(rotation).all(axis=1)
    if known.any():
        both = Rotation.from_matrix(turn) * Rotation.from_quat(rotation[known])
        result[known] = both.as_quat()
    return result
