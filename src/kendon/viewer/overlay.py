"""A video that shows why kendon reads what it reads: faces, gaze, observations, belief.

On the picture: a box around every face, bright around the greeted one, with its number and
distance, and where it looks. Beside it: the newest observation and the belief after it.
"""

from __future__ import annotations

import math
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from kendon.errors import DataError
from kendon.features import ROBOT_FACE
from kendon.features.gaze import (
    EYES_ONLY_WITHIN,
    HEAD_ONLY_BEYOND,
    blend,
    gaze_of_eyes,
    gaze_of_head,
)
from kendon.geometry import Vec3
from kendon.observations import FEATURES, UNITS
from kendon.outputs import check_file, whole_file
from kendon.person import FloatArray, PersonFrame
from kendon.phases import Phase
from kendon.sources.camera_geometry import import_cv2
from kendon.sources.face_finder import ByteImage
from kendon.sources.face_person import SeenPerson
from kendon.sources.pictures import Look
from kendon.sources.quiet import quiet_stderr
from kendon.watch import WatchedFrame

#: The kinds of files that can be written, with codecs that OpenCV brings along.
CODECS = {".mp4": "mp4v", ".avi": "MJPG"}
#: Frames a second where the source does not say; a live camera's come as they come.
_RATE = 20.0
#: Heights of the picture that stay legible and quick to write [px].
_LOWEST, _HIGHEST = 540, 1080
#: Width of the panel, as a share of the picture's height.
_PANEL = 0.55
#: A gaze ray is drawn so long, as a share of the way to the camera: drawn in full, the rays of
#: people near by would leave the picture.
_RAY = 0.2
#: A silence of the source is shown for so long at most [s].
_LONGEST_STILL = 5.0

_Color = tuple[int, int, int]
#: Blue, green, red.
_INK: _Color = (235, 235, 235)
_SOFT: _Color = (150, 150, 150)
_GROUND: _Color = (34, 34, 34)
_EMPTY: _Color = (64, 64, 64)
_BAR: _Color = (200, 180, 120)
#: The gaze ray of somebody who looks at the robot, and of somebody who does not.
_AT, _BESIDE = (90, 220, 90), (60, 150, 255)
#: Where the bar of each feature ends: ordinary values of greetings.
_ENDS = {"distance": 5.0, "speed": 2.0, "gaze": 2.0, "smile": 5.0}


class OverlayVideo:
    """Writes the video, frame by frame; use it in a ``with`` statement.

    It is written under another name first: only a whole video bears the one asked for.

    Args:
        path: of the video, .mp4 or .avi.
        rate: frames a second; NaN where the source does not know, then 20.
        robot_face: the robot's face in its base frame [m].

    Raises:
        DataError: the ending is another, or the file cannot be written.
    """

    def __init__(self, path: Path, rate: float, robot_face: Vec3 = ROBOT_FACE) -> None:
        check_overlay(path)
        self._cv2 = import_cv2("drawing an overlay")
        self._path = path
        self._opened = ExitStack()
        self._rate = rate if math.isfinite(rate) else _RATE
        self._face = robot_face
        self._writer: Any = None
        self._size = (0, 0)
        self._written = 0

    def add(self, watched: WatchedFrame) -> None:
        """Draw a frame and write it as often as its stamp asks for.

        Raises:
            DataError: this OpenCV cannot write such a video.
        """
        if watched.look is None or watched.look.picture.image is None:
            return
        image = draw_overlay(watched, self._face)
        if self._writer is None:
            self._open(image)
        if (image.shape[1], image.shape[0]) != self._size:
            image = self._cv2.resize(image, self._size)
        due = round(watched.frame.t * self._rate) + 1
        times = min(max(due - self._written, 0), round(_LONGEST_STILL * self._rate))
        for _ in range(times):
            self._writer.write(image)
        self._written = max(self._written, due)

    def _open(self, image: ByteImage) -> None:
        self._size = (image.shape[1], image.shape[0])
        codec = CODECS[self._path.suffix.lower()]
        part = self._opened.enter_context(whole_file(self._path))
        with quiet_stderr():
            writer = self._cv2.VideoWriter(
                str(part), self._cv2.VideoWriter.fourcc(*codec), self._rate, self._size
            )
        if not writer.isOpened():
            other = " or name an .avi instead" if codec != "MJPG" else ""
            raise DataError(
                f"this video cannot be written (codec {codec}, {self._size[0]} x {self._size[1]}"
                f" pixels); check that the folder can be written to{other}",
                file=self._path,
            )
        self._opened.callback(writer.release)
        self._writer = writer

    def __enter__(self) -> OverlayVideo:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._opened.__exit__(kind, error, trace)


