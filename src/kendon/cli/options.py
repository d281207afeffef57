"""Options that several commands share, and how their texts become values."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from kendon.errors import ParameterError
from kendon.geometry import Vec3
from kendon.sources import CameraMount, SourceOptions
from kendon.sources.camera_geometry import MAX_FOV, MIN_FOV

# No markup: a file's name or a model's title may hold brackets.
out = Console(markup=False)
err = Console(stderr=True, markup=False)

#: No robot carries its face farther from its base [m].
_FARTHEST_FACE = 10.0
#: No camera stands farther from the robot's base than what it is to see [m].
_FARTHEST_CAMERA = 100.0

_READING = "How a source is read"

ModelOption = Annotated[
    str, typer.Option("--model", help="A model's name (see `kendon models`) or file.")
]
RobotFaceOption = Annotated[
    str, typer.Option(metavar="X,Y,Z", help="The robot's face in its base frame [m].")
]
GesturesOption = Annotated[
    bool,
    typer.Option(
        "--gestures-from-phases",
        help="Give the gesture probabilities by hand, from the true phases in the file, as the"
        " thesis's keys did.",
    ),
]
SourceOption = Annotated[
    str | None,
    typer.Option(
        "--source", help="The source's name, if the file is not to be recognised.",
        rich_help_panel=_READING,
    ),
]  # fmt: skip
CameraPoseOption = Annotated[
    str,
    typer.Option(
        metavar="X,Y,Z[,YAW,PITCH]",
        help="Where the camera sits in the robot's base frame [m, degrees; pitch down].",
        rich_help_panel=_READING,
    ),
]
FovOption = Annotated[
    float | None,
    typer.Option(
        "--fov", help="The camera's horizontal field of view [degrees]; 60 if not given.",
        rich_help_panel=_READING,
    ),
]  # fmt: skip
FpsOption = Annotated[
    float | None,
    typer.Option(
        "--fps", help="Frames a second, for files that do not tell.", rich_help_panel=_READING
    ),
]
ModelFilesOption = Annotated[
    Path | None,
    typer.Option(
        "--model-files",
        help="A folder with the neural networks' files (see `kendon doctor`).",
        rich_help_panel=_READING,
    ),
]
CalibrationOption = Annotated[
    Path | None,
    typer.Option(
        help="The camera's calibration instead of --fov: OpenCV's YAML or XML, or ROS's camera"
        " YAML.",
        rich_help_panel=_READING,
    ),
]
PoseModelOption = Annotated[
    Path | None,
    typer.Option(
        help="MediaPipe's pose_landmarker_*.task: reads shoulders, elbows, wrists and hips, too.",
        rich_help_panel=_READING,
    ),
]
PersonOption = Annotated[
    int | None,
    typer.Option(
        help="Follow this face of a video or camera alone, counted from 1 in order of coming,"
        " instead of whoever greets.",
        rich_help_panel=_READING,
    ),
]


def note(text: str) -> None:
    """Tell the user something worth knowing, beside the results."""
    err.print(f"note: {text}", style="dim", highlight=False, soft_wrap=True)


def source_options(
    camera_pose: str,
    fov: float | None,
    fps: float | None,
    model_files: Path | None,
    calibration: Path | None = None,
    pose_model: Path | None = None,
    person: int | None = None,
) -> SourceOptions:
    """The texts and numbers of the command line as options of a source.

    Raises:
        ParameterError: one of them is not what it should be.
    """
    if fov is not None and not MIN_FOV <= math.radians(fov) <= MAX_FOV:
        low, high = math.degrees(MIN_FOV), math.degrees(MAX_FOV)
        raise ParameterError(f"--fov lies between {low:.0f} and {high:.0f} degrees, not {fov:g}")
    numbers = _numbers("--camera-pose", camera_pose, (3, 5), "X,Y,Z or X,Y,Z,YAW,PITCH")
    if max(map(abs, numbers[:3])) > _FARTHEST_CAMERA or max(map(abs, numbers[3:]), default=0) > 360:
        raise ParameterError(
            f"--camera-pose lies within {_FARTHEST_CAMERA:g} m of the robot's base and turns by at"
            f" most 360 degrees, not {camera_pose}"
        )
    yaw, pitch = (math.radians(a) for a in numbers[3:]) if len(numbers) == 5 else (0.0, 0.0)
    return SourceOptions(
        camera=CameraMount((numbers[0], numbers[1], numbers[2]), yaw, pitch),
        fov=None if fov is None else math.radians(fov),
        fps=fps,
        model_files=model_files,
        calibration=calibration,
        pose_model=pose_model,
        person=person,
    )


def point(option: str, text: str) -> Vec3:
    """A point given as X,Y,Z [m].

    Raises:
        ParameterError: the text is not three numbers.
    """
    x, y, z = _numbers(option, text, (3,), "X,Y,Z in metres, as in 0,0,1.2")
    if max(abs(x), abs(y), abs(z)) > _FARTHEST_FACE:
        raise ParameterError(
            f"{option} lies within {_FARTHEST_FACE:g} m of the robot's base, not at {text}"
        )
    return (x, y, z)


def check_jobs(jobs: int) -> None:
    """Refuse a number of processes that cannot be.

    Raises:
        ParameterError: it is neither -1 nor at least 1.
    """
    if jobs != -1 and jobs < 1:
        raise ParameterError(f"--jobs must be at least 1, or -1 for one for each core, not {jobs}")


def _numbers(option: str, text: str, lengths: tuple[int, ...], form: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in lengths or not all(math.isfinite(n) for n in numbers):
        raise ParameterError(f"{option} is {form}, not {text!r}")
    return numbers
