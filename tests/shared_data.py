"""Finds the recordings and model files lent for testing, which are no part of the checkout.

They lie in the folder named by the environment variable ``KENDON_SHARED``, or else in
``shared`` beside the checkout. A test that asks for one is skipped where there is none.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_CHECKOUT = Path(__file__).resolve().parents[1]


def shared_folder() -> Path:
    """The folder in which the lent files are expected; it need not exist."""
    named = os.environ.get("KENDON_SHARED")
    return Path(named) if named else _CHECKOUT.parent / "shared"


def shared_file(relative: str) -> Path:
    """The lent file or folder of that name, such as ``data/faces/single_face.mp4``.

    Skips the test, or the module when called at its top, if it is absent.
    """
    path = shared_folder() / relative
    if not path.exists():
        _skip(relative)
    return path


def shared_files(pattern: str) -> list[Path]:
    """The lent files that match, such as ``data/gestures/wave_*.csv``, in order; at least one.

    Skips like `shared_file` if there is none.
    """
    paths = sorted(shared_folder().glob(pattern))
    if not paths:
        _skip(pattern)
    return paths


def _skip(wanted: str) -> None:
    pytest.skip(
        f"{wanted} is not lent here: looked in {shared_folder()}"
        " (KENDON_SHARED names another folder)",
        allow_module_level=True,
    )
