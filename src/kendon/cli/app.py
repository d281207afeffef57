"""The command `kendon`: its commands, and one way in which all of them fail."""

from __future__ import annotations

import contextlib
import glob
import io
import os
import signal
import sys
import threading
from types import FrameType

import typer

from kendon._version import __version__
from kendon.cli.estimate import EPILOG as ESTIMATE_EPILOG
from kendon.cli.estimate import estimate_command
from kendon.cli.evaluate import EPILOG as EVALUATE_EPILOG
from kendon.cli.evaluate import evaluate_command
from kendon.cli.experiments import EPILOG as EXPERIMENTS_EPILOG
from kendon.cli.experiments import experiments_command
from kendon.cli.fit import EPILOG as FIT_EPILOG
from kendon.cli.fit import fit_command
from kendon.cli.greet import EPILOG as GREET_EPILOG
from kendon.cli.greet import greet_command
from kendon.cli.information import (
    doctor_command,
    models_command,
    robots_command,
    sources_command,
    trees_command,
)
from kendon.cli.mistakes import Commands, UsageError, sentence
from kendon.cli.play import EPILOG as PLAY_EPILOG
from kendon.cli.play import play_command
from kendon.cli.ros1 import EPILOG as ROS1_EPILOG
from kendon.cli.ros1 import ros1_command
from kendon.cli.ros1_tools import FACES_EPILOG, GAZEBO_EPILOG, gazebo_command, ros1_faces_command
from kendon.cli.ros2 import EPILOG as ROS2_EPILOG
from kendon.cli.ros2 import ros2_command
from kendon.cli.simulate import EPILOG as SIMULATE_EPILOG
from kendon.cli.simulate import simulate_command
from kendon.errors import KendonError

#: The reader of what is printed (head, less) has gone; rich ends with the same. It is no
#: success, as what would have been done after the printing is not done.
_BROKEN_PIPE = 1

app = typer.Typer(
    name="kendon",
    help="Read which phase of a greeting a person is in, and let a robot greet back.",
    cls=Commands,
    invoke_without_command=True,
    add_completion=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)
app.command("greet", epilog=GREET_EPILOG)(greet_command)
app.command("play", epilog=PLAY_EPILOG)(play_command)
app.command("estimate", epilog=ESTIMATE_EPILOG)(estimate_command)
app.command("evaluate", epilog=EVALUATE_EPILOG)(evaluate_command)
app.command("fit", epilog=FIT_EPILOG)(fit_command)
app.command("simulate", epilog=SIMULATE_EPILOG)(simulate_command)
app.command("experiments", epilog=EXPERIMENTS_EPILOG)(experiments_command)
app.command("ros1", epilog=ROS1_EPILOG)(ros1_command)
app.command("ros1-faces", epilog=FACES_EPILOG)(ros1_faces_command)
app.command("gazebo", epilog=GAZEBO_EPILOG)(gazebo_command)
app.command("ros2", epilog=ROS2_EPILOG)(ros2_command)
app.command("sources")(sources_command)
app.command("robots")(robots_command)
app.command("models")(models_command)
app.command("trees")(trees_command)
app.command("doctor")(doctor_command)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"kendon {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    context: typer.Context,
    version: bool = typer.Option(
        False, "--version", help="Print the version.", callback=_print_version, is_eager=True
    ),
) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(2)


def main() -> None:
    """Run the command line; a mistake of the user is one sentence and exit code 2."""
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
    words = _typed()
    try:
        command = typer.main.get_command(app)
        with command.make_context("kendon", list(words)) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except UsageError as error:
        known = {command.name for command in app.registered_commands}
        return _tell(sentence(error, " ".join(["kendon", *(w for w in words[:1] if w in known)])))
    except KendonError as error:
        return _tell(str(error))
    except KeyboardInterrupt:
        _tell("stopped")
        return 130
    except BrokenPipeError:
        return _BROKEN_PIPE
    except OSError as error:
        # Files are named; what has no name is where the results are printed.
        place = error.filename or "the standard output"
        return _tell(f"{place}: {error.strerror or error}")
    return 0


def _typed() -> list[str]:
    """The words after `kendon`; on Windows, where no shell does it, wildcards are resolved."""
    if os.name != "nt":
        return sys.argv[1:]
    return [name for word in sys.argv[1:] for name in (sorted(glob.glob(word)) or [word])]


def _tell(message: str) -> int:
    with contextlib.suppress(OSError):
        typer.echo(f"kendon: {message}", err=True)
    return 2


def _finish_output(code: int) -> int:
    """Write what is still to be written, here where a failure can be told; the exit code."""
    try:
        sys.stdout.flush()
    except OSError as error:
        # Silence the interpreter's own attempt at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return code or _BROKEN_PIPE
        return code or _tell(f"the standard output: {error.strerror}")
    return code
