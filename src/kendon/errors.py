"""Everything kendon raises on purpose.

    KendonError
    ├── DataError          a file or stream holds something that cannot be right
    ├── ParameterError     a value given by the user is out of its range
    ├── UnknownNameError   a name that does not exist; the message lists those that do
    ├── MissingExtraError  an optional dependency is not installed
    ├── ModelFileError     a neural network's file is missing, torn or not the expected one
    ├── RendererError      nothing is installed that pictures can be drawn with
    ├── TreeError          a behaviour tree cannot be read or does not make sense
    └── RobotError         a robot refused a command or stopped answering

Each message is one sentence that names the place, the value, and what would be valid;
the command line prints it and exits with 2.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path


class KendonError(Exception):
    """The root of every error kendon raises on purpose."""


class DataError(KendonError):
    """A file holds something that cannot be right; the message names file, row and column."""

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        row: int | None = None,
        column: str | None = None,
    ) -> None:
        self.file = None if file is None else str(file)
        self.row = row
        self.column = column
        place = [] if file is None else [str(file)]
        if row is not None:
            place.append(f"row {row}")
        if column is not None:
            place.append(f"column {column!r}")
        super().__init__(f"{', '.join(place)}: {message}" if place else message)


class ParameterError(KendonError, ValueError):
    """A value given by the user is out of its range."""


class UnknownNameError(KendonError, LookupError):
    """A name that does not exist.

    Args:
        kind: what was looked up, in the singular ("model", "phase", "tree node").
        name: the name that was asked for.
        valid: the names that exist.
    """

    def __init__(self, kind: str, name: object, valid: Iterable[object]) -> None:
        self.kind = kind
        self.name = name
        self.valid = tuple(str(v) for v in valid)
        near = difflib.get_close_matches(str(name), self.valid, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        choices = ", ".join(self.valid) or "none"
        super().__init__(f"there is no {kind} {str(name)!r}; valid: {choices}{hint}")


class MissingExtraError(KendonError, ImportError):
    """An optional dependency is not installed."""

    def __init__(self, what: str, extra: str, package: str) -> None:
        self.extra = extra
        super().__init__(
            f"{what} needs the Python package {package!r}, which is not installed;"
            f" install it with: pip install 'kendon[{extra}]'"
        )


class ModelFileError(KendonError):
    """A neural network's file is missing, torn or not the expected one."""


class RendererError(KendonError):
    """Nothing is installed that pictures can be drawn with."""


class TreeError(KendonError):
    """A behaviour tree cannot be read or does not make sense."""


class RobotError(KendonError):
    """A robot refused a command or stopped answering."""
