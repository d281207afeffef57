"""Models by name or file: the published ones, and those that users train."""

from __future__ import annotations

import functools
import json
import os
import tomllib
from fractions import Fraction
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from kendon._version import __version__
from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.models.emissions import Family
from kendon.models.greeting import GreetingModel
from kendon.observations import FEATURES
from kendon.outputs import write_text
from kendon.person import FloatArray
from kendon.phases import PHASE_NAMES

#: The model that `load_model()` gives.
DEFAULT_MODEL = "trained"

#: How many metres a unit of length is.
_LENGTHS = {"m": 1.0, "mm": 1e-3}
#: The keys of a model file, and those it may have as well.
_KEYS = ("phases", "features", "startprob", "transmat", "means", "standard_deviations")
_OPTIONAL = ("title", "source", "length_unit", "family", "outliers")


def model_names() -> list[str]:
    """The names of the models that come with kendon, sorted."""
    return sorted(entry.name.removesuffix(".toml") for entry in _published().iterdir())


def load_model(name_or_path: str | Path = DEFAULT_MODEL) -> GreetingModel:
    """The model of a name (see `model_names`) or of a model file.

    Raises:
        UnknownNameError: no model has that name.
        DataError: the file is missing or is not a model.

    >>> load_model("kendon").transmat[0, 3]
    np.float64(0.2)
    """
    text = str(name_or_path)
    if text in model_names():
        return _read_published(text)
    path = Path(text)
    # os.path, as Path.exists raises for names that no file can have.
    if not text or (path.suffix != ".toml" and not os.path.exists(text)):
        raise UnknownNameError("model", text, [*model_names(), "or a path to a .toml model file"])
    if os.path.isdir(text):
        raise DataError("this is a folder, not a model file", file=path)
    if not os.path.isfile(text):
        raise DataError("there is no such model file", file=path)
    return _read(path, path.stem)


def _published() -> Traversable:
    return resources.files("kendon.models") / "published"


@functools.cache
def _read_published(name: str) -> GreetingModel:
    # Models cannot be changed, so that all who ask may share one.
    return _read(_published() / f"{name}.toml", name)


def _read(file: Traversable, name: str) -> GreetingModel:
    place = name if not isinstance(file, Path) else file
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DataError(f"this is not a readable model file ({error})", file=place) from None
    except OSError as error:
        raise DataError(f"cannot be read ({error.strerror})", file=place) from None
    missing = [key for key in _KEYS if key not in content]
    if missing:
        raise DataError(f"a model file needs {', '.join(missing)} as well", file=place)
    for key in content:
        if key not in (*_KEYS, *_OPTIONAL):
            raise DataError(str(UnknownNameError("key", key, (*_KEYS, *_OPTIONAL))), file=place)
    for key, expected in (("phases", PHASE_NAMES), ("features", FEATURES)):
        if content[key] != list(expected):
            raise DataError(f"{key} must be {', '.join(expected)} in this order", file=place)
    unit = content.get("length_unit", "m")
    if not isinstance(unit, str) or unit not in _LENGTHS:
        raise DataError(f"length_unit is {unit!r}; valid: {', '.join(_LENGTHS)}", file=place)
    # Distance and speed, the first two features, carry the length.
    scale = np.array([_LENGTHS[unit]] * 2 + [1.0] * (len(FEATURES) - 2))
    try:
        deviations = _table("standard_deviations", content) * scale
        if (deviations <= 0).any():
            raise ParameterError("every standard deviation must be positive")
        with np.errstate(over="ignore"):  # the model refuses what is not finite
            variances = deviations**2
        return GreetingModel(
            startprob=_numbers("startprob", content["startprob"]),
            transmat=_numbers("transmat", content["transmat"]),
            means=_table("means", content) * scale,
            variances=variances,
            family=content.get("family", Family.GAUSSIAN),
            outliers=_share("outliers", content.get("outliers", 0.0)),
            name=name,
            title=str(content.get("title", "")),
            source=str(content.get("source", "")),
        )
    except (ParameterError, UnknownNameError) as error:
        raise DataError(f"not a valid model: {error}", file=place) from None


def save_model(model: GreetingModel, path: str | Path) -> None:
    """Write a model file that `load_model` reads, whole or not at all.

    Raises:
        DataError: the file does not end in .toml, or cannot be written.
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise DataError("a model file ends in .toml", file=path)
    rows: dict[str, Any] = {
        "title": model.title,
        "source": model.source,
        "phases": list(PHASE_NAMES),
        "features": list(FEATURES),
        "length_unit": "m",
        "family": str(model.family),
        "outliers": model.outliers,
        "startprob": model.startprob.tolist(),
        "transmat": model.transmat.tolist(),
        "means": model.means.tolist(),
        "standard_deviations": np.sqrt(model.variances).tolist(),
    }
    # Strings and arrays of numbers are written alike in TOML and JSON.
    text = "".join(f"{key} = {_toml(value)}\n" for key, value in rows.items())
    write_text(path, f"# A greeting model, written by kendon {__version__}.\n{text}")


def _toml(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], list):
        return "[\n" + "".join(f"  {_toml(row)},\n" for row in value) + "]"
    return json.dumps(value, ensure_ascii=False)


def _share(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ParameterError(f"{key} must be a number, not {value!r}")
    return float(value)


def _table(key: str, content: dict[str, Any]) -> FloatArray:
    """A value for each phase and feature, shape (6, 7)."""
    values = _numbers(key, content[key])
    shape = (len(PHASE_NAMES), len(FEATURES))
    if values.shape != shape:
        raise ParameterError(f"{key} has shape {values.shape} instead of {shape}")
    return values


def _numbers(key: str, values: Any) -> FloatArray:
    """Nested lists of numbers and fractions ("2/3") as an array."""
    try:
        return np.array(_floats(values), dtype=float)
    except (ArithmeticError, TypeError, ValueError, RecursionError):
        raise ParameterError(
            f'{key} must hold finite numbers or fractions such as "2/3", in rows of equal length'
        ) from None


def _floats(values: Any) -> Any:
    if isinstance(values, list):
        return [_floats(value) for value in values]
    if isinstance(values, bool):
        raise TypeError
    return float(Fraction(values))
