"""The contract of a source, and the register in which sources are found by what they read."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.geometry import Vec3
from kendon.person import PersonFrame, Track
from kendon.robots.base import Robot
from kendon.tables import is_observations, peek_header, read_table


@dataclass(frozen=True)
class CameraMount:
    """Where the camera sits on the robot: its optical centre and tilt in ``base_footprint``."""

    position: Vec3 = (0.0, 0.0, 1.2)  # [m]
    yaw: float = 0.0  # [rad], positive to the left
    pitch: float = 0.0  # [rad], positive looks down (REP-103)

    def __post_init__(self) -> None:
        if not all(math.isfinite(v) for v in (*self.position, self.yaw, self.pitch)):
            raise ParameterError(f"a camera mount needs finite numbers, not {self}")


@dataclass(frozen=True)
class SourceOptions:
    """What a user may say about how a source is to be read."""

    camera: CameraMount = CameraMount()
    fov: float | None = None  # horizontal field of view of the camera [rad]; None = 60 degrees
    fps: float | None = None  # frames a second, where a file's own stamps are missing or no clock
    model_files: Path | None = None  # a folder that holds the neural networks' files
    calibration: Path | None = None  # of the camera; see `kendon.sources.calibration`
    pose_model: Path | None = None  # the pose landmarker's file: with it there are joints
    person: int | None = None  # whom to follow, from 1 in order of coming; None = who greets

    def __post_init__(self) -> None:
        if self.calibration is not None and self.fov is not None:
            raise ParameterError(
                "a calibration tells the field of view; give one of the two, not both"
            )
        if self.person is not None and self.person < 1:
            raise ParameterError(f"people are numbered from 1, there is no person {self.person}")
        if self.fps is not None and not 1 <= self.fps <= 1000:
            raise ParameterError(f"frames a second lie between 1 and 1000, not {self.fps:g}")


class Source(ABC):
    """One person seen over time: an iterable of frames in the order of their stamps.

    A source that sees nobody yields a frame with unknown head, so that time goes on.
    """

    #: The name the source is registered under.
    name: ClassVar[str] = "unregistered"
    #: One line for `kendon sources`: what it reads.
    reads: ClassVar[str] = ""
    #: How it is named on the command line.
    example: ClassVar[str] = ""
    #: Whether frames arrive as they happen (a device) rather than as fast as they are read.
    live: ClassVar[bool] = False

    #: Whether the person reacts to the robot; the person of a recording cannot.
    reacts: ClassVar[bool] = False
    #: What a user should know about how this file was read, one sentence each.
    notes: tuple[str, ...] = ()

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """Whether this source reads `spec` (a path, or a word such as ``camera:0``)."""
        del spec
        return False

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> Source:
        """Open it. A source that is only made in Python, of people in memory, need not.

        Raises:
            DataError: there is something wrong with what it reads.
            MissingExtraError: it needs an extra that is not installed.
        """
        del options
        raise DataError(f"{cls.__name__} is made in Python, not opened by a name", file=spec)

    @classmethod
    def recordings(cls, spec: str) -> list[str]:
        """The people that `spec` stands for, each by a name to open them by.

        Itself, unless a file holds several people of whom each is read for themselves.

        Raises:
            DataError: there is something wrong with what it reads.
            MissingExtraError: it needs an extra that is not installed.
        """
        return [spec]

    @abstractmethod
    def frames(self) -> Iterator[PersonFrame]:
        """The person, frame by frame, with growing stamps [s]."""

    def record(self, progress: Callable[[PersonFrame], None] | None = None) -> Track:
        """Everything the source gives, as a track; a live source must be stopped from outside.

        Args:
            progress: called after each frame.

        Raises:
            DataError: there is something wrong with what it reads.
        """

        def watched() -> Iterator[PersonFrame]:
            for frame in self.frames():
                yield frame
                if progress:
                    progress(frame)

        return Track.from_frames(watched(), self.name)

    def attach(self, robot: Robot) -> None:
        """Tell the source which robot it is in the presence of; called once before `frames`.

        Only a simulated person, who can react, makes use of it.
        """
        del robot


_REGISTER: dict[str, type[Source]] = {}


def register(source: type[Source]) -> type[Source]:
    """Class decorator: make a source known by its name."""
    _REGISTER[source.name] = source
    return source


def registered_sources() -> dict[str, type[Source]]:
    """All sources by name, in the order in which they are asked whether they recognise a file."""
    return dict(_REGISTER)


def find_source(spec: str | Path, *, name: str | None = None) -> type[Source]:
    """The source that recognises a file or device, or the named one; opens nothing.

    Raises:
        UnknownNameError: no source has that name.
        DataError: the file is missing, or no source recognises it.
    """
    if name is not None:
        if name not in _REGISTER:
            raise UnknownNameError("source", name, _REGISTER)
        return _REGISTER[name]
    for source in _REGISTER.values():
        if source.recognises(str(spec)):
            return source
    path = Path(spec)
    if not path.exists():
        raise DataError(
            f"there is no such file, and no source goes by that name; valid names:"
            f" {', '.join(_REGISTER)}",
            file=path,
        )
    if path.is_dir():
        raise DataError("this is a folder; name the files in it, for example DIR/*.csv", file=path)
    if is_observations(path):
        raise DataError(
            "these are observations, not a person; they are for estimate, evaluate and fit",
            file=path,
        )
    raise DataError(
        f"no source recognises this file{_reason(path)}; there are {', '.join(_REGISTER)}, and"
        " `kendon sources` tells what each of them reads",
        file=path,
    )


def _reason(path: Path) -> str:
    """What can be told of a file that no source recognises, to stand after a colon."""
    if path.is_file() and not path.stat().st_size:
        return ": it is empty"
    if path.suffix.lower() != ".csv":
        return ""
    header = peek_header(path)
    if len(header) == 1 and ";" in header[0]:
        return ": its cells are separated by semicolons, where kendon reads commas"
    try:
        columns = read_table(path).columns
    except DataError as error:  # torn, or not in UTF-8
        return f": {str(error).removeprefix(str(path)).lstrip(':, ')}"
    return f": its columns are {', '.join(name[:20] for name in columns[:8])}"


def recordings(spec: str | Path) -> list[str]:
    """Everybody whom a file or device stands for (`Source.recordings`); nobody if none reads it.

    Raises:
        DataError: there is something wrong with what its source reads.
        MissingExtraError: its source needs an extra that is not installed.
    """
    for source in _REGISTER.values():
        if source.recognises(str(spec)):
            return source.recordings(str(spec))
    return []


def open_source(
    spec: str | Path, options: SourceOptions | None = None, *, name: str | None = None
) -> Source:
    """Open a file or device with the source that recognises it, or with the named one.

    Raises:
        UnknownNameError: no source has that name.
        DataError: the file is missing, wrong, or no source recognises it.
    """
    return find_source(spec, name=name).open(str(spec), options or SourceOptions())
