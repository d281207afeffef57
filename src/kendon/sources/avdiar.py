"""The AVDIAR dataset (Gebru et al. 2018): people in a room before two cameras side by side.

People are marked in the left camera's images (see `avdiar_marks`); depth comes from the pair of
videos and their calibration (see `stereo`), as in the thesis (3.5.1). The robot stands under the
partner's face and looks toward the person's: nothing good enough is known of the body. Gaze is
unknown; the thesis marked it by hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kendon.errors import DataError, ParameterError
from kendon.person import JOINTS, FloatArray, IntArray, PersonFrame, Track
from kendon.sources.avdiar_marks import FILE_JOINTS, Marks, read_marks
from kendon.sources.base import Source, SourceOptions, register
from kendon.sources.pairs import Body, choose_pair, floor_height, greeting, split_spec
from kendon.sources.stereo import NEAREST, StereoRig, StereoVideo, point_at, row_offset
from kendon.sources.stereo_calibration import read_stereo_calibration
from kendon.sources.video import SUFFIXES

#: Frames a second (the dataset's documentation).
RATE = 25.0
#: Where the floor is not seen, faces are taken to be this high in the median: the face of an
#: adult of 1.67 m, the mean of women and men of the world [m].
FACE_HEIGHT = 1.55
#: Names under which the dataset's marks are found.
_NAMES = ("groundtruth.txt", "face_bb.txt")
_FLOOR_NOTE = (
    "No ankle is seen, so that the floor is unknown: faces are taken to be"
    f" {FACE_HEIGHT:g} m above it in the median."
)
_ANKLES = [FILE_JOINTS.index("l_ankle"), FILE_JOINTS.index("r_ankle")]
_CALIBRATIONS = (".yml", ".yaml", ".xml", ".npz")
#: Corners of a rectified pair differ by less than this in the median [px].
_SAME_ROW = 2.0


@dataclass(frozen=True)
class AvdiarOptions:
    """What a user may know of a recording that its files do not say."""

    left: Path | None = None  # the left camera's video; None = found beside the marks
    right: Path | None = None  # the right camera's video
    calibration: Path | None = None  # see `kendon.sources.stereo_calibration`
    rectify: bool | None = None  # None = as the calibration says, else the videos are rectified
    unit: str | None = None  # of the calibration's lengths; None = as it says, else mm
    marked_size: tuple[int, int] | None = None  # [px], of the images marked; None = the videos'
    first_frame: int = 1  # the number of the videos' first frame in the marks
    fps: float = RATE  # [1/s]
    nearest: float = NEAREST  # [m], nothing nearer to the cameras is looked for
    camera_height: float | None = None  # [m], above the floor; None = found from the ankles

    def __post_init__(self) -> None:
        for name in ("fps", "nearest", "camera_height"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise ParameterError(f"{name} must be positive, not {value}")
        if self.marked_size is not None and min(self.marked_size) < 1:
            raise ParameterError(f"marked_size must be positive, not {self.marked_size}")


@register
class AvdiarSource(Source):
    """One person of an AVDIAR sequence, the robot in the place of another."""

    name = "avdiar"
    reads = "AVDIAR groundTruth.txt or face_bb.txt with both videos; #2-1 picks the two people"
    example = "groundTruth.txt#1-2"

    def __init__(self, recording: _Recording, person: int, partner: int) -> None:
        self._recording = recording
        self._pair = person, partner
        self._track: Track | None = None
        self.notes = recording.notes

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """``groundTruth.txt`` or ``face_bb.txt``, or with ``#person-partner`` behind it."""
        return split_spec(spec)[0].name.lower() in _NAMES

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> AvdiarSource:
        """Check marks, videos and calibration; depth is worked out when frames are asked for.

        Raises:
            DataError: a file is missing or wrong, or there is no such pair.
            MissingExtraError: OpenCV is not installed.
        """
        path, person, partner = split_spec(spec)
        marks = read_marks(path)
        pair = choose_pair(path, list(marks.people), person, partner)
        return cls(_Recording(marks, AvdiarOptions(fps=options.fps or RATE)), *pair)

    def frames(self) -> Iterator[PersonFrame]:
        """The person, frame by frame.

        Raises:
            DataError: a video breaks off, or the two are never both seen in depth.
        """
        return iter(self.record())

    def record(self, progress: Callable[[PersonFrame], None] | None = None) -> Track:
        """The whole track; matching both images takes about 0.1 s a frame."""
        if self._track is None:
            self._track = self._recording.tracks([self._pair])[0]
            self.notes = self._recording.notes
        for frame in self._track if progress else ():
            progress(frame)  # type: ignore[misc]
        return self._track


