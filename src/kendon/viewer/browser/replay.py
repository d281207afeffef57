"""An encounter as one page of its own, which needs neither kendon nor a network to be watched."""

from __future__ import annotations

import base64
import json
import string
from collections.abc import Callable, Hashable
from functools import partial
from html import escape
from importlib.resources import files
from pathlib import Path

from kendon.errors import DataError
from kendon.outputs import check_file, write_text
from kendon.viewer.browser.cameras import FOV, course, overview
from kendon.viewer.browser.charts import chart_values, draw_charts, plot_box
from kendon.viewer.browser.panels import log_rows, phase_card, tree_view
from kendon.viewer.browser.scene import Scene
from kendon.viewer.browser.serving import start_server, stop_server
from kendon.viewer.browser.stage import Snapshot, Stage

_WIDTH = 370  # [pixels], of the charts
#: The picture, about: on a large screen and, smaller, on a phone [pixels].
_PICTURE = (700, 620)
#: A longer encounter is recorded with fewer images: so many at most.
_MOST_IMAGES = 2400
#: The ticks of the flow a second, and the images a tick of a short encounter.
_TICK, _IMAGES = 0.1, 2


def replay_page(stage: Stage) -> str:
    """What a stage remembers of its encounter, as the text of an HTML page.

    Raises:
        DataError: nothing has happened yet.
    """
    snapshots = list(stage.snapshots)
    if not snapshots:
        raise DataError("there is nothing to replay; the encounter has not begun")
    start, stop = snapshots[0].t, max(snapshots[-1].t, snapshots[0].t + 1.0)
    left, plot, beside = plot_box(_WIDTH)
    cards, trees, values = _Distinct(), _Distinct(), _Distinct()
    record = {
        "start": start,
        "stop": stop,
        "width": _WIDTH,
        "left": left,
        "plot": plot,
        "beside": beside,
        "t": [round(s.t, 3) for s in snapshots],
        "card": [cards.place(s.said, partial(phase_card, s)) for s in snapshots],
        "tree": [trees.place(s.nodes, partial(tree_view, stage.nodes, s.nodes))
                 for s in snapshots],
        "value": [values.place(s.observation and s.observation.t, partial(_beside, s))
                  for s in snapshots],
        "cards": cards.contents,
        "trees": trees.contents,
        "values": values.contents,
        "log": log_rows([a for a in stage.actions if a.start >= start - 0.1]),
    }  # fmt: skip
    template = files("kendon.viewer.browser").joinpath("replay.html").read_text(encoding="utf-8")
    return string.Template(template).substitute(
        title=escape(stage.title or "An encounter"),
        charts=draw_charts(snapshots, start, stop, width=_WIDTH, values=False),
        # No text may end the script element it stands in.
        record=json.dumps(record).replace("</", "<\\/"),
        scene=base64.b64encode(_scene(stage).encode()).decode("ascii"),
    )


def write_replay(stage: Stage, path: str | Path) -> None:
    """Write an encounter's replay into a file.

    Raises:
        DataError: the file cannot be written, or nothing has happened yet.
    """
    write_text(path, replay_page(stage))


def check_replay(path: Path) -> None:
    """Refuse a file that a replay could not be written to, before anything runs.

    Raises:
        DataError: its name is no page's, or it cannot be written.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        raise DataError("a replay is a .html file", file=path)
    check_file(path)


def _beside(snapshot: Snapshot) -> list[tuple[float, str]]:
    """The numbers that stand beside the charts: how high, and the text."""
    return [(level, words) for _, level, words in chart_values(snapshot)]


class _Distinct:
    """Contents that differ, each once, and which of them is wanted where."""

    def __init__(self) -> None:
        self.contents: list[object] = []
        self._places: dict[Hashable, int] = {}

    def place(self, key: Hashable, make: Callable[[], object]) -> int:
        if key not in self._places:
            self._places[key] = len(self.contents)
            self.contents.append(make())
        return self._places[key]


def _scene(stage: Stage) -> str:
    """The bodies over time as a page of viser's own, whose player runs it."""
    server = start_server("127.0.0.1", 0)
    try:
        scene = Scene(server)
        scene.draw(stage, stage.shown(0), 0)
        count = len(stage.snapshots)
        instants = [stage.shown(place) for place in range(count)]
        position, look_at = overview(instants, course(instants[0]), _PICTURE)
        camera = server.initial_camera
        camera.up, camera.fov = (0.0, 0.0, 1.0), FOV
        camera.position, camera.look_at = position, look_at
        recording = server.get_scene_serializer()
        ticks = max(1, -(-count // _MOST_IMAGES))
        images = _IMAGES if count * _IMAGES <= _MOST_IMAGES else 1
        for place in range(ticks, count, ticks):
            for image in range(images):
                recording.insert_sleep(_TICK * ticks / images)
                scene.draw(stage, stage.shown(place, (image + 1) / images), place)
        return recording.as_html()
    finally:
        stop_server(server)