def check_overlay(path: Path) -> None:
    """Refuse a video that cannot be written.

    Raises:
        DataError: the ending is another than those of `CODECS`, or the file cannot be written.
    """
    if path.suffix.lower() not in CODECS:
        raise DataError(f"an overlay is an {' or '.join(CODECS)} file", file=path)
    check_file(path)


def draw_overlay(watched: WatchedFrame, robot_face: Vec3 = ROBOT_FACE) -> ByteImage:
    """The picture of a frame with everything drawn, (height, width, 3) BGR.

    Args:
        watched: a frame with a picture.
        robot_face: the robot's face in its base frame [m].
    """
    look = watched.look
    if look is None or look.picture.image is None:
        raise DataError("there is no picture to draw on")
    cv2 = import_cv2("drawing an overlay")
    height, width = look.picture.image.shape[:2]
    scale = min(max(height, _LOWEST), _HIGHEST) / height
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    picture = cv2.resize(
        look.picture.image, (2 * round(width * scale / 2), 2 * round(height * scale / 2)),
        interpolation=way,
    )  # fmt: skip
    pen = _Pen(cv2, picture, picture.shape[0] / 540)
    for person in look.scene.people:
        _draw_person(pen, look, person, scale, robot_face)
    panel = np.full((picture.shape[0], 2 * round(picture.shape[0] * _PANEL / 2), 3), _GROUND,
                    dtype=np.uint8)  # fmt: skip
    _draw_panel(_Pen(cv2, panel, panel.shape[0] / 540), watched)
    return np.hstack([picture, panel])


class _Pen:
    """Draws on an image in units of which 540 are its height."""

    def __init__(self, cv2: Any, image: ByteImage, unit: float) -> None:
        self.cv2, self.image, self.unit = cv2, image, unit

    def text(
        self, x: float, y: float, words: str, color: _Color = _INK, *, size: float = 1.0,
        right: bool = False,
    ) -> None:  # fmt: skip
        """Write, starting (or ending) at x, standing on y [units]; 1 is the size of small text."""
        font, scale = self.cv2.FONT_HERSHEY_SIMPLEX, 0.5 * size * self.unit
        thick = max(1, round(size * self.unit))
        (width, height), below = self.cv2.getTextSize(words, font, scale, thick)
        left, base = round(x * self.unit), round(y * self.unit)
        if right:
            left -= width
        self.cv2.rectangle(
            self.image, (left - 2, base - height - 2), (left + width + 2, base + below), _GROUND, -1
        )
        self.cv2.putText(
            self.image, words, (left, base), font, scale, color, thick, self.cv2.LINE_AA
        )

    def box(self, x: float, y: float, width: float, height: float, color: _Color) -> None:
        """A filled rectangle [units]; negative widths go to the left."""
        start, end = sorted((x * self.unit, (x + width) * self.unit))
        self.cv2.rectangle(
            self.image, (round(start), round(y * self.unit)),
            (round(end), round((y + height) * self.unit)), color, -1,
        )  # fmt: skip


def _draw_person(pen: _Pen, look: Look, person: SeenPerson, scale: float, robot_face: Vec3) -> None:
    cv2, box = pen.cv2, person.face.box
    greeted = person.face.number == look.scene.greeted
    color = _INK if greeted else _SOFT
    corners = [round(v * scale) for v in (box.x, box.y, box.x + box.width, box.y + box.height)]
    thick = max(1, round((2 if greeted else 1) * pen.unit))
    cv2.rectangle(pen.image, tuple(corners[:2]), tuple(corners[2:]), color, thick, cv2.LINE_AA)
    words = f"{person.face.number}"
    if person.pose is None:
        words += " too far or turned away"
    else:
        words += f"  {math.hypot(*person.frame.head[:2]):.2f} m"
    y = corners[1] - 6 if corners[1] > 24 * pen.unit else corners[3] + 18 * pen.unit
    pen.text(max(corners[0], 4) / pen.unit, y / pen.unit, words, color)
    if person.pose is not None:
        start, direction = gaze_ray(person)
        ends = np.array([start, start + _RAY * start[2] * direction])
        if (ends[:, 2] > 0.05).all():
            tail, tip = np.rint(look.camera.bend(look.camera.project(ends)) * scale).astype(int)
            looks = frame_gaze(person.frame, robot_face) < 1.0
            hue = _AT if looks else _BESIDE
            cv2.arrowedLine(
                pen.image, tuple(tail.tolist()), tuple(tip.tolist()), hue,
                max(2, round(3 * pen.unit)), cv2.LINE_AA, tipLength=0.2,
            )  # fmt: skip
            if looks:
                cv2.circle(pen.image, tuple(tail.tolist()), round(9 * pen.unit), hue, 2,
                           cv2.LINE_AA)  # fmt: skip
    for place in person.frame.joints.values():
        point = look.mounted.rotation.T @ (np.array(place) - look.mounted.position)
        if point[2] > 0.05:
            spot = np.rint(look.camera.bend(look.camera.project(point[None])) * scale).astype(int)
            cv2.circle(pen.image, tuple(spot[0].tolist()), round(5 * pen.unit), color, -1)


