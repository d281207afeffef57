"""`kendon greet`: the main job, a person in and a robot's answer out."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress
from rich.text import Text

from kendon.cli.options import (
    CalibrationOption,
    CameraPoseOption,
    FovOption,
    FpsOption,
    GesturesOption,
    ModelFilesOption,
    ModelOption,
    PersonOption,
    PoseModelOption,
    SourceOption,
    err,
    note,
    out,
    point,
    source_options,
)
from kendon.cli.targets import check_targets, folder_name
from kendon.cli.viewing import (
    HOST,
    PAGE,
    PORT,
    SHOWN_ROBOT,
    HostOption,
    OpenOption,
    PortOption,
    RecordOption,
    Stages,
    check_replay,
    encounter_title,
    show,
    with_gestures,
)
from kendon.errors import DataError, ParameterError
from kendon.estimate import Estimate
from kendon.greeter import Encounter, Greeter, Moment
from kendon.models import DEFAULT_MODEL, load_model
from kendon.robots import DEFAULT_ROBOT, Robot, RobotOptions, make_robot
from kendon.sources import open_source
from kendon.tables import write_table
from kendon.trees import GreetingTree
from kendon.viewer.browser.session import Choices
from kendon.viewer.browser.stage import Stage
from kendon.viewer.timeline import Timeline

_SOURCE_HELP = (
    "A recording, `camera:0`, or `simulated` (also `simulated:late-wave` and others, see"
    " `kendon sources`)."
)


EPILOG = """
**Examples**

`kendon greet` · a simulated person, as fast as it goes

`kendon greet simulated:late-wave --speed 1 --figure wave.png` · in real time, drawn at the end

`kendon greet recording.csv --tree my_trees.xml --out answers/` · your own behaviour trees

`kendon greet --view` · watch it in a browser, and look back at any moment

`kendon greet --record greeting.html` · a page that replays it anywhere

`kendon greet --robot mujoco --video greeting.mp4` · Vizzy's body with physics, filmed

