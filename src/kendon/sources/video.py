"""A person before a camera: live (`camera`), or in a video file (`video`)."""

from __future__ import annotations

import itertools
import math
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, ClassVar

from kendon.errors import DataError
from kendon.person import PersonFrame
from kendon.sources.base import Source, SourceOptions, register
from kendon.sources.camera_geometry import DEFAULT_FOV, Intrinsics, MountedCamera, check_fov
from kendon.sources.face_geometry import import_cv2
from kendon.sources.face_landmarks import (
    FaceDetector,
    FaceLandmarker,
    import_mediapipe,
    quiet_stderr,
)
from kendon.sources.face_person import PersonReader
from kendon.sources.model_files import FACE_LANDMARKER, find_model_file

#: File name endings of the videos that are read.
SUFFIXES = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v")

#: A file whose last frame comes before this share of its announced length is torn. Less is
#: normal: containers announce a length that is rounded or that of a longer sound track.
_COMPLETE = 0.9
#: Frame rates that a container can mean seriously [1/s].
_RATES = (0.5, 500.0)

#: Makes a detector; called when the first frame is wanted.
DetectorMaker = Callable[[], FaceDetector]


@register
class VideoSource(Source):
    """The person in a video file, one frame each of the video's own frames."""

    name: ClassVar[str] = "video"
    reads: ClassVar[str] = f"a face in a video file ({' '.join(SUFFIXES)})"
    example: ClassVar[str] = "greeting.mp4"

    def __init__(self, path: Path, options: SourceOptions, make_detector: DetectorMaker) -> None:
        self._path = path
        self._options = options
        self.notes = _notes(options)
        self._make_detector = make_detector

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """Whether `spec` ends like a video file."""
        return Path(spec).suffix.lower() in SUFFIXES

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> VideoSource:
        """Open a video file.

        Raises:
            DataError: it is missing or no video.
            ParameterError: the camera's field of view is not one of a camera.
            MissingExtraError: the ``camera`` extra is not installed.
            ModelFileError: the face landmarker's file cannot be had.
        """
        path = Path(spec)
        if not path.is_file():
            what = "this is a folder, not a video" if path.is_dir() else "there is no such video"
            raise DataError(what, file=path)
        check_fov(options.fov)
        capture = _open_file(path)
        capture.release()
        return cls(path, options, _detector_maker(options))

    def frames(self) -> Iterator[PersonFrame]:
        """The person, frame by frame, stamped with the file's own frame times [s].

        Where the file's times do not grow, frames are as far apart as its frame rate says; where
        it has none either, as `SourceOptions.fps` says.

        Raises:
            DataError: the video holds no frame, breaks off, or tells no frame times.
        """
        capture = _open_file(self._path)
        try:
            yield from _people(self._images(capture), self._options, self._make_detector)
        finally:
            capture.release()

    def _images(self, capture: Any) -> Iterator[tuple[float, Any]]:
        """Stamps [s] and BGR images (height, width, 3)."""
        cv2 = import_cv2("reading videos")
        rate = float(capture.get(cv2.CAP_PROP_FPS))
        if not _RATES[0] <= rate <= _RATES[1]:
            rate = self._options.fps or math.nan
        period = 1.0 / rate
        t = -math.inf
        for count in itertools.count():
            good, image = capture.read()
            if not good:
                self._check_complete(count, t, period, capture.get(cv2.CAP_PROP_FRAME_COUNT))
                return
            stamp = float(capture.get(cv2.CAP_PROP_POS_MSEC)) / 1000.0
            if math.isfinite(stamp) and stamp > t:
                t = stamp
            elif math.isfinite(period):
                t = 0.0 if count == 0 else t + period
            else:
                raise DataError(
                    "the video tells neither frame times nor a frame rate;"
                    " say how many frames a second it has with --fps",
                    file=self._path,
                    row=count,
                )
            yield t, image

    def _check_complete(self, count: int, t: float, period: float, announced: float) -> None:
        if count == 0:
            raise DataError("no frame of this video can be read", file=self._path)
        length = announced * period  # NaN or nonsense where the container does not know
        if 0 < announced < 1e9 and t + period < _COMPLETE * length:
            raise DataError(
                f"the video breaks off after {t + period:.1f} of {length:.1f} s;"
                " the file is damaged or was not copied completely",
                file=self._path,
            )


