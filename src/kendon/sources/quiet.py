"""Keeping native libraries quiet on a terminal that shows something else."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def quiet_stderr() -> Iterator[None]:
    """Send what native code writes to the standard error stream nowhere, for a moment.

    MediaPipe, TensorFlow Lite, OpenCV and FFmpeg print past Python, onto the terminal that shows
    the live timeline. The stream is the whole process's, so this is held only while a model is
    set up or a file is opened; what goes wrong there comes back as an exception.
    """
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        saved = os.dup(2)
    except OSError:  # no standard error stream, as under pythonw: nothing to keep quiet
        yield
        return
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        os.close(nowhere)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
