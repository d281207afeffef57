"""Where the robot is in the world: by its localisation's pose, or by the frames of TF."""

from __future__ import annotations

import bisect
import math
import threading
from collections import deque
from typing import Any

from kendon.geometry import ORIGIN, Pose2D, quaternion_yaw, wrap_angle
from kendon.sources.ros_stamps import MAX_LATE, TWO_CLOCKS, seconds

#: The names of the robot's base and of the world, the best ones first (REP-105).
BASES = ("base_footprint", "base_link")
WORLDS = ("map", "odom", "world")
#: Maps may count from far away, but not from farther than the Earth is round [m].
FARTHEST = 1e8
#: So many poses are remembered: two seconds at 100 Hz.
_KEPT = 200


class RobotPlace:
    """Remembers where the robot was lately; told by one thread, asked by another.

    Frames count more than a localisation's poses: those come only every few decimetres of a
    drive, and a speed measured between them would be the robot's own.

    Args:
        base: the robot's base frame, if it is none of `BASES`.
    """

    def __init__(self, base: str | None = None) -> None:
        self.bases = (base,) if base else BASES
        self.known = False  # whether anything was told
        self.world = WORLDS[0]  # the name of the frame in which the poses are
        self._edges: dict[str, tuple[str, float, Pose2D]] = {}  # child -> parent, stamp, pose
        self.by_frames = False  # whether frames tell it, and poses no longer count
        self._stamps: deque[float] = deque(maxlen=_KEPT)
        self._poses: deque[Pose2D] = deque(maxlen=_KEPT)
        self._lock = threading.Lock()

    @property
    def pose(self) -> Pose2D:
        """The newest pose; the origin before the first."""
        with self._lock:
            return self._poses[-1] if self._poses else ORIGIN

    def at(self, stamp: float) -> Pose2D:
        """Where the robot was at a stamp [s].

        Out of what is remembered it is the nearest pose; far out of it, by a clock of another
        kind, the newest.
        """
        with self._lock:
            if not self._poses:
                return ORIGIN
            stamps, poses = list(self._stamps), list(self._poses)
        after = bisect.bisect_left(stamps, stamp)
        if after == 0:
            return poses[0] if stamps[0] - stamp <= TWO_CLOCKS else poses[-1]
        if after == len(stamps):
            return poses[-1]
        first, second = poses[after - 1], poses[after]
        share = (stamp - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
        return Pose2D(
            first.x + share * (second.x - first.x),
            first.y + share * (second.y - first.y),
            first.yaw + share * wrap_angle(second.yaw - first.yaw),
        )

    def take_localised(self, message: Any) -> None:
        """Take in a PoseWithCovarianceStamped, as on ``/amcl_pose``."""
        if not self.by_frames:
            pose = message.pose.pose
            self._remember(seconds(message.header.stamp), _planar(pose.position, pose.orientation))

    def take_transforms(self, message: Any, *, static: bool = False) -> None:
        """Take in the transforms of a message of ``/tf`` or ``/tf_static``."""
        moved = False
        for told in message.transforms:
            child = told.child_frame_id.lstrip("/")
            pose = _planar(told.transform.translation, told.transform.rotation)
            parent = told.header.frame_id.lstrip("/")
            self._edges[child] = parent, 0.0 if static else seconds(told.header.stamp), pose
            moved = moved or child in self.bases or child in WORLDS
        if moved and (found := self._by_way_of_frames()):
            if not self.by_frames:
                self.by_frames = True
                self._forget()  # the origins of the two ways may differ
            stamp, self.world, pose = found
            self._remember(stamp, pose)

    def _by_way_of_frames(self) -> tuple[float, str, Pose2D] | None:
        """The stamp of the base, the outermost world its frames lead to, its pose in that."""
        base = next((name for name in self.bases if name in self._edges), None)
        if base is None:
            return None
        frame, pose, stamp = base, ORIGIN, 0.0
        found: tuple[str, Pose2D] | None = None
        for _ in range(len(self._edges)):  # no longer, even where frames lie in each other
            if frame not in self._edges:
                break
            frame, when, step = self._edges[frame]
            x, y, _ = step.to_world((pose.x, pose.y, 0.0))
            pose = Pose2D(x, y, wrap_angle(step.yaw + pose.yaw))
            # The first stamp is that of the base's own motion; corrections of the frames above
            # it come more rarely, and are dated ahead.
            stamp = stamp or when
            if frame in WORLDS:
                found = frame, pose
        return (stamp, *found) if found and stamp else None

    def _remember(self, stamp: float, pose: Pose2D) -> None:
        x, y, yaw = pose
        if not (abs(x) <= FARTHEST and abs(y) <= FARTHEST and math.isfinite(yaw)):  # or NaN
            return
        with self._lock:
            if self._stamps and stamp <= self._stamps[-1]:
                if self._stamps[-1] - stamp <= MAX_LATE:
                    return  # late, or told again
                self._stamps.clear()  # a clock that began again
                self._poses.clear()
            self._stamps.append(stamp)
            self._poses.append(pose)
            self.known = True

    def _forget(self) -> None:
        with self._lock:
            self._stamps.clear()
            self._poses.clear()


def _planar(position: Any, orientation: Any) -> Pose2D:
    q = (orientation.x, orientation.y, orientation.z, orientation.w)
    return Pose2D(position.x, position.y, quaternion_yaw(q))
