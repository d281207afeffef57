"""Where the command begins and ends: its output, the signals that end it, and its exit code.

The commands themselves take half a second to import. That is done where an interrupt is answered.
"""

from __future__ import annotations

import contextlib
import io
import os
import signal
import sys
import threading
from types import FrameType

#: The reader of what is printed (head, less) has gone; rich ends with the same. It is no
#: success, as what would have been done after the printing is not done.
BROKEN_PIPE = 1
#: What shells make of an interrupt.
INTERRUPTED = 128 + signal.SIGINT


def main() -> None:
    """Run the command line; a mistake of the user is one sentence and exit code 2."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started it; libraries ask it for more
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - until the end
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without bars gets question marks
    if threading.current_thread() is not threading.main_thread():
        sys.exit(_finish_output(_run()))  # signals are the main thread's
    before = signal.signal(signal.SIGTERM, _end)
    try:
        sys.exit(_finish_output(_run()))
    finally:
        signal.signal(signal.SIGTERM, before)


def _end(number: int, frame: FrameType | None) -> None:
    """End like at an error, so that no half of a file is left behind."""
    del frame
    sys.exit(128 + number)


def _run() -> int:
    """Run the command that was typed; its exit code."""
    try:
        from kendon.cli.app import run

        return run()
    except KeyboardInterrupt:
        tell("stopped")
        return INTERRUPTED


def tell(message: str) -> int:
    """Tell what is wrong; the exit code of a mistake."""
    with contextlib.suppress(OSError):
        print(f"kendon: {message}", file=sys.stderr)
    return 2


def _finish_output(code: int) -> int:
    """Write what is still to be written, here where a failure can be told; the exit code."""
    try:
        sys.stdout.flush()
    except OSError as error:
        # Silence the interpreter's own attempt at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return code or BROKEN_PIPE
        return code or tell(f"the standard output: {error.strerror}")
    return code
