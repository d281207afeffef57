"""Sets of greetings: folders of recordings or observations, read and written as one.

A set is a folder with an ``index.csv``, whose column ``file`` names the greetings in it, one
CSV each: tracks or observations. Further columns say what one likes about them. A folder
without an index is the set of all its CSV files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from kendon.errors import DataError, ParameterError
from kendon.features import PERIOD, ROBOT_FACE, observe
from kendon.geometry import Vec3
from kendon.observations import (
    Observations,
    read_observations,
    write_observations,
)
from kendon.person import PersonFrame, Track
from kendon.sources import Source, SourceOptions, find_source, open_source, recordings
from kendon.tables import is_index, is_observations, read_table, write_table

#: The file that lists the greetings of a set.
INDEX = "index.csv"


def expand(paths: Iterable[str | Path]) -> list[Path | str]:
    """The recordings that files, folders and indexes stand for, each once, in order.

    A file of several people may stand for one recording each (`Source.recordings`).

    Raises:
        DataError: a folder holds no CSV file, or an index names a file that is not there.
        MissingExtraError: an extra is needed to tell who is in a file.
    """
    found: dict[Path | str, None] = {}
    for path in paths:
        if not str(path):
            raise DataError("an empty name is no recording")
        place = Path(path)
        people = recordings(path)
        if len(people) > 1 or (people and place.is_dir()):
            found.update(dict.fromkeys(people))
        elif place.is_dir():
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


def load_greetings(paths: Iterable[str | Path], **how: Any) -> list[Observations]:
    """The observations of every recording that files, folders and indexes stand for.

    Args:
        paths: see `expand`.
        **how: see `load_observations`.

    Raises:
        DataError: a recording cannot be read.
    """
    return [load_observations(path, **how) for path in expand(paths)]


def write_greetings(
    folder: str | Path,
    greetings: Sequence[Observations],
    columns: Sequence[str] = (),
    rows: Sequence[Sequence[object]] = (),
) -> None:
    """Write a set: one observations CSV a greeting, then the index that names them all.

    Args:
        folder: made if it is not there.
        greetings: named apart.
        columns: further columns of the index.
        rows: their values, one row a greeting.

    Raises:
        DataError: the folder cannot be written to, or holds an index already.
        ParameterError: two greetings have one name.
    """
    folder = Path(folder)
    if (folder / INDEX).exists():
        raise DataError("this folder holds a set of greetings already; name another", file=folder)
    names = [f"{greeting.name}.csv" for greeting in greetings]
    if len(set(names)) < len(names):
        raise ParameterError("the greetings of a set need different names")
    for greeting, name in zip(greetings, names, strict=True):
        write_observations(greeting, folder / name)
    further = rows or [()] * len(names)
    write_table(
        folder / INDEX,
        ["file", *columns],
        ([name, *more] for name, more in zip(names, further, strict=True)),
    )


def load_observations(
    spec: str | Path,
    options: SourceOptions | None = None,
    *,
    source: str | None = None,
    robot_face: Vec3 = ROBOT_FACE,
    gestures_from_phases: bool = False,
    sensor: Callable[[Track], Track] | None = None,
    progress: Callable[[PersonFrame], None] | None = None,
    record: Callable[[Source], Track] | None = None,
    note: Callable[[str], None] | None = None,
) -> Observations:
    """The observations of a file, whether it holds them ready or a person to observe.

    Args:
        spec: a file that a source recognises, or an observations CSV.
        options: how the source is read.
        source: the source's name, where it is not to be found out from the file.
        robot_face: the robot's face in its base frame [m].
        gestures_from_phases: press the thesis's keys as the true phases say (3.3.5).
        sensor: what a worse sensor would have seen of a track; after the keys, before features.
        progress: called after each frame of a source that takes its time.
        record: makes the track of a source, and knows when a live one is to end; where it is left
            out, `Source.record` does, which reads no live source.
        note: called with each sentence the source has for the user.

    Raises:
        DataError: the file cannot be read, or lasts less than one interval.
        ParameterError: there are no true phases to press keys by.
    """
    if source is None and is_observations(spec):
        observations = read_observations(spec)
        if gestures_from_phases or sensor:
            raise ParameterError(
                f"{spec}: these are observations; gestures and sensors are for tracks of people"
            )
        return observations
    if find_source(spec, name=source).live:
        if record is None:
            raise DataError(
                "this is a device, not a recording; kendon estimate and kendon greet read it",
                file=spec,
            )
        if gestures_from_phases:
            raise ParameterError(f"{spec} has no true phases to press keys by")
    opened = open_source(spec, options, name=source)
    try:
        track = record(opened) if record else opened.record(progress)
    finally:
        # A source learns some of what the user should know while it reads.
        if note:
            for sentence in opened.notes:
                note(sentence)
    if gestures_from_phases:
        track = track.with_gestures_from_phases()
    if sensor:
        track = sensor(track)
    if track.duration < PERIOD:
        raise DataError(
            f"lasts {track.duration:.2f} s; the first observation needs {PERIOD:g} s", file=spec
        )
    observations = observe(track, robot_face)
    if not (observations.values[:, 0] >= 0).any():
        if options and options.person:
            raise DataError(f"person {options.person} is never seen in it", file=spec)
        raise DataError("nobody is seen in it: the face's place is unknown throughout", file=spec)
    return observations


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