@register
class CameraSource(Source):
    """The person before a camera, live."""

    name: ClassVar[str] = "camera"
    reads: ClassVar[str] = "a face before a camera, live; the number picks the camera"
    example: ClassVar[str] = "camera:0"
    live: ClassVar[bool] = True

    def __init__(
        self, index: int, options: SourceOptions, make_detector: DetectorMaker, capture: Any
    ) -> None:
        self._index = index
        self._options = options
        self.notes = _notes(options)
        self._make_detector = make_detector
        self._capture: Any | None = capture

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """Whether `spec` is ``camera`` or starts with ``camera:``."""
        return spec == "camera" or spec.startswith("camera:")

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> CameraSource:
        """Open a camera by its number; ``camera`` alone is ``camera:0``.

        Raises:
            DataError: the number is none, or that camera does not open.
            ParameterError: the camera's field of view is not one of a camera.
            MissingExtraError: the ``camera`` extra is not installed.
            ModelFileError: the face landmarker's file cannot be had.
        """
        match = re.fullmatch(r"camera(?::(\d{1,3}))?", spec)
        if match is None:
            raise DataError(f"{spec!r} names no camera; write camera, camera:0, camera:1, ...")
        check_fov(options.fov)
        make_detector = _detector_maker(options)
        index = int(match[1] or 0)
        return cls(index, options, make_detector, _open_camera(index))

    def frames(self) -> Iterator[PersonFrame]:
        """The person, frame by frame, stamped from the first frame's arrival on [s].

        Raises:
            DataError: the camera stops giving frames.
        """
        capture = self._capture or _open_camera(self._index)
        self._capture = None
        try:
            yield from _people(self._images(capture), self._options, self._make_detector)
        finally:
            capture.release()

    def close(self) -> None:
        """Let go of a camera that was opened but is not going to be read."""
        if self._capture is not None:
            self._capture.release()
            self._capture = None

    def _images(self, capture: Any) -> Iterator[tuple[float, Any]]:
        """Stamps [s] and BGR images (height, width, 3); ends only by an error."""
        start = last = -math.inf
        for count in itertools.count():
            good, image = capture.read()
            if not good:
                raise DataError(
                    f"camera {self._index} stopped giving frames after {count};"
                    " check its cable and whether another program took it over"
                )
            now = time.monotonic()
            if count == 0:
                start = now
            # A clock of coarse steps may tell two frames the same time; stamps must grow.
            last = max(now - start, last + 1e-6)
            yield last, image


def _notes(options: SourceOptions) -> tuple[str, ...]:
    if options.fov is not None:
        return ()
    return (
        f"The camera's horizontal field of view is taken to be {math.degrees(DEFAULT_FOV):.0f}"
        " degrees; with another one all distances are off by one factor.",
    )


def _people(
    images: Iterator[tuple[float, Any]], options: SourceOptions, make_detector: DetectorMaker
) -> Iterator[PersonFrame]:
    """One `PersonFrame` an image; the detector lives as long as this generator."""
    cv2 = import_cv2("reading videos")
    mounted = MountedCamera.from_mount(options.camera)
    reader: PersonReader | None = None
    with closing(make_detector()) as detector:
        for t, image in images:
            if reader is None:
                height, width = image.shape[:2]
                reader = PersonReader(Intrinsics.from_fov(width, height, options.fov), mounted)
            rgb = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
            yield reader.read(detector.detect(rgb, t), t)


def _detector_maker(options: SourceOptions) -> DetectorMaker:
    """What makes the detector later; what can be missing for it is found missing now."""
    import_cv2("reading videos")
    import_mediapipe()
    model = find_model_file(FACE_LANDMARKER.name, options.model_files)
    return lambda: FaceLandmarker(model)


def _open_file(path: Path) -> Any:
    """An open `cv2.VideoCapture` of a file.

    Raises:
        DataError: it is no video that OpenCV can read.
    """
    cv2 = import_cv2("reading videos")
    # -8 is FFmpeg's "quiet"; read once, at the first capture. What fails is told by DataError.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    with quiet_stderr():
        capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        capture.release()
        raise DataError(
            "this is no video that OpenCV can read; it is damaged, was not copied completely,"
            " or is in a format other than H.264, MPEG-4, MJPEG, VP8, VP9",
            file=path,
        )
    return capture


def _open_camera(index: int) -> Any:
    """An open `cv2.VideoCapture` of a camera.

    Raises:
        DataError: it does not open.
    """
    cv2 = import_cv2("reading a camera")
    with quiet_stderr():
        capture = cv2.VideoCapture(index)
    if not capture.isOpened():
        capture.release()
        raise DataError(
            f"camera {index} does not open; check that it is plugged in, that no other program"
            f" uses it, that you may read it (on Linux: /dev/video{index}, group video), and"
            " that its number is right (camera:0 is the first)"
        )
    # An old frame is of no use to a robot: keep no more than one waiting.
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    return capture
