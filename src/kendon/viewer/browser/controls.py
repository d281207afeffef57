"""The page's panels: the reading on one side, what the user can do on the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import viser

from kendon.models import model_names
from kendon.robots import robot_kinds
from kendon.simulation import SCRIPTS
from kendon.simulation.temperaments import TEMPERAMENTS
from kendon.viewer.browser.cameras import VIEWS, Cameras
from kendon.viewer.browser.charts import draw_charts
from kendon.viewer.browser.panels import command_log, phase_card, tree_view
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.session import SPEEDS, Session

#: How much of the past the charts show [s].
WINDOW = 20.0

Wish = Callable[[Player], None]


#: What the user has the person do: the group, the button, the key, and what happens.
def _wishes(session: Session) -> list[tuple[str, str, str, Wish]]:
    def act(name: str) -> Wish:
        return lambda player: player.act(name, session.stage.robot.pose)

    return [
        ("Greet from afar", "Wave", "1", act("wave")),
        ("Greet from afar", "Nod", "2", act("nod")),
        ("Greet from afar", "Toss head", "3", act("toss")),
        ("On the way", "Dip head", "4", act("dip")),
        ("On the way", "Bow", "5", act("bow")),
        ("Greet nearby", "Shake hands", "6", act("handshake")),
        ("Greet nearby", "Hug", "7", act("hug")),
        ("Walk", "Up to the robot", "U", lambda p: p.walk_up(1.1)),
        ("Walk", "Back off", "B", lambda p: p.walk_up(6.0)),
        ("Walk", "Stop", "X", lambda p: p.stop()),
        ("Look", "At the robot", "R", lambda p: p.look("robot")),
        ("Look", "Away", "V", lambda p: p.look("away")),
        ("Look", "Down", "G", lambda p: p.look("down")),
        ("Turn", "To the robot", "T", lambda p: p.turn("robot")),
        ("Turn", "Your back", "Y", lambda p: p.turn("away")),
    ]


class Controls:
    """All panels of the page.

    Args:
        server: the server.
        session: what they show and steer.
        save: makes the replay of what is kept, as the text of a page.
        cameras: move as the user chooses.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        session: Session,
        save: Callable[[], str],
        cameras: Cameras,
    ) -> None:
        self._session, self._save, self._cameras = session, save, cameras
        self._gui = server.gui
        self._written: dict[str, str] = {}
        self._setting = False  # whether a value is being set here rather than by the user
        self._reading()
        if session.player is not None:
            self._play()
        self._time()
        self._views()
        self._encounter()
        self._gui.main_panel.dock_right()

    # ---- what is read

    def _reading(self) -> None:
        panel = self._gui.add_panel(order=-1)
        with panel.add_tab("What kendon reads"):
            self._card = self._gui.add_html("")
            self._charts = self._gui.add_html("")
            details = self._gui.add_tab_group()
            with details.add_tab("Behaviour tree"):
                self._tree = self._gui.add_html("")
            with details.add_tab("The robot's commands"):
                self._log = self._gui.add_html("")
        panel.dock_left()
        panel.set_width(390)

    def draw(self) -> None:
        """Write what the session shows now."""
        session = self._session
        stage, place = session.stage, session.place
        snapshot = stage.snapshots[place]
        self._write("card", self._card, phase_card(snapshot))
        label = f"kendon: {snapshot.phase.title}" if snapshot.phase else "kendon"
        if self._written.get("label") != label:
            self._written["label"] = label
            self._gui.set_panel_label(label)
        first = max(0, place - round(WINDOW * 10))
        window = [stage.snapshots[i] for i in range(first, place + 1)]
        # Up to the newest observation, so that the drawing changes only with the next.
        read = snapshot.observation.t if snapshot.observation else 0.0
        start = max(0.0, read - WINDOW)
        self._write("charts", self._charts, draw_charts(window, start, start + WINDOW))
        self._write("tree", self._tree, tree_view(stage.nodes, snapshot.nodes))
        self._write("log", self._log, command_log(list(stage.actions), snapshot.t))
        self._draw_time(snapshot.t)

    def _write(self, name: str, element: viser.GuiHtmlHandle, content: str) -> None:
        if self._written.get(name) != content:
            self._written[name] = content
            element.content = f'<div style="padding:6px 10px">{content}</div>'

    # ---- the person

    def _play(self) -> None:
        with self._gui.add_folder("You are the person"):
            self._gui.add_markdown(
                "Drag the blue ring, or click the floor, to walk there. Keys are in brackets."
            )
            groups: dict[str, list[tuple[str, Wish]]] = {}
            for group, label, key, wish in _wishes(self._session):
                groups.setdefault(group, []).append((f"{label} [{key}]", wish))
                self._key(label, key, self._do(wish))
            for group, entries in groups.items():
                self._buttons(group, entries)
            smile = self._gui.add_checkbox("Smile [M]", False)

            @smile.on_update
            def _(_: Any) -> None:
                on = smile.value
                self._session.post(lambda: self._with_player(lambda p: p.smile(on)))

            def toggle() -> None:
                smile.value = not smile.value  # type: ignore[misc]

            self._key("Smile", "M", toggle)
            keys = self._gui.add_dropdown(
                "Gestures", ("read off the body", "told by the buttons"),
                initial_value=_gestures(self._session.choices.keys),
            )  # fmt: skip

            @keys.on_update
            def _(_: Any) -> None:
                told = keys.value == _gestures(True)
                self._session.post(lambda: self._tell(told))

    def _tell(self, told: bool) -> None:
        self._session.choices = replace(self._session.choices, keys=told)
        self._with_player(lambda p: setattr(p, "keys", told))

    def _buttons(self, label: str, entries: Sequence[tuple[str, Wish]]) -> None:
        group = self._gui.add_button_group(label, [name for name, _ in entries])
        by_name = {name: self._do(wish) for name, wish in entries}

        @group.on_click
        def _(_: Any) -> None:
            by_name[group.value]()

    def _do(self, wish: Wish) -> Callable[[], None]:
        return lambda: self._session.post(lambda: self._with_player(wish))

    def _with_player(self, wish: Wish) -> None:
        player = self._session.player
        if player is not None:
            if self._session.paused:
                self._session.resume()
            wish(player)

    def _key(self, label: str, key: Any, do: Callable[[], None]) -> None:
        command = self._gui.add_command(label, hotkey=key)
        command.on_trigger(lambda _: do())

    # ---- time

    def _time(self) -> None:
        session, post = self._session, self._session.post
        with self._gui.add_folder("Time"):
            self._pause = self._gui.add_button("Pause [space]")
            self._slider = self._gui.add_slider("Look back", 0.0, 1.0, 0.1, 0.0)
            speed = self._gui.add_dropdown("Speed", [f"{s:g}×" for s in SPEEDS], initial_value="1×")
            restart = self._gui.add_button("Start anew [N]")
            save = self._gui.add_button("Save the replay as a page")

        def pause() -> None:
            if session.paused:
                session.resume()
            else:
                session.pause()

        self._pause.on_click(lambda _: post(pause))
        self._key("Pause", "space", lambda: post(pause))
        restart.on_click(lambda _: post(session.restart))
        self._key("Start anew", "N", lambda: post(session.restart))

        @speed.on_update
        def _(_: Any) -> None:
            chosen = float(speed.value.rstrip("×"))
            post(lambda: session.hurry(chosen))

        @self._slider.on_update
        def _(_: Any) -> None:
            if not self._setting:
                t = self._slider.value
                post(lambda: session.look_back(t))

        @save.on_click
        def _(event: viser.GuiEvent[Any]) -> None:
            client = event.client
            if client is not None:
                post(lambda: client.send_file_download("encounter.html", self._save().encode()))

    def _draw_time(self, t: float) -> None:
        session = self._session
        first, last = session.stage.snapshots[0].t, max(session.stage.now, 0.2)
        label = "Pause [space]" if not session.paused else "Go on [space]"
        if session.paused and session.stage.over:
            label = "Play again [space]"
        if self._pause.label != label:
            self._pause.label = label
        if abs(self._slider.max - last) > 0.45 or abs(self._slider.value - t) > 0.45:
            self._setting = True
            try:
                self._slider.min, self._slider.max = round(first, 1), round(last, 1)
                self._slider.value = round(min(max(t, first), last), 1)  # type: ignore[misc]
            finally:
                self._setting = False

    def _views(self) -> None:
        with self._gui.add_folder("Camera"):
            group = self._gui.add_button_group("Look from", VIEWS)

        @group.on_click
        def _(event: viser.GuiEvent[Any]) -> None:
            client, view = event.client, group.value
            if client is not None:
                self._session.post(lambda: self._cameras.choose(client, view, self._session))

    # ---- what the encounter is made of

    def _encounter(self) -> None:
        session = self._session
        choices = session.choices
        with self._gui.add_folder("Encounter"):
            if choices.source.partition(":")[0] == "simulated":
                names = [*SCRIPTS, *TEMPERAMENTS]
                now = choices.source.partition(":")[2] or names[0]
                self._choose("Person", names, now, lambda v: {"source": f"simulated:{v}"})
            models = _with_own(model_names(), choices.model)
            self._choose("Model", models, choices.model, lambda v: {"model": v})
            robots = _with_own(robot_kinds(), choices.robot)
            self._choose("Robot", robots, choices.robot, lambda v: {"robot": v})
            self._trouble = self._gui.add_markdown("", visible=False)

    def _choose(
        self, label: str, names: Sequence[str], now: str, changes: Callable[[str], dict[str, str]]
    ) -> None:
        dropdown = self._gui.add_dropdown(label, list(names), initial_value=now)

        @dropdown.on_update
        def _(_: Any) -> None:
            wanted = changes(dropdown.value)
            self._session.post(lambda: self._restart(wanted))

    def _restart(self, changes: dict[str, str]) -> None:
        self._session.restart(**changes)
        trouble = self._session.trouble
        self._trouble.content = trouble
        self._trouble.visible = bool(trouble)


def _gestures(keys: bool) -> str:
    return "told by the buttons" if keys else "read off the body"


def _with_own(names: Any, own: str) -> list[str]:
    """The names there are, and a file of the user's own."""
    listed = list(names)
    return listed if own in listed else [*listed, own]
