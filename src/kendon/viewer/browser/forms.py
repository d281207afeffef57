"""Bodies as balls and rods: what a page draws, whoever's body it is.

A ball is a sphere of radius 1, a rod a cylinder of radius 1 and length 1 along z; each piece of a
body is one of the two, moved, turned and stretched. A capsule is a rod with a ball at each end.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kendon.person import FloatArray

Float32Array = NDArray[np.float32]
Color = tuple[int, int, int]

#: Columns of a piece: position x y z [m], quaternion w x y z, half-sizes or radii x y z [m].
COLUMNS = 10


@dataclass
class Pieces:
    """The balls and rods of one body at one instant, in the world."""

    balls: list[Sequence[float]] = field(default_factory=list)  # rows of COLUMNS numbers
    rods: list[Sequence[float]] = field(default_factory=list)
    ball_colors: list[Color] = field(default_factory=list)
    rod_colors: list[Color] = field(default_factory=list)

    def ball(
        self,
        place: Iterable[float],
        radii: Iterable[float],
        color: Color,
        turn: Iterable[float] = (1.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Add an ellipsoid."""
        self.balls.append((*place, *turn, *radii))
        self.ball_colors.append(color)

    def rod(
        self,
        place: Iterable[float],
        turn: Iterable[float],
        radius: float,
        length: float,
        color: Color,
    ) -> None:
        """Add a cylinder about its own z axis."""
        self.rods.append((*place, *turn, radius, radius, length))
        self.rod_colors.append(color)

    def capsule(self, start: FloatArray, end: FloatArray, radius: float, color: Color) -> None:
        """Add a capsule between two points; a ball where they are the same."""
        way = end - start
        length = float(np.sqrt(way @ way))
        self.ball(start, (radius,) * 3, color)
        if length > 1e-6:
            self.ball(end, (radius,) * 3, color)
            self.rod((start + end) / 2, _upright_to(way / length), radius, length, color)

    def arrays(self) -> tuple[Float32Array, Float32Array]:
        """The balls and the rods, (N, COLUMNS) each."""
        return _rows(self.balls), _rows(self.rods)


def _rows(rows: list[Sequence[float]]) -> Float32Array:
    return np.array(rows, dtype=np.float32).reshape(-1, COLUMNS)


def _upright_to(axis: FloatArray) -> tuple[float, float, float, float]:
    """The shortest turn, w x y z, that brings z onto a unit vector."""
    x, y, z = axis.tolist()
    if z < -1 + 1e-9:  # straight down: half a turn about x
        return (0.0, 1.0, 0.0, 0.0)
    w = 1 + z
    norm = float(np.sqrt(w * w + x * x + y * y))
    return (w / norm, -y / norm, x / norm, 0.0)


def rgb(color: Sequence[float]) -> Color:
    """A colour given as shares of 1, as 0 to 255."""
    r, g, b = (round(255 * min(1.0, max(0.0, c))) for c in color[:3])
    return (r, g, b)


def hex_rgb(color: str) -> Color:
    """A colour given as ``#rrggbb``.

    >>> hex_rgb("#009E73")
    (0, 158, 115)
    """
    return (int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16))
