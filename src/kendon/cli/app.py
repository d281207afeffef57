"""The command `kendon`: its commands, and one way in which all of them fail."""

from __future__ import annotations

import glob
import os
import sys

import typer

from kendon._version import __version__
from kendon.cli.entry import BROKEN_PIPE, tell
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


def run() -> int:
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
        return tell(sentence(error, " ".join(["kendon", *(w for w in words[:1] if w in known)])))
    except KendonError as error:
        return tell(str(error))
    except BrokenPipeError:
        return BROKEN_PIPE
    except OSError as error:
        # Files are named; what has no name is where the results are printed.
        place = error.filename or "the standard output"
        return tell(f"{place}: {error.strerror or error}")
    return 0


def _typed() -> list[str]:
    """The words after `kendon`; on Windows, where no shell does it, wildcards are resolved."""
    if os.name != "nt":
        return sys.argv[1:]
    return [name for word in sys.argv[1:] for name in (sorted(glob.glob(word)) or [word])]
