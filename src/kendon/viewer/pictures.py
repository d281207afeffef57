"""Pictures and films of an encounter: the stage, a close-up of the robot's face, and captions."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imsave

from kendon.errors import DataError, MissingExtraError
from kendon.greeter import Encounter
from kendon.outputs import whole_file
from kendon.phases import Phase
from kendon.robots.mujoco import MujocoRobot
from kendon.sources.quiet import quiet_stderr
from kendon.viewer.mannequin import shapes
from kendon.viewer.scenes import Instant, Scenes
from kendon.viewer.stage import Image, Stage

#: A film's images a second and size [pixels]; a software renderer takes about half a second for
#: each, on one core.
FILM_RATE, FILM_SIZE = 15.0, (960, 540)
#: The codec of each kind of film that OpenCV can write everywhere. Browsers play .webm.
FILMS = {".mp4": "mp4v", ".webm": "VP80"}
#: The size of one image of the sheet of highlights [pixels], and how many stand in a row.
_SHEET_SIZE, _COLUMNS = (800, 450), 2
_INK, _PAPER = "#222222", "#ffffff"
_MARGIN = 0.03  # of the height


class Painter:
    """Makes whole images of instants.

    Args:
        robot: whom they are of.
        size: width and height [pixels].
    """

    def __init__(self, robot: MujocoRobot, size: tuple[int, int]) -> None:
        self._size = size
        self._stage = Stage(robot.description, *size)
        self._inset = int(size[1] * 0.34)

    def paint(self, instant: Instant) -> Image:
        """One image, (height, width, 3)."""
        stage = self._stage
        stage.pose(instant.positions)
        person = shapes(instant.stance) if instant.stance is not None else []
        view, close = instant.view, instant.close_up
        image = stage.draw(
            view.look_at, view.distance, view.azimuth, view.elevation, person, instant.robot
        ).copy()
        side = self._inset
        face = stage.draw(
            close.look_at, close.distance, close.azimuth, close.elevation, size=(side, side)
        )
        margin = round(_MARGIN * self._size[1])
        corner = image[margin : margin + side, -margin - side : -margin]
        shape, rim = _disc(side)
        corner[:] = np.where(shape, face, np.where(rim, 255, corner))
        height = self._size[1]
        if instant.phase is not None:
            title = _pill(instant.phase, height)
            _paste(image, title, margin, margin)
        if instant.doing:
            words = _text(f"The robot: {instant.doing}", height, 0.028, _INK, None)
            _paste(image, words, margin, margin + round(0.085 * height))
        if instant.saying:
            words = _text(instant.saying, height, 0.042, _INK, _PAPER)
            left = (self._size[0] - words.shape[1]) // 2
            _paste(image, words, left, height - margin - words.shape[0])
        return image

    def close(self) -> None:
        """Give the graphics memory back."""
        self._stage.close()


def write_film(
    encounter: Encounter,
    robot: MujocoRobot,
    path: Path,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Film an encounter.

    Args:
        encounter: what happened.
        robot: whose `history` was kept meanwhile.
        path: a file of one of the kinds in `FILMS`.
        progress: called after each image with how many are done, and how many there are.

    Raises:
        MissingExtraError: OpenCV is not installed.
        DataError: the file cannot be written.
        RendererError: nothing is installed to draw with.
    """
    cv2 = require_film(path)
    instants = Scenes(encounter, robot).film(FILM_RATE)
    code = cv2.VideoWriter_fourcc(*FILMS[path.suffix.lower()])
    with whole_file(path) as part, closing(Painter(robot, FILM_SIZE)) as painter:
        with quiet_stderr():
            film = cv2.VideoWriter(str(part), code, FILM_RATE, FILM_SIZE)
        try:
            if not film.isOpened():
                raise DataError("no film can be written here", file=path)
            for done, instant in enumerate(instants, 1):
                film.write(painter.paint(instant)[:, :, ::-1])
                if progress:
                    progress(done, len(instants))
        finally:
            film.release()


def require_film(path: Path) -> Any:
    """OpenCV, which writes films; asked for before an encounter rather than after it.

    Raises:
        MissingExtraError: it is not installed.
        DataError: the file's kind is none of those that it writes.
    """
    if path.suffix.lower() not in FILMS:
        raise DataError(f"a film is a {' or '.join(FILMS)} file", file=path)
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("a film", "camera", "opencv-contrib-python") from None
    return cv2


def write_picture(encounter: Encounter, robot: MujocoRobot, path: Path) -> None:
    """One sheet with an image of each phase, at its most telling moment.

    Args:
        encounter: what happened.
        robot: whose `history` was kept meanwhile.
        path: a .png file.

    Raises:
        DataError: the file cannot be written.
        RendererError: nothing is installed to draw with.
    """
    instants = Scenes(encounter, robot).highlights()
    painter = Painter(robot, _SHEET_SIZE)
    try:
        images = [painter.paint(instant) for instant in instants]
    finally:
        painter.close()
    gap = 8
    width, height = _SHEET_SIZE
    rows = -(-len(images) // _COLUMNS)
    sheet: Image = np.full(
        (rows * (height + gap) - gap, _COLUMNS * (width + gap) - gap, 3), 255, dtype=np.uint8
    )
    for i, image in enumerate(images):
        top, left = (i // _COLUMNS) * (height + gap), (i % _COLUMNS) * (width + gap)
        sheet[top : top + height, left : left + width] = image
    with whole_file(path) as part:
        imsave(part, sheet)


# ---- captions


def _pill(phase: Phase, height: int) -> Image:
    return _text(f"The person: {phase.title}", height, 0.036, "white", phase.color)


@cache
def _text(text: str, height: int, share: float, color: str, ground: str | None) -> Image:
    """A line of text on a rounded ground, (h, w, 4) RGBA.

    Args:
        text: the line.
        height: of the image it is for [pixels].
        share: the letters' size as a share of that.
        color: the letters'.
        ground: the colour behind them; None for none.
    """
    figure = Figure(figsize=(12, 1), dpi=100)
    canvas: Any = FigureCanvasAgg(figure)
    figure.patch.set_alpha(0)
    box = None if ground is None else {
        "boxstyle": "round,pad=0.45,rounding_size=0.6", "fc": ground, "ec": "none",
    }  # fmt: skip
    figure.text(
        0.5, 0.5, text, ha="center", va="center", color=color, fontsize=share * height * 0.72,
        fontweight="bold" if ground is not None else "normal", bbox=box,
    )  # fmt: skip
    canvas.draw()
    drawn: Image = np.asarray(canvas.buffer_rgba()).copy()
    inked = np.argwhere(drawn[:, :, 3] > 0)
    (top, left), (bottom, right) = inked.min(axis=0), inked.max(axis=0)
    return drawn[top : bottom + 1, left : right + 1]


def _paste(image: Image, sprite: Image, left: int, top: int) -> None:
    """Lay an RGBA sprite over an image, cut at its edges."""
    height = min(sprite.shape[0], image.shape[0] - top)
    width = min(sprite.shape[1], image.shape[1] - left)
    part = sprite[:height, :width]
    below = image[top : top + height, left : left + width]
    cover = part[:, :, 3:] / 255
    below[:] = (part[:, :, :3] * cover + below * (1 - cover)).astype(np.uint8)


@cache
def _disc(side: int) -> tuple[Any, Any]:
    """Where a round inset and its rim are, two masks (side, side, 1)."""
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    away = np.hypot(x, y)[:, :, None]
    return away < side / 2 - max(2, side // 60), away < side / 2
