"""People of ROS4HRI (REP-155) as tracks: placed by TF in the robot's base frame.

A whole recording is placed at once, what is heard live piece by piece, by the same code.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kendon.errors import DataError
from kendon.features import ROBOT_FACE
from kendon.geometry import Vec3
from kendon.person import FloatArray, IntArray, Track
from kendon.sources.base import CameraMount
from kendon.sources.camera_geometry import MountedCamera
from kendon.sources.heads import head_frames, head_stamps, heads
from kendon.sources.ros4hri import HumansLog, Person, joint_frames
from kendon.sources.transforms import Poses, axis_of, turned_by
from kendon.tracks import MAX_COORDINATE

#: The robot's base, the best frame first (REP-105, REP-120).
BASES = ("base_footprint", "base_link")
#: In what the robot moves, likewise: `odom` first, as it never jumps, and speeds come from it.
WORLDS = ("odom", "map")
#: A gaze this near to the head's direction everywhere is no estimate of its own [rad].
_SAME_DIRECTION = 1e-3
_NANO = 1e-9
#: So many names are listed in a message.
_LISTED = 12


@dataclass(frozen=True)
class BagOptions:
    """What a user may know of a bag that it does not say."""

    base: str | None = None  # the robot's base frame; None = the first of `BASES` that is there
    camera: CameraMount = field(default_factory=CameraMount)  # of a bag without a base


@dataclass(frozen=True, eq=False)
class BagPerson:
    """One person of a bag."""

    track: Track
    notes: tuple[str, ...] = ()  # what a user should know about how it was read


@dataclass(eq=False)
class PlacingState:
    """What the pieces of a live reading know from those before them."""

    start: int  # [ns], when time is 0
    mounted: MountedCamera | None = None  # how the frame people are placed in sits on the robot
    gazing: set[str] = field(default_factory=set)  # who has a gaze that is not the head's
    robot: tuple[int, FloatArray] | None = None  # [ns], the last known pose in the world, (3,)


class PeopleReading:
    """Places the people of a recording in the robot's base frame.

    Args:
        path: of the recording, for messages; None = it is heard live.
        log: what was told of its people.
        people: everybody in it.
        options: what is known of its frames.
        state: of an earlier reading of the same people, which this one goes on from.

    Raises:
        DataError: the base frame asked for is not in it.
    """

    def __init__(
        self,
        path: Path | None,
        log: HumansLog,
        people: list[Person],
        options: BagOptions,
        state: PlacingState | None = None,
    ) -> None:
        self._path = path
        self._log = log
        self._tree = log.transforms
        self.state = state or PlacingState(
            min(int(head_stamps(self._tree, person)[0]) for person in people)
        )
        self._notes = log.notes()
        frames = self._tree.frames
        bases = [name for name in BASES if name in frames]
        seen = head_frames(people[0])[0]
        # One that is not connected is better than none: its error tells what is missing.
        base = options.base or next(
            (name for name in bases if self._tree.connected(name, seen)), next(iter(bases), None)
        )
        if base is not None and base not in frames:
            raise DataError(f"there is no frame {base!r}; valid: {listed(frames)}", file=path)
        self._camera = None if base else options.camera
        self._base = base or self._sensor(people)
        if base == "base_link":
            self._notes.append(
                "base_link is taken to lie on the floor, as no base_footprint is there."
            )
        self.has_base = self._camera is None
        self._world = next((w for w in WORLDS if base and self._tree.connected(w, base)), None)

    def person(self, person: Person) -> BagPerson:
        """The track of one person.

        Raises:
            DataError: their frames are not connected with the base, or are never known with it.
        """
        notes = list(self._notes)
        stamps, frames = heads(self._tree, person)
        track = self.track(person, stamps, frames, notes)
        if not np.isfinite(track.head).any():
            raise DataError(self.why_unknown(frames[0], stamps), file=self._path)
        self._note_face(frames, stamps, notes)
        return BagPerson(track, tuple(notes))

    def track(self, person: Person, stamps: IntArray, frames: list[str], notes: list[str]) -> Track:
        """One person at some stamps.

        Args:
            person: who.
            stamps: shape (N,) [ns], growing, and after those of the piece before.
            frames: the frame by which they are known, each time.
            notes: what a user should know is added.

        Raises:
            DataError: they are too far away for metres, or frames are each other's parents.
        """
        head, rotation = self._each(frames, stamps)
        mount = self._mount(head, notes)
        place, turn = mount.points(head), mount.rotation
        if (np.abs(place[np.isfinite(place)]) > MAX_COORDINATE).any():
            raise DataError(
                f"person {person.name} is more than {MAX_COORDINATE:g} m away (ROS counts in"
                " metres; are these millimetres?)",
                file=self._path,
            )
        eyes, gaze = self._gaze(person, frames, stamps, place, rotation, mount)
        return Track.build(
            np.asarray((stamps - self.state.start) * _NANO, dtype=np.float64),
            place,
            head_rotation=turned_by(turn, rotation),
            eyes=eyes,
            eye_gaze=gaze,
            joints=self._joints(person, stamps, mount, notes),
            smile=self._smiles(person, frames, stamps, notes),
            robot=self._robot(stamps, notes),
            name=f"{self._path.stem}_{person.name}" if self._path else person.name,
        )

    def awaited(self, person: Person, stamp: int, frame: str, within: int) -> bool:
        """Whether more is still to come about somebody at a stamp, as things go; all in ns."""
        tree = self._tree
        frames = [frame, self._base]
        if frame.startswith("face_"):
            face = frame.removeprefix("face_")
            frames.append(f"gaze_{face}")
            if self._log.smile_awaited(face, stamp, within):
                return True
        for body in person.bodies:
            frames += joint_frames(body, tree.frames).values()
        return any(tree.awaited(name, stamp, within) for name in frames)

    def _sensor(self, people: list[Person]) -> str:
        """The frame in which the first person is given: that of the camera."""
        first = people[0]
        frame = f"face_{first.faces[0]}" if first.faces else f"body_{first.bodies[0]}"
        return (self._tree.parents(frame) or [frame])[0]

    def _each(self, frames: list[str], stamps: IntArray) -> tuple[FloatArray, FloatArray]:
        """Where each stamp's own frame is in the base, (T, 3) and (T, 4)."""
        position = np.full((len(stamps), 3), math.nan)
        rotation = np.full((len(stamps), 4), math.nan)
        names = np.array(frames)
        for name in dict.fromkeys(frames):
            rows = np.flatnonzero(names == name)
            position[rows], rotation[rows] = self._lookup(name, stamps[rows])
        return position, rotation

    def _lookup(self, frame: str, stamps: IntArray) -> Poses:
        try:
            return self._tree.lookup(self._base, frame, stamps)
        except DataError as error:
            raise DataError(str(error), file=self._path) from None

    def _mount(self, head: FloatArray, notes: list[str]) -> MountedCamera:
        """How the frame in which people are placed sits on the robot: itself, or a camera."""
        if self._camera is None:
            return MountedCamera(np.eye(3), np.zeros(3))
        known = head[np.isfinite(head).all(axis=1)]
        if self.state.mounted is not None or not len(known):
            return self.state.mounted or MountedCamera.from_mount(self._camera)
        ahead, _, depth = np.median(known, axis=0).tolist()
        # Many drivers name an optical frame just "camera"; people stand ahead of cameras.
        optical = "optical" in self._base or depth > ahead
        mounted = MountedCamera.from_mount(self._camera)
        if not optical:
            level = MountedCamera.from_mount(CameraMount()).rotation
            mounted = MountedCamera(mounted.rotation @ level.T, mounted.position)
        place = _point(self._camera.position)
        axes = "z ahead" if optical else "x ahead"
        notes.append(
            f"There is no {' or '.join(BASES)} in it: {self._base} ({axes}) is taken to be a camera"
            f" at {place} on a robot that stands still (--camera-pose)."
        )
        if self._camera.position != ROBOT_FACE:
            notes.append(
                f"For gaze at the camera give it as the robot's face (--robot-face {place})."
            )
        if self._path is None:
            self.state.mounted = mounted
        return mounted

    def _note_face(self, frames: list[str], stamps: IntArray, notes: list[str]) -> None:
        """Where the camera is that saw the face: the likely face of a robot with a base."""
        if self._camera is not None or not frames[0].startswith("face_"):
            return
        sensor = self._tree.parents(frames[0])[0]
        position = self._lookup(sensor, stamps).position
        known = position[np.isfinite(position).all(axis=1)]
        if sensor in (self._base, *WORLDS) or not len(known):
            return
        x, y, z = np.median(known, axis=0).tolist()
        notes.append(
            f"The camera that sees the face, {sensor}, is at {_point((x, y, z))}: if the robot's"
            f" face is there, give it for gaze (--robot-face {_point((x, y, z))})."
        )

    def _gaze(
        self,
        person: Person,
        frames: list[str],
        stamps: IntArray,
        place: FloatArray,
        rotation: FloatArray,
        mount: MountedCamera,
    ) -> tuple[FloatArray | None, FloatArray | None]:
        """Eyes (T, 2, 3) and their directions, once more is known of the gaze than of the head."""
        # The head of a body has no gaze frame: that of no name is unknown.
        gazes = [f"gaze_{f[5:]}" if f.startswith("face_") else "" for f in frames]
        turn = self._each(gazes, stamps)[1]
        # The gaze frame is an optical one, the head's x axis points out of the face (REP-155).
        directions, ahead = axis_of(turn, 2), axis_of(rotation, 0)
        cosine = np.einsum("ij,ij->i", directions, ahead)
        # The comparison is false for what is unknown.
        off = np.arccos(np.clip(cosine, -1, 1)) > _SAME_DIRECTION
        told = np.logical_or.accumulate(off) | (person.name in self.state.gazing)
        if not told.any():
            return None, None
        self.state.gazing.add(person.name)
        directions = np.where(told[:, None], directions, math.nan)
        # One direction for both eyes, out of the point between them, where the face frame lies.
        both = np.where(np.isfinite(directions), place, math.nan)
        ways = mount.directions(directions)
        return np.stack([both, both], axis=1), np.stack([ways, ways], axis=1)

    def _joints(
        self, person: Person, stamps: IntArray, mount: MountedCamera, notes: list[str]
    ) -> dict[str, FloatArray]:
        joints: dict[str, FloatArray] = {}
        for body in person.bodies:
            for joint, frame in joint_frames(body, self._tree.frames).items():
                points = mount.points(self._lookup(frame, stamps).position)
                far = (np.abs(points) > MAX_COORDINATE).any(axis=1)  # False for NaN
                if far.any():
                    points[far] = math.nan
                    notes.append(f"{frame} is farther than {MAX_COORDINATE:g} m: left out there.")
                told = joints.get(joint)
                joints[joint] = points if told is None else np.where(np.isnan(told), points, told)
        return joints

    def _smiles(
        self, person: Person, frames: list[str], stamps: IntArray, notes: list[str]
    ) -> FloatArray | None:
        smiles = np.full(len(stamps), math.nan)
        names = np.array(frames)
        for face in person.faces:
            told, note = self._log.smiles(face, stamps)
            if told is not None:
                rows = names == f"face_{face}"
                smiles[rows] = told[rows]
            if note and note not in notes:
                notes.append(note)
        return smiles if np.isfinite(smiles).any() else None

    def _robot(self, stamps: IntArray, notes: list[str]) -> FloatArray | None:
        """The robot's pose in the world at each stamp, (T, 3); None = it stands still."""
        if self._camera is not None:
            return None
        if self._world is not None:
            poses = self._tree.lookup(self._world, self._base, stamps)
            known = np.isfinite(poses.position).all(axis=1)
            ahead = axis_of(poses.rotation[known], 0)
            columns = np.column_stack(
                [poses.position[known, :2], np.arctan2(ahead[:, 1], ahead[:, 0])]
            )
            when = stamps[known]
            if self.state.robot is not None:
                before, pose = self.state.robot
                when, columns = np.append(before, when), np.vstack([pose, columns])
            if len(when):
                columns[:, 2] = np.unwrap(columns[:, 2])
                if self._path is None:
                    self.state.robot = int(when[-1]), columns[-1]
                # A robot's pose must be known in every frame: between known ones a straight way.
                return np.stack([np.interp(stamps, when, c) for c in columns.T], axis=1)
            told = self._tree.stamps(self._base)
            known_when = f" (stamped from {_seconds(told)} s)" if len(told) else ""
            reason = f"is never known in {self._world}{known_when} while people are seen"
            reason += f" (stamped from {_seconds(stamps)} s)"
        else:
            reason = f"has no place in {' or '.join(WORLDS)}"
        notes.append(f"The frame {self._base} {reason}: the robot is taken to stand still.")
        return None

    def why_unknown(self, frame: str, stamps: IntArray) -> str:
        """Why a frame is nowhere known in the base."""
        if not self._tree.connected(self._base, frame):
            return (
                f"no transforms connect {frame} with {self._base} (was /tf_static recorded?);"
                f" frames in it: {listed(self._tree.frames)}"
            )
        for other in self._ancestors(self._base) + self._ancestors(frame):
            told = self._tree.stamps(other)
            if len(told) and (told[0] > stamps[-1] or told[-1] < stamps[0]):
                return (
                    f"{frame} is stamped from {_seconds(stamps)} s, but {other} from"
                    f" {_seconds(told)} s: these are two clocks"
                )
        return f"{frame} and {self._base} are never known at the same time"

    def _ancestors(self, frame: str) -> list[str]:
        found = [frame]
        for name in found:
            found += [p for p in self._tree.parents(name) if p not in found]
        return found


def listed(names: Sequence[str]) -> str:
    """Names for a message, not too many of them."""
    more = ", …" if len(names) > _LISTED else ""
    return (", ".join(names[:_LISTED]) + more) or "none"


def _point(point: Vec3) -> str:
    return ",".join(f"{value:.3g}" for value in point)


def _seconds(stamps: IntArray) -> str:
    return f"{stamps[0] * _NANO:.1f} to {stamps[-1] * _NANO:.1f}"
