"""The command `kendon`: its commands, and one way in which all of them fail."""

from __future__ import annotations

import io
import os
import sys

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

app = typer.Typer(
    name="kendon",
    help="Read which phase of a greeting a person is in, and let a robot greet back.",
    no_args_is_help=True,
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
    version: bool = typer.Option(
        False, "--version", help="Print the version.", callback=_print_version, is_eager=True
    ),
) -> None:
    pass


def main() -> None:
    """Run the command line; a mistake of the user is one sentence and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without bars gets question marks
    try:
        app()
    except KendonError as error:
        typer.echo(f"kendon: {error}", err=True)
        sys.exit(2)
    except KeyboardInterrupt:
        typer.echo("kendon: stopped", err=True)
        sys.exit(130)
    except BrokenPipeError:
        # The reader (head, less) has gone; silence the interpreter's flush at exit as well.
        _close_output()
        sys.exit(0)
    except OSError as error:
        _close_output()
        typer.echo(f"kendon: {error.strerror or error}", err=True)
        sys.exit(2)


def _close_output() -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
