"""What a command is to write, looked at before the work: one rule for every option that names it.

A file that is there is replaced where its command says so, a folder that is missing is made, and
what cannot be written or is read itself is refused, before anything is read, shown or made.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import typer

from kendon.errors import DataError, ParameterError
from kendon.outputs import check_file, check_folder

Named = Iterable[tuple[str, Path | None]]


def folder_name(text: str) -> Path:
    """A folder that an option names; a shell's variable that is not set is none.

    Raises:
        typer.BadParameter: the name is empty, which a `Path` would take for the folder one is in.
    """
    if not text.strip():
        raise typer.BadParameter("an empty name is no folder; write ./ for the one you are in")
    return Path(text)


def check_targets(
    files: Named = (), folders: Named = (), read: Iterable[str | Path | None] = ()
) -> None:
    """Refuse before the work what could not be written after it.

    Args:
        files: to write, each with the option that names it; None for those not given.
        folders: to write into, likewise.
        read: what the command reads: names of files and of other things.

    Raises:
        DataError: a result cannot be written where it is to be.
        ParameterError: two results, or a result and what is read, would be the same file.
    """
    for option, folder in folders:
        if folder is not None:
            if folder.exists() and not folder.is_dir():
                raise DataError(f"{option} names a folder, but this is a file", file=folder)
            check_folder(folder)
    inputs = {Path(name).resolve() for name in read if name and Path(name).is_file()}
    taken: dict[Path, str] = {}
    for option, path in files:
        if path is None:
            continue
        if path.is_dir():
            raise DataError(f"{option} names a file, but this is a folder", file=path)
        check_file(path)
        place = path.resolve()
        if place in inputs:
            raise ParameterError(
                f"{option} would overwrite {path}, which is read; name another place"
            )
        if place in taken:
            raise ParameterError(f"{taken[place]} and {option} would both be written to {path}")
        taken[place] = option