`kendon greet camera:0 --fov 70` · whoever stands before the camera
"""


FaceOption = Annotated[
    str | None,
    typer.Option(
        "--robot-face",
        metavar="X,Y,Z",
        help="The face of the robot `point` in its base frame [m]; 0,0,1.2 if not given.",
    ),
]
#: What --out writes.
PHASES, COMMANDS = "phases.csv", "commands.csv"
#: The files a figure can be drawn into.
PICTURES = (".png", ".svg", ".pdf")
#: How much of an encounter --record keeps at most, the newest [s].
_RECORDED = 3600.0


def greet_command(
    spec: Annotated[str, typer.Argument(metavar="[SOURCE]", help=_SOURCE_HELP)] = "simulated",
    model: ModelOption = DEFAULT_MODEL,
    tree: Annotated[
        Path | None, typer.Option(help="A BehaviorTree.CPP XML file instead of kendon's own.")
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(help="A robot's name (see `kendon robots`) or .toml file."),
    ] = None,
    speed: Annotated[
        float, typer.Option(help="1 plays in real time, 2 twice as fast; 0 as fast as it goes.")
    ] = 0.0,
    figure: Annotated[
        Path | None, typer.Option(help="Draw the encounter into this .png, .svg or .pdf.")
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            help="Draw the robot's body with the person, a phase an image, into this .png."
        ),
    ] = None,
    video: Annotated[
        Path | None,
        typer.Option(help="Film them into this .mp4 or .webm (needs the extra `camera`)."),
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--out",
            parser=folder_name,
            metavar="DIR",
            help="Write phases.csv and commands.csv into this folder.",
        ),
    ] = None,
    view: Annotated[
        bool, typer.Option("--view", help="Watch it in a browser.", rich_help_panel=PAGE)
    ] = False,
    record: RecordOption = None,
    host: HostOption = HOST,
    port: PortOption = PORT,
    open_browser: OpenOption = True,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No timeline.")] = False,
    robot_face: FaceOption = None,
    gestures_from_phases: GesturesOption = False,
    source: SourceOption = None,
    camera_pose: CameraPoseOption = "0,0,1.2",
    fov: FovOption = None,
    fps: FpsOption = None,
    model_files: ModelFilesOption = None,
    calibration: CalibrationOption = None,
    pose_model: PoseModelOption = None,
    person: PersonOption = None,
) -> None:
    """Let a robot greet the person of a source; without one, a simulated person."""
    if not 0 <= speed <= 1000:
        raise ParameterError(f"--speed lies between 0 (as fast as it goes) and 1000, not {speed:g}")
    if figure and figure.suffix.lower() not in PICTURES:
        raise DataError(f"a figure is a {' or '.join(PICTURES)} file", file=figure)
    files = [("--figure", figure), ("--picture", picture), ("--video", video), ("--record", record)]
    if folder:
        files += [("--out", folder / PHASES), ("--out", folder / COMMANDS)]
    check_targets(files, [("--out", folder)], [spec, tree, model, robot])
    face = None if robot_face is None else point("--robot-face", robot_face)
    if picture or video:
        _check_drawing(robot, picture, video)
        robot = robot or "mujoco"
    options = source_options(camera_pose, fov, fps, model_files, calibration, pose_model, person)
    if view:
        if figure or picture or video or folder:
            raise ParameterError(
                "--view shows an encounter as it goes on; --figure, --picture, --video and --out"
                " are for one that ends: leave out either"
            )
        shown = robot or (SHOWN_ROBOT if face is None else DEFAULT_ROBOT)
        stages = Stages(options, source, tree, face, gestures_from_phases)
        show(stages.make, Choices(spec, model, shown), host, port, open_browser, record)
        return
    if record:
        check_replay(record)
        robot = robot or (SHOWN_ROBOT if face is None else DEFAULT_ROBOT)
    behaviour = GreetingTree(tree) if tree else GreetingTree()
    greeting_model = load_model(model)
    opened = open_source(spec, options, name=source)
    if gestures_from_phases:
        opened = with_gestures(opened, spec)
    for sentence in opened.notes:
        note(sentence)
    greeting_robot = make_robot(
        robot or DEFAULT_ROBOT, RobotOptions(face, None if opened.reacts else 0.0)
    )
    greeter = Greeter(opened, greeting_model, greeting_robot, behaviour)
    if picture or video:
        _keep_history(greeting_robot)
    title = encounter_title(spec)
    stage = Stage(greeter, title, history=_RECORDED) if record else None
    encounter, stopped = _run(greeter, stage.run() if stage else greeter.run(), title, speed, quiet)
    encounter.require_readings()
    if not quiet:
        _print_summary(encounter)
    if figure:
        # matplotlib takes a second to import: only those who draw wait for it.
        from kendon.viewer.figure import draw_encounter

        draw_encounter(encounter, figure)
        part = "encounter until it was stopped" if stopped else "whole encounter"
        out.print(f"The {part} is drawn in {figure}.", highlight=False)
    if picture or video:
        _draw(encounter, greeting_robot, picture, video)
    if record and stage:
        from kendon.viewer.browser.replay import write_replay

        write_replay(stage, record)
        out.print(f"The replay is {record}; any browser shows it.", highlight=False)
    if folder:
        _write(encounter, folder)
        out.print(f"phases.csv and commands.csv are in {folder}.", highlight=False)


def _check_drawing(robot: str | None, picture: Path | None, video: Path | None) -> None:
    """Refuse what cannot be drawn before anything runs."""
    from kendon.viewer.pictures import require_film
    from kendon.viewer.stage import require_renderer

    if robot == "point":
        raise ParameterError(
            "the robot 'point' has no body to draw; ask for --robot mujoco or a robot file"
        )
    if picture and picture.suffix.lower() != ".png":
        raise DataError("a picture is a .png file", file=picture)
    if video:
        require_film(video)
    require_renderer()


def _keep_history(robot: Robot) -> None:
    from kendon.robots.mujoco import MujocoRobot

    if isinstance(robot, MujocoRobot):
        robot.history = []


def _draw(encounter: Encounter, robot: Robot, picture: Path | None, video: Path | None) -> None:
    from kendon.robots.mujoco import MujocoRobot
    from kendon.viewer.pictures import write_film, write_picture

    if not isinstance(robot, MujocoRobot):
        raise ParameterError("this robot has no body to draw")
    if picture:
        write_picture(encounter, robot, picture)
        out.print(f"An image of each phase that was read is in {picture}.", highlight=False)
    if video:
        with Progress(console=err, transient=True) as bar:
            task = bar.add_task("filming")
            write_film(
                encounter, robot, video,
                lambda done, count: bar.update(task, completed=done, total=count),
            )  # fmt: skip
        out.print(f"The film is {video}.", highlight=False)


def _run(
    greeter: Greeter, moments: Iterator[Moment], title: str, speed: float, quiet: bool
) -> tuple[Encounter, bool]:
    """Let it go on; what came of it, and whether somebody stopped it."""
    encounter, stopped = Encounter(title), False
    timeline = Timeline(out)
    told = len(greeter.source.notes)
    if not quiet:
        timeline.header()
    began = time.monotonic()
    try:
        for moment in moments:
            if speed and not greeter.source.live:
                time.sleep(max(0.0, began + moment.t / speed - time.monotonic()))
            encounter.add(moment)
            if not quiet:
                timeline.show(moment)
            for sentence in greeter.source.notes[told:]:  # learnt on the way
                note(sentence)
            told = len(greeter.source.notes)
    except KeyboardInterrupt:
        # Somebody ends a live greeting: what was seen so far is still summed up and drawn.
        err.print("stopped", style="dim")
        stopped = True
    for sentence in greeter.source.notes[told:]:
        note(sentence)
    return encounter, stopped


def _print_summary(encounter: Encounter) -> None:
    line = Text("The person  ")
    for i, phase in enumerate(encounter.phases):
        line.append(" → " if i else "", style="dim")
        line.append(phase.name, style=phase.color)
    out.print()
    out.print(line)
    out.print("The robot's answers")
    for phase, actions in groupby(encounter.stretches, key=lambda stretch: stretch[0].phase):
        told = ", ".join(action.label for action, _, _ in actions)
        answer = Text(f"  {phase.name if phase else '–':<4}", style=phase.color if phase else "")
        out.print(answer.append(told, style="default"), soft_wrap=True, highlight=False)


def _write(encounter: Encounter, folder: Path) -> None:
    probabilities = encounter.probabilities
    phases = probabilities.argmax(axis=1) + 1
    Estimate(encounter.observations, probabilities, phases).write(folder / PHASES)
    write_table(
        folder / COMMANDS,
        ["t", "until", "phase", "part", "command", "status", "reason"],
        (
            [
                action.start, action.end, action.phase.name if action.phase else "",
                action.channel, action.label, action.command.status.value, action.command.reason,
            ]
            for action in encounter.actions
        ),
    )  # fmt: skip
