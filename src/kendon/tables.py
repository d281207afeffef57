"""CSV files in and out, with errors that name file, row and column.

Rows are counted as editors and spreadsheets show them: the header is row 1.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kendon.errors import DataError
from kendon.outputs import write_text

#: What stands for an unknown value; the last ones are what Windows programs print for NaN.
_UNKNOWN = frozenset({"", "nan", "na", "null", "none", "nan(ind)", "-nan(ind)"})
#: At most so much of a stranger's text is repeated in a message.
_QUOTED = 40


@dataclass(frozen=True)
class Table:
    """A CSV file in memory: text cells by column, every row as long as the header."""

    path: Path
    columns: tuple[str, ...]
    rows: list[list[str]]
    row_numbers: list[int]  # the row of the file each entry of `rows` stood in

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def require(self, *columns: str) -> None:
        """Refuse the file if columns are missing, naming all of them."""
        missing = [c for c in columns if c not in self.columns]
        if missing:
            plural = "s" if len(missing) > 1 else ""
            there = ", ".join(column[:_QUOTED] for column in self.columns[:12])
            raise DataError(
                f"column{plural} {', '.join(missing)} missing; the file has"
                f" {there}{', …' if len(self.columns) > 12 else ''}",
                file=self.path,
                row=1,
            )

    def texts(self, column: str) -> list[str]:
        """The cells of a column, stripped."""
        place = self.columns.index(column)
        return [row[place].strip() for row in self.rows]

    def numbers(
        self, column: str, *, low: float = -math.inf, high: float = math.inf, hint: str = ""
    ) -> NDArray[np.float64]:
        """A column as numbers, NaN where the cell is empty or says so; shape (rows,).

        Args:
            column: its name.
            low: the smallest valid value.
            high: the largest valid value.
            hint: what a value out of range probably means, appended to the message.

        Raises:
            DataError: a cell is not a number, is infinite, or is out of range.
        """
        texts = self.texts(column)
        try:
            values = np.array([math.nan if s.lower() in _UNKNOWN else float(s) for s in texts])
        except ValueError:
            self._refuse_text(column, texts)
            raise  # _refuse_text always finds the culprit
        wrong = np.isinf(values) | (values < low) | (values > high)
        if wrong.any():
            first = int(np.argmax(wrong))
            if math.isinf(values[first]):
                raise self.error(
                    "the value is infinite; leave a cell empty if unknown", first, column
                )
            valid = f"between {low:g} and {high:g}" if high < math.inf else f"at least {low:g}"
            raise self.error(
                f"{values[first]:g} is not {valid}{hint and '; ' + hint}", first, column
            )
        return values

    def error(self, message: str, index: int, column: str | None = None) -> DataError:
        """The error for the entry `index` of `rows`, naming its place in the file."""
        return DataError(message, file=self.path, row=self.row_numbers[index], column=column)

    def _refuse_text(self, column: str, texts: Sequence[str]) -> None:
        for index, text in enumerate(texts):
            try:
                text.lower() in _UNKNOWN or float(text)
            except ValueError:
                raise self.error(f"{text[:_QUOTED]!r} is not a number", index, column) from None


def read_table(path: str | Path) -> Table:
    """Read a CSV file with a header; names are stripped of spaces, blank rows are skipped.

    Raises:
        DataError: the file is missing, a folder, not text, empty, has no rows, a row is torn
            (shorter or longer than the header), or a column name stands twice.
    """
    path = Path(path)
    check_readable(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            header = next(reader, None)
            if header is None:
                raise DataError("the file is empty", file=path)
            columns = tuple(name.strip() for name in header)
            twice = sorted({c for c in columns if c and columns.count(c) > 1})
            if twice:
                raise DataError(
                    f"the column {', '.join(twice)} stands more than once", file=path, row=1
                )
            rows, numbers = [], []
            for row in reader:
                if not row:
                    continue
                if len(row) != len(columns):
                    raise DataError(
                        f"torn row: {len(row)} cells where the header has {len(columns)}",
                        file=path,
                        row=reader.line_num,
                    )
                rows.append(row)
                numbers.append(reader.line_num)
    except UnicodeDecodeError:
        raise DataError("this is no CSV file in UTF-8, or no text at all", file=path) from None
    except csv.Error as error:
        raise DataError(f"not a readable CSV ({error})", file=path) from None
    except OSError as error:
        raise DataError(f"cannot be read ({error.strerror})", file=path) from None
    if not rows:
        raise DataError("the file has a header but no rows", file=path)
    return Table(path, columns, rows, numbers)


def peek_header(path: str | Path) -> tuple[str, ...]:
    """The column names of a CSV file, or nothing if it is not one."""
    try:
        with Path(path).open(newline="", encoding="utf-8-sig") as file:
            header = next(csv.reader([file.readline(1 << 20)]), [])
    except (OSError, UnicodeDecodeError, csv.Error):
        return ()
    return tuple(name.strip() for name in header)


def is_index(path: str | Path) -> bool:
    """Whether a CSV file lists recordings (a column ``file``, none for time) and holds none."""
    columns = peek_header(path) if Path(path).suffix.lower() == ".csv" else ()
    return "file" in columns and "t" not in columns


def is_observations(path: str | Path) -> bool:
    """Whether a CSV file holds observations: a column ``t`` and one of a measured feature."""
    columns = peek_header(path)
    return "t" in columns and any(name in columns for name in ("distance", "speed", "gaze"))


def check_readable(path: Path) -> None:
    """Refuse a missing file or a folder with one sentence.

    Raises:
        DataError: the path is not a file.
    """
    if path.is_dir():
        raise DataError("this is a folder, not a file", file=path)
    if not path.exists():
        raise DataError("there is no such file", file=path)


def write_table(path: str | Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file whole or not at all; NaN becomes an empty cell.

    Numbers keep 6 significant digits and 6 decimals at least, so that clock times survive.

    Raises:
        DataError: the file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    # In one expression: a set of simulated greetings has hundreds of thousands of cells.
    writer.writerows(
        [
            value
            if not isinstance(value, float)
            else "0"  # of keys that are not pressed
            if not value
            else ""
            if value != value
            else f"{value:.6g}"
            if -1 < value < 1
            else f"{value:.6f}".rstrip("0").rstrip(".")
            for value in row
        ]
        for row in rows
    )
    write_text(path, text.getvalue())