def gaze_ray(person: SeenPerson) -> tuple[FloatArray, FloatArray]:
    """Where a person's gaze starts (3,) [m] and its unit direction (3,), in the optical frame.

    The eyes' direction near, the head's far, as the gaze feature weighs them; the person's pose
    must be known.
    """
    pose = person.pose
    if pose is None:
        raise DataError("a face without a pose has no gaze")
    head = pose.rotation[:, 0]
    if person.eyes is None:
        return pose.position, head
    way = math.hypot(*person.frame.head[:2])
    weight = (HEAD_ONLY_BEYOND - way) / (HEAD_ONLY_BEYOND - EYES_ONLY_WITHIN)
    weight = min(max(weight, 0.0), 1.0)
    mixed = weight * person.eyes.gaze.mean(axis=0) + (1 - weight) * head
    return person.eyes.centres.mean(axis=0), mixed / np.linalg.norm(mixed)


def frame_gaze(frame: PersonFrame, robot_face: Vec3) -> float:
    """The gaze feature of one frame (thesis 3.8)."""
    head = gaze_of_head(frame.head, frame.head_rotation, robot_face)
    if frame.eyes is None or frame.eye_gaze is None:
        return head
    eyes = gaze_of_eyes(frame.eyes, frame.eye_gaze, robot_face)
    return blend(eyes, head, math.hypot(*frame.head[:2]))


def _draw_panel(pen: _Pen, watched: WatchedFrame) -> None:
    width = pen.image.shape[1] / pen.unit
    left, right = 14.0, width - 14.0
    bar_left, bar_right = left + 78, right - 76
    pen.text(left, 28, f"{watched.frame.t:.1f} s", _SOFT)
    belief = watched.belief
    if belief is None:
        pen.text(left, 62, "no observation yet", _SOFT, size=1.2)
    else:
        phase = belief.phase
        pen.text(left, 62, f"{phase.name}  {phase.title}", _bgr(phase), size=1.2)
    y = 84.0
    for phase in Phase:
        share = float(belief.probabilities[phase.index]) if belief else 0.0
        pen.text(left, y + 17, phase.name, _bgr(phase))
        pen.box(bar_left, y + 3, bar_right - bar_left, 17, _EMPTY)
        pen.box(bar_left, y + 3, share * (bar_right - bar_left), 17, _bgr(phase))
        pen.text(right, y + 17, f"{share:.2f}", right=True)
        y += 30
    y += 18
    values = watched.observation.values.tolist() if watched.observation else [math.nan] * 7
    for feature, value in zip(FEATURES, values, strict=True):
        end = _ENDS.get(feature, 1.0)
        start = -1.0 if feature == "speed" else 0.0
        pen.text(left, y + 17, feature)
        pen.box(bar_left, y + 3, bar_right - bar_left, 17, _EMPTY)
        if math.isnan(value):
            pen.text(right, y + 17, "unknown", _SOFT, right=True)
        else:
            zero = bar_left - start / (end - start) * (bar_right - bar_left)
            shown = min(max(value, start), end) / (end - start) * (bar_right - bar_left)
            pen.box(zero, y + 3, shown, 17, _BAR)
            unit = UNITS[feature] if UNITS[feature] in ("m", "m/s") else ""
            pen.text(right, y + 17, f"{value:.2f} {unit}".strip(), right=True)
        if feature == "gaze":  # the rim of the cone of visual attention
            pen.box((bar_left + bar_right) / 2 - 1, y, 2, 23, _INK)
        y += 34


def _bgr(phase: Phase) -> _Color:
    red, green, blue = (int(phase.color[i : i + 2], 16) for i in (1, 3, 5))
    return (blue, green, red)
