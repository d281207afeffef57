"""Text files of plain rows of numbers, read with errors that name the file and the row.

Datasets of skeletons come without a header; rows are counted from 1, as editors show them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from kendon.errors import DataError
from kendon.person import FloatArray
from kendon.tables import check_readable
from kendon.tracks import MAX_COORDINATE

#: At most so much of a stranger's text is repeated in a message.
_QUOTED = 40


def text_lines(path: Path) -> list[tuple[int, str]]:
    """The lines of a text file that are not blank, with their row numbers (the first is 1).

    Raises:
        DataError: the file is missing, a folder, no text, or empty.
    """
    check_readable(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise DataError("this is no text file", file=path) from None
    except OSError as error:
        raise DataError(f"cannot be read ({error.strerror})", file=path) from None
    rows = [(i + 1, line) for i, line in enumerate(text.splitlines()) if line.strip()]
    if not rows:
        raise DataError("the file is empty", file=path)
    return rows


def numbers(words: Sequence[str], width: int, path: Path, row: int) -> list[float]:
    """One row's words as numbers; ``nan`` is unknown.

    Raises:
        DataError: there are not `width` of them, or one is no finite number.
    """
    if len(words) != width:
        raise DataError(
            f"torn row: {len(words)} numbers where there should be {width}", file=path, row=row
        )
    try:
        values = [float(word) for word in words]
    except ValueError:
        for place, word in enumerate(words):
            try:
                float(word)
            except ValueError:
                raise DataError(
                    f"{word[:_QUOTED]!r}, number {place + 1} of the row, is not a number",
                    file=path,
                    row=row,
                ) from None
        raise
    if any(abs(value) == np.inf for value in values):
        place = [abs(value) for value in values].index(np.inf)
        raise DataError(f"number {place + 1} of the row is infinite", file=path, row=row)
    return values


def check_metres(points: FloatArray, path: Path, rows: Sequence[int]) -> None:
    """Refuse coordinates that cannot be metres.

    Args:
        points: shape (T, ...) [m].
        path: of the file, for the message.
        rows: the row of the file in which each of the T entries stands.

    Raises:
        DataError: a coordinate is larger than `kendon.tracks.MAX_COORDINATE`.
    """
    flat = np.abs(points.reshape(len(points), -1))
    wrong = (flat > MAX_COORDINATE).any(axis=1)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise DataError(
            f"a coordinate of {np.nanmax(flat[at]):g} is not within {MAX_COORDINATE:g} m;"
            " kendon reads metres: are these millimetres?",
            file=path,
            row=rows[at],
        )
