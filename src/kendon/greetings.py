"""Sets of greetings: folders of recordings or observations, read and written as one.

A set is a folder with an ``index.csv``, whose column ``file`` names the greetings in it, one
CSV each: tracks or observations. Further columns say what one likes about them. A folder
without an index is the set of all its CSV files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from kendon.errors import DataError
from kendon.estimate import load_observations
from kendon.features import ROBOT_FACE
from kendon.geometry import Vec3
from kendon.observations import Observations, write_observations
from kendon.person import Track
from kendon.sources import SourceOptions
from kendon.tables import is_index, read_table, write_table

#: The file that lists the greetings of a set.
INDEX = "index.csv"


def expand(paths: Iterable[str | Path]) -> list[Path | str]:
    """The recordings that files, folders and indexes stand for, each once, in order.

    Raises:
        DataError: a folder holds no CSV file, or an index names a file that is not there.
    """
    found: dict[Path | str, None] = {}
    for path in paths:
        place = Path(path)
        if place.is_dir():
            index = place / INDEX
            files = _listed(index) if index.exists() else sorted(place.glob("*.csv"))
            if not files:
                raise DataError("no CSV file in this folder", file=place)
            found.update(dict.fromkeys(files))
        elif is_index(place):
            found.update(dict.fromkeys(_listed(place)))
        else:
            found[place if place.exists() else str(path)] = None
    return list(found)


def _listed(index: Path) -> list[Path]:
    table = read_table(index)
    table.require("file")
    files = []
    for number, name in enumerate(table.texts("file")):
        file = index.parent / name
        if not file.is_file():
            raise table.error(f"there is no file {name!r} beside the index", number, "file")
        files.append(file)
    return files
