"""The neural networks' files: which there are, where kendon looks for them, whether they are whole.

A file is looked for in the folder the user names (``--model-files DIR``), else in the folder that
the environment variable ``KENDON_MODEL_FILES`` names, else in the user's cache, where it is
downloaded once. A named folder is never written to and never falls back to a download: whoever
names one, on a robot without internet say, wants to know what is missing from it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from kendon.errors import MissingExtraError, ModelFileError, UnknownNameError

#: The environment variable that names a folder of model files.
ENVIRONMENT_VARIABLE = "KENDON_MODEL_FILES"


@dataclass(frozen=True)
class ModelFile:
    """One neural network's file."""

    name: str  # of the file
    purpose: str  # what kendon uses it for
    sha256: str  # hexadecimal, of the whole file
    licence: str
    origin: str  # the public address of the maker's copy


FACE_LANDMARKER = ModelFile(
    name="face_landmarker.task",
    purpose="MediaPipe Face Landmarker (float16, version 1): head, eyes and smile in a video",
    sha256="64184e229b263107bc2b804c6625db1341ff2bb731874b0bcc2fe6544e0bc9ff",
    licence="Apache-2.0",
    origin=(
        "https://storage.googleapis.com/mediapipe-models/face_landmarker/face_landmarker/"
        "float16/1/face_landmarker.task"
    ),
)

FACE_FINDER = ModelFile(
    name="face_detection_yunet_2026may.onnx",
    purpose="OpenCV's YuNet (2026may): where in a picture there are faces, near and far",
    sha256="ebafce4e3c118d6554634be5c27ab333b4c047a9a8c3faf1d7cf93101c22f0f0",
    licence="MIT",
    origin=(
        "https://media.githubusercontent.com/media/opencv/opencv_zoo/main/models/"
        "face_detection_yunet/face_detection_yunet_2026may.onnx"
    ),
)

#: Every neural network's file by its name.
MODEL_FILES: Mapping[str, ModelFile] = {file.name: file for file in (FACE_LANDMARKER, FACE_FINDER)}


class ModelFileState(Enum):
    """How a model file is found without downloading anything."""

    READY = "ready"
    MISSING = "missing"
    DAMAGED = "checksum differs"


@dataclass(frozen=True)
class ModelFileReport:
    """What `kendon doctor` says about one model file."""

    file: ModelFile
    state: ModelFileState
    path: Path  # where it is, or would be
    advice: str  # what to do about it; empty when it is ready


def find_model_file(name: str, folder: str | Path | None = None) -> Path:
    """The path of a model file, whole and of the expected content.

    Args:
        name: of the file, one of `MODEL_FILES`.
        folder: the folder the user names; None to follow the environment variable or the cache.

    Raises:
        UnknownNameError: kendon uses no such file.
        ModelFileError: it is not in the named folder, is damaged, or cannot be downloaded.
        MissingExtraError: a download is needed and the ``camera`` extra is not installed.
    """
    file = _known(name)
    named = _named_folder(folder)
    if named is None:
        return _cached(file)
    place, label = named
    path = place / file.name
    if not path.is_file():
        raise ModelFileError(f"{label} {place} holds no {file.name}; {_holds(place)}; {_get(file)}")
    if _sha256(path) != file.sha256:
        raise ModelFileError(f"{path} {_damaged(path, file)}; {_get(file)}")
    return path


def model_file_reports(folder: str | Path | None = None) -> list[ModelFileReport]:
    """The state of every model file, for `kendon doctor`; downloads nothing.

    Args:
        folder: the folder the user names; None to follow the environment variable or the cache.
    """
    named = _named_folder(folder)
    place = named[0] if named else cache_folder()
    reports = []
    for file in MODEL_FILES.values():
        path = place / file.name
        if not path.is_file():
            state = ModelFileState.MISSING
            advice = _get(file) if named else f"it is downloaded at the first use; or {_get(file)}"
        elif _sha256(path) != file.sha256:
            state, advice = ModelFileState.DAMAGED, f"delete {path}, then {_get(file)}"
        else:
            state, advice = ModelFileState.READY, ""
        reports.append(ModelFileReport(file, state, path, advice))
    return reports


def cache_folder() -> Path:
    """Where downloaded model files are kept: the user's cache folder of kendon.

    Without pooch (the ``camera`` extra) nothing can have been downloaded; the folder is then the
    one pooch would choose on Linux.
    """
    try:
        import pooch
    except ImportError:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "kendon"
    return Path(pooch.os_cache("kendon"))


def _known(name: str) -> ModelFile:
    try:
        return MODEL_FILES[name]
    except KeyError:
        raise UnknownNameError("model file", name, MODEL_FILES) from None


def _named_folder(folder: str | Path | None) -> tuple[Path, str] | None:
    """The folder that the user or the environment names, and what to call it in a message."""
    if folder is not None:
        return Path(folder).expanduser(), "the folder of model files"
    if variable := os.environ.get(ENVIRONMENT_VARIABLE):
        return Path(variable).expanduser(), f"the folder that {ENVIRONMENT_VARIABLE} names,"
    return None


def _cached(file: ModelFile) -> Path:
    """The file in the cache; downloaded when it is not there yet or not whole."""
    folder = cache_folder()
    path = folder / file.name
    if path.is_file() and _sha256(path) == file.sha256:
        return path
    pooch = _import_pooch(file)
    try:
        return Path(
            pooch.retrieve(
                url=file.origin,
                known_hash=f"sha256:{file.sha256}",
                fname=file.name,
                path=folder,
            )
        )
    except ValueError as error:  # pooch: the download's checksum is another
        raise ModelFileError(
            f"{file.origin} sent something else than {file.name} (its sha256 is not"
            f" {file.sha256}); a proxy or login page may stand between: {_get(file)}"
        ) from error
    except OSError as error:  # no network, no such host, a full or read-only disk
        raise ModelFileError(
            f"{file.name} could not be downloaded to {folder} ({_reason(error)}); {_get(file)}"
        ) from error


def _import_pooch(file: ModelFile) -> Any:
    try:
        import pooch
    except ImportError as error:
        raise MissingExtraError(f"downloading {file.name}", "camera", "pooch") from error
    return pooch


def _get(file: ModelFile) -> str:
    """How to come by a file by hand."""
    return (
        f"get it from {file.origin}, put it into a folder and name that folder with"
        f" --model-files DIR or {ENVIRONMENT_VARIABLE}"
    )


def _holds(folder: Path) -> str:
    """What is in a folder, for a message about what is not."""
    if not folder.exists():
        return "there is no such folder"
    if not folder.is_dir():
        return "it is a file, not a folder"
    names = sorted(entry.name for entry in folder.iterdir())
    shown = ", ".join(names[:10]) + (f" and {len(names) - 10} more" if len(names) > 10 else "")
    return f"it holds {shown}" if names else "it is empty"


def _damaged(path: Path, file: ModelFile) -> str:
    return (
        f"is not the expected file ({path.stat().st_size} bytes; its sha256 is {_sha256(path)},"
        f" expected is {file.sha256})"
    )


def _reason(error: BaseException) -> str:
    """What went wrong, short enough for one sentence: requests nests its causes in the text."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 120 else text[:117] + "..."


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
