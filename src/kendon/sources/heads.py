"""When somebody of ROS4HRI is known, and whether by the face or by a body's head."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kendon.person import IntArray
from kendon.sources.ros4hri import Person
from kendon.sources.transforms import TransformTree

#: The head of a body stands in for a face that was lost for longer than this [ns].
FACE_LOST = 100_000_000


def head_frames(person: Person) -> list[str]:
    """The frames that tell where somebody's head is, the best first."""
    return [f"face_{i}" for i in person.faces] + [f"head_{i}" for i in person.bodies]


def head_stamps(tree: TransformTree, person: Person) -> IntArray:
    """When somebody was told of [ns], sorted, each stamp once."""
    return np.unique(np.concatenate([tree.stamps(frame) for frame in head_frames(person)]))


def newest_head(tree: TransformTree, person: Person) -> int:
    """When somebody was last known [ns]."""
    return max(map(tree.newest, head_frames(person)))


def heads(tree: TransformTree, person: Person, after: int = -1) -> tuple[IntArray, list[str]]:
    """When somebody is known, growing [ns], and by which frame each time.

    Args:
        tree: what was told.
        person: who.
        after: only later stamps are given [ns].
    """
    when: dict[int, str] = {}
    for face in person.faces:
        stamps = tree.stamps(f"face_{face}")
        for stamp in stamps[stamps > after - FACE_LOST].tolist():
            when.setdefault(stamp, f"face_{face}")
    faces = np.array(sorted(when), dtype=np.int64)
    for body in person.bodies:
        stamps = tree.stamps(f"head_{body}")
        stamps = stamps[stamps > after]
        for stamp in stamps[_far(stamps, faces, FACE_LOST)].tolist():
            when.setdefault(stamp, f"head_{body}")
    order = sorted(stamp for stamp in when if stamp > after)
    return np.array(order, dtype=np.int64), [when[stamp] for stamp in order]


def _far(stamps: IntArray, others: IntArray, limit: int) -> NDArray[np.bool_]:
    """Which stamps have no other one nearer than a limit; all in ns."""
    if not len(others):
        return np.ones(len(stamps), dtype=bool)
    after = np.clip(np.searchsorted(others, stamps), 1, len(others) - 1) if len(others) > 1 else 0
    nearest = np.minimum(np.abs(others[after] - stamps), np.abs(others[after - 1] - stamps))
    return np.asarray(nearest > limit)