def read_avdiar_pairs(path: str | Path, options: AvdiarOptions | None = None) -> list[Track]:
    """The greetings of everybody with everybody else who is marked at the same time.

    Args:
        path: of ``groundTruth.txt`` or ``face_bb.txt``.
        options: where videos and calibration are, and what is known of them.

    Raises:
        DataError: a file is missing or wrong, or no two people are seen at the same time.
        MissingExtraError: OpenCV is not installed.
    """
    marks = read_marks(path)
    people = list(marks.people)
    choose_pair(Path(path), people, None, None)
    seen = {person: np.isfinite(marks.faces(person)[:, 0]) for person in people}
    pairs = [(a, b) for a in people for b in people if a != b and (seen[a] & seen[b]).any()]
    if not pairs:
        raise DataError("no two people are ever marked in the same frame", file=path)
    return _Recording(marks, options or AvdiarOptions()).tracks(pairs)


class _Recording:
    """Marks with the videos they were made in and the cameras' calibration."""

    def __init__(self, marks: Marks, options: AvdiarOptions) -> None:
        self._marks = marks
        self._options = options
        left, right, file = _find_files(marks.path, options)
        self._video = StereoVideo(left, right)
        calibration = read_stereo_calibration(file, unit=options.unit)
        notes = []
        rectify = options.rectify
        if rectify is None and calibration.rectified is not None:
            rectify = not calibration.rectified
        if rectify is None:
            rectify = False
            notes.append(
                f"The videos are taken to be rectified already, as {file.name} does not say"
                " (rectified: 0 or 1)."
            )
        if self._video.fps > 0 and abs(self._video.fps / options.fps - 1) > 0.01:
            notes.append(
                f"{left.name} claims {self._video.fps:.2f} frames a second;"
                f" read at {options.fps:g}."
            )
        self._rig = StereoRig(calibration, self._video.size, rectify=rectify)
        self._scale = self._marks_to_video()
        if int(marks.frames[0]) < options.first_frame:
            raise DataError(
                f"frame {marks.frames[0]} lies before the video's first, {options.first_frame}",
                file=marks.path,
            )
        offset = self._row_offset()
        if offset > _SAME_ROW:
            notes.append(
                f"The same point lies {offset:.1f} rows apart in the two images, so that depth is"
                " doubtful: are the videos rectified, and is the calibration theirs?"
            )
        if options.camera_height is None and not self._ankles_marked():
            notes.append(_FLOOR_NOTE)
        self.notes: tuple[str, ...] = tuple(notes)

    def tracks(self, pairs: list[tuple[int, int]]) -> list[Track]:
        """One track a pair of person and partner."""
        people = sorted({person for pair in pairs for person in pair})
        points = self._points(people)
        floor = self._floor(points)
        bodies = {p: _body(points[p], floor) for p in people}
        t = (self._marks.frames - self._options.first_frame) / self._options.fps
        folder = self._marks.path.resolve().parent
        name = folder.parent.name if folder.name.lower() == "groundtruth" else folder.name
        return [
            greeting(t, bodies[one], bodies[two], f"{name}_p{one}_p{two}").track
            for one, two in pairs
        ]

    def _points(self, people: list[int]) -> dict[int, FloatArray]:
        """Joints and, last, the face of each person, (F, 19, 3) [m].

        The left camera's optical frame. Images in which fewer than two people are marked are
        not matched: nobody's greeting needs them.
        """
        marks, options = self._marks, self._options
        places = {
            p: np.concatenate([marks.people[p], marks.faces(p)[:, None]], axis=1) for p in people
        }
        rows = self._rows_together(people)
        shape = (len(marks.frames), len(FILE_JOINTS) + 1, 3)
        points = {p: np.full(shape, math.nan) for p in people}
        shift = int(marks.frames[0]) - options.first_frame
        for number, left, right in self._video.frames((rows + shift).tolist()):
            row = number - shift
            depth = self._rig.depth(left, right, nearest=options.nearest)
            for p in people:
                pixels = self._rig.pixels(places[p][row] * self._scale + (self._scale - 1) / 2)
                points[p][row] = [point_at(depth, (x, y)) for x, y in pixels.tolist()]
        return points

    def _rows_together(self, people: list[int]) -> IntArray:
        """The frames, as rows of the marks, in which the faces of two people are marked."""
        seen = [np.isfinite(self._marks.faces(p)[:, 0]).astype(int) for p in people]
        return np.flatnonzero(np.sum(seen, axis=0) >= 2)

    def _row_offset(self) -> float:
        """How many rows apart the first usable pair shows the same point; NaN = unknown."""
        rows = self._rows_together(list(self._marks.people))[:1]
        shift = int(self._marks.frames[0]) - self._options.first_frame
        for _, left, right in self._video.frames((rows + shift).tolist()):
            return row_offset(*self._rig.images(left, right))
        return math.nan

    def _ankles_marked(self) -> bool:
        return any(np.isfinite(marks[:, _ANKLES]).any() for marks in self._marks.people.values())

    def _floor(self, points: dict[int, FloatArray]) -> float:
        """How high the floor lies above the camera (a negative number) [m]."""
        if self._options.camera_height is not None:
            return -self._options.camera_height
        feet = [-p[:, _ANKLES, 1] for p in points.values()]
        if any(np.isfinite(pair).any() for pair in feet):
            return floor_height(feet, self._marks.path)
        faces = np.concatenate([-p[:, -1, 1] for p in points.values()])
        faces = faces[np.isfinite(faces)]
        if not len(faces):
            raise DataError(
                "no face has a depth: do the videos and the calibration belong together?",
                file=self._marks.path,
            )
        if _FLOOR_NOTE not in self.notes:  # ankles are marked, but none has a depth
            self.notes = (*self.notes, _FLOOR_NOTE)
        return float(np.median(faces)) - FACE_HEIGHT

    def _marks_to_video(self) -> float:
        """By how much marks are scaled to the videos' pixels."""
        width, height = self._video.size
        marked = self._options.marked_size or self._video.size
        x, y = self._marks.extent
        if x > marked[0] or y > marked[1]:
            raise DataError(
                f"a mark at {x:g}, {y:g} lies outside the images of {marked[0]} x {marked[1]}"
                " pixels; say the size of the images marked (marked_size of AvdiarOptions)",
                file=self._marks.path,
            )
        factor = width / marked[0]
        if abs(height / marked[1] / factor - 1) > 0.01:
            raise DataError(
                f"images of {marked[0]} x {marked[1]} pixels were marked, the videos have"
                f" {width} x {height}, which is another shape",
                file=self._marks.path,
            )
        return factor


