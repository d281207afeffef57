"""`kendon sources`, `robots`, `models`, `trees` and `doctor`: what there is and what is missing."""

from __future__ import annotations

import importlib.metadata
import platform
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from kendon._version import __version__
from kendon.cli.options import out
from kendon.cli.tables import print_table
from kendon.cli.targets import check_targets
from kendon.errors import DataError, RendererError
from kendon.models import DEFAULT_MODEL, load_model, model_names
from kendon.robots import DEFAULT_ROBOT, RobotOptions, robot_kinds
from kendon.sources import registered_sources
from kendon.sources.model_files import ModelFileState, model_file_reports
from kendon.trees import NODES, Port, shipped_trees, write_trees

#: The packages of each optional extra, by the name they are imported under.
EXTRAS = {
    "bags": {"rosbags": "rosbags"},
    "camera": {"mediapipe": "mediapipe", "cv2": "opencv-contrib-python", "pooch": "pooch"},
    "cluster": {"distributed": "dask[distributed]"},
    "hmmlearn": {"hmmlearn": "hmmlearn"},
    "ros2": {"cyclonedds": "cyclonedds", "rosbags": "rosbags"},
    "view": {"viser": "viser"},
}


def sources_command() -> None:
    """List what kendon reads people from."""
    table = Table(box=None, pad_edge=False)
    for column in ("source", "reads", "example"):
        table.add_column(column)
    for name, source in registered_sources().items():
        table.add_row(name, source.reads, f"kendon greet {source.example}")
    print_table(table, out)


def robots_command() -> None:
    """List the robots that can greet."""
    table = Table(box=None, pad_edge=False)
    for column in ("robot", "what it is", "gestures"):
        table.add_column(column)
    for name, kind in robot_kinds().items():
        gestures = ", ".join(kind.make(RobotOptions()).gestures)
        table.add_row(f"{name}{' (default)' * (name == DEFAULT_ROBOT)}", kind.what, gestures)
    table.add_row("FILE.toml", "any MJCF or URDF model, with its joints named in the file", "")
    print_table(table, out)


def models_command() -> None:
    """List the greeting models."""
    table = Table(box=None, pad_edge=False)
    for column in ("model", "what it is", "source"):
        table.add_column(column)
    for name in model_names():
        model = load_model(name)
        table.add_row(f"{name}{' (default)' * (name == DEFAULT_MODEL)}", model.title, model.source)
    print_table(table, out)


def trees_command(
    export: Annotated[
        Path | None,
        typer.Option(help="Write kendon's own trees into this .xml file, to be edited."),
    ] = None,
) -> None:
    """List the nodes that a behaviour tree may use, with their ports."""
    if export:
        if export.suffix.lower() != ".xml":
            raise DataError("a file of trees ends in .xml", file=export)
        check_targets([("--export", export)])
        if export.exists():
            raise DataError("this file exists; name a new one", file=export)
        write_trees(shipped_trees(), export)
        out.print(f"{export} opens in Groot2; run it with: kendon greet --tree {export}")
        return
    table = Table(box=None, pad_edge=False)
    for column in ("node", "what it does", "ports"):
        table.add_column(column)
    for category in ("Action", "Condition", "Control", "Decorator"):
        table.add_section()
        table.add_row(Text(category, style="bold"))
        for node in NODES.values():
            if node.category == category:
                ports = (_port_words(port) for port in node.ports)
                table.add_row(node.id, node.doc, ", ".join(ports))
    print_table(table, out)


def _port_words(port: Port) -> str:
    default = f"={port.default}" if port.default else ""
    return f"{port.name}{default}" + " (out)" * (port.direction == "output")


def doctor_command(
    model_files: Annotated[
        Path | None, typer.Option("--model-files", help="The folder to look for model files in.")
    ] = None,
) -> None:
    """Tell what is installed, what is missing, and what to do about it."""
    table = Table(box=None, pad_edge=False)
    for column in ("", "what", "state"):
        table.add_column(column, no_wrap=True)  # so that paths can be copied

    def row(fine: bool, what: str, state: str) -> None:
        table.add_row(Text("✓", "green") if fine else Text("–", "yellow"), what, state)

    row(True, "kendon", __version__)
    row(True, "Python", f"{platform.python_version()} on {platform.system()}")
    todo: list[str] = []
    for package in ("numpy", "scipy", "py_trees", "matplotlib", "mujoco"):
        row(True, package, importlib.metadata.version(package))
    for extra, packages in EXTRAS.items():
        missing = [package for module, package in packages.items() if not _installed(module)]
        if missing:
            row(False, f"extra {extra}", f"without {', '.join(missing)}")
            todo.append(f"for the extra {extra}: pip install 'kendon[{extra}]'")
        else:
            row(True, f"extra {extra}", "installed")
    trouble = _drawing_trouble()
    row(not trouble, "--picture, --video", "nothing to draw with" if trouble else "can be drawn")
    if trouble:
        todo.append(trouble)
    for report in model_file_reports(model_files):
        ready = report.state is ModelFileState.READY
        row(ready, f"{report.file.name}", f"{report.state.value}: {report.path}")
        if report.advice:
            todo.append(f"{report.file.name}: {report.advice}")
    print_table(table, out)
    out.print()
    if todo:
        out.print("To do, if you need it:")
        for step in todo:
            out.print(f"  • {step}", soft_wrap=True)
    else:
        out.print("Nothing is missing.")


def _drawing_trouble() -> str:
    """Why the robot's body cannot be drawn, "" if it can."""
    from kendon.viewer.stage import require_renderer  # a second: not for those who need none

    try:
        require_renderer()
    except RendererError as error:
        return str(error)
    return ""


def _installed(module: str) -> bool:
    return find_spec(module) is not None
