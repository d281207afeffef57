"""A person in a video file."""

from __future__ import annotations

import itertools
import math
import os
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any, ClassVar

from kendon.errors import DataError
from kendon.sources.base import SourceOptions, register
from kendon.sources.camera_geometry import check_fov, import_cv2
from kendon.sources.pictures import DetectorMaker, Picture, PictureSource, detector_maker
from kendon.sources.quiet import quiet_stderr

#: File name endings of the videos that are read.
SUFFIXES = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v")

#: A file whose last frame comes before this share of its announced length is torn. Less is
#: normal: containers announce a length that is rounded or that of a longer sound track.
_COMPLETE = 0.9
#: Frame rates that a container can mean seriously [1/s].
_RATES = (0.5, 500.0)


@register
class VideoSource(PictureSource):
    """The person in a video file, one frame each of the video's own frames."""

    name: ClassVar[str] = "video"
    reads: ClassVar[str] = f"faces in a video file ({' '.join(SUFFIXES)})"
    example: ClassVar[str] = "greeting.mp4"

    def __init__(self, path: Path, options: SourceOptions, make_detectors: DetectorMaker) -> None:
        super().__init__(options, make_detectors)
        self._path = path

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """Whether `spec` ends like a video file."""
        return Path(spec).suffix.lower() in SUFFIXES

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> VideoSource:
        """Open a video file.

        Raises:
            DataError: it is missing or no video, or the calibration cannot be read.
            ParameterError: the camera's field of view is not one of a camera.
            MissingExtraError: the ``camera`` extra is not installed.
            ModelFileError: a network's file cannot be had.
        """
        path = Path(spec)
        if not path.is_file():
            what = "this is a folder, not a video" if path.is_dir() else "there is no such video"
            raise DataError(what, file=path)
        check_fov(options.fov)
        capture = _open_file(path)
        rate = _rate(capture, options)
        capture.release()
        source = cls(path, options, detector_maker(options))
        source.rate = rate
        return source

    def pictures(self) -> Generator[Picture, None, None]:
        """The frames of the file, stamped with the file's own times [s].

        Where the file's times do not grow, frames are as far apart as its frame rate says; where
        it has none either, as `SourceOptions.fps` says.

        Raises:
            DataError: the video holds no frame, breaks off, or tells no frame times.
        """
        capture = _open_file(self._path)
        try:
            yield from self._read(capture)
        finally:
            capture.release()

    def _read(self, capture: Any) -> Generator[Picture, None, None]:
        cv2 = import_cv2("reading videos")
        period = 1.0 / _rate(capture, self._options)
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
            yield Picture(t, image, time.monotonic())

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


def _rate(capture: Any, options: SourceOptions) -> float:
    """Frames a second, by the file or else by the user; NaN where neither tells."""
    cv2 = import_cv2("reading videos")
    rate = float(capture.get(cv2.CAP_PROP_FPS))
    return rate if _RATES[0] <= rate <= _RATES[1] else options.fps or math.nan


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