def _body(points: FloatArray, floor: float) -> Body:
    """Optical points (F, 19, 3), the last of them the face, as a body on the floor."""
    # A level camera: its z runs ahead, its x to the right, its y down.
    world = np.stack([points[:, :, 2], -points[:, :, 0], -points[:, :, 1] - floor], axis=2)
    head = world[:, -1]
    joints = {name: world[:, FILE_JOINTS.index(name)] for name in JOINTS}
    unknown = np.full(len(points), math.nan)
    tracked = {name: place for name, place in joints.items() if np.isfinite(place).any()}
    return Body(head, head[:, :2], unknown, tracked)


def _find_files(path: Path, options: AvdiarOptions) -> tuple[Path, Path, Path]:
    """The left video, the right video and the calibration: as told, else around the marks.

    The original release keeps marks in ``GroundTruth`` and videos, named ``…_CAM1`` and
    ``…_CAM2``, in ``Video``; one calibration serves many sequences, so it may lie higher up.
    """
    home = path.resolve().parent
    sequence = home.parent if home.name.lower() == "groundtruth" else home
    near = [home, home / "Video", sequence, sequence / "Video"]
    videos = [f for f in _files(near) if f.suffix.lower() in SUFFIXES]
    left = options.left or _only([f for f in videos if _side(f) == 1], "left videos", path)
    right = options.right or _only([f for f in videos if _side(f) == 2], "right videos", path)
    calibration = options.calibration
    for folders in ([*near, sequence / "Calibration"], [sequence.parent]):
        if calibration is None:
            found = [
                f
                for f in _files(folders)
                if f.suffix.lower() in _CALIBRATIONS
                and f.stem.lower().startswith(("calib", "stereo"))
            ]
            calibration = _only(found, "calibrations", path)
    if left is None or right is None or calibration is None:
        missing = [
            what
            for what, file in (
                ("the left camera's video (…_CAM1.mp4)", left),
                ("the right camera's video (…_CAM2.mp4)", right),
                ("the stereo calibration (calibration.yml or .npz)", calibration),
            )
            if file is None
        ]
        raise DataError(
            f"marks in images have no depth by themselves; missing beside them:"
            f" {', '.join(missing)}",
            file=path,
        )
    return left, right, calibration


def _files(folders: list[Path]) -> list[Path]:
    return sorted({f for folder in folders if folder.is_dir() for f in folder.iterdir()})


def _side(video: Path) -> int:
    stem = video.stem.lower()
    return 1 if stem.endswith(("cam1", "left")) else 2 if stem.endswith(("cam2", "right")) else 0


def _only(found: list[Path], what: str, path: Path) -> Path | None:
    if len(found) > 1:
        raise DataError(
            f"several {what} lie here ({', '.join(f.name for f in found)});"
            " name one with AvdiarOptions",
            file=path,
        )
    return found[0] if found else None
