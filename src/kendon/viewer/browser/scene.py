"""The encounter in three dimensions: both bodies, where they look, where they walked, how near."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh
import viser

from kendon.features.gaze import CONE_ANGLE
from kendon.person import FloatArray
from kendon.phases import Phase
from kendon.viewer.browser.forms import COLUMNS, Color, Float32Array, Pieces, hex_rgb
from kendon.viewer.browser.person_form import draw_person
from kendon.viewer.browser.stage import Shown, Snapshot, Stage

#: Hall's (1966) distances around the robot [m].
RINGS: tuple[tuple[str, float], ...] = (("intimate", 0.45), ("personal", 1.2), ("social", 3.6))
_RING_COLOR: Color = (120, 130, 140)
_ROBOT_PATH: Color = (60, 60, 60)
_PERSON_CONE, _ROBOT_CONE = (230, 159, 0), (26, 135, 140)
#: How long the cones of gaze are [m].
_CONE = 1.3
#: How much of the paths is drawn, and at what spacing [s].
_PATH, _STEP = 60.0, 0.3
#: How often paths and labels are drawn anew [ticks].
_SELDOM = 3


class Scene:
    """Draws one instant after the other on a viser server.

    Args:
        server: the server.
        handle: whether there is a disc on the floor that sends the person places.
    """

    def __init__(self, server: viser.ViserServer, handle: bool = False) -> None:
        self._api = server.scene
        self._api.set_up_direction("+z")
        self._api.world_axes.visible = False
        # Shadows and reflections cost machines without a graphics card most of their time.
        self._api.configure_default_lights(enabled=False)
        self._api.configure_environment_map(hdri=None)
        self._api.add_light_hemisphere(
            "/sky", sky_color=(255, 255, 255), ground_color=(200, 195, 190), intensity=2.2
        )
        self._api.add_light_directional("/sun", intensity=1.6, position=(-3.0, -6.0, 8.0))
        self._api.add_grid(
            "/floor", 60.0, 60.0, cell_size=0.5, section_size=1.0, cell_color=(232, 232, 232),
            section_color=(214, 214, 214), plane_color=(250, 249, 246), plane_opacity=1.0,
            shadow_opacity=0.2, position=(0.0, 0.0, -0.005),
        )  # fmt: skip
        self._rings()
        self._batches: dict[str, tuple[viser.BatchedMeshHandle, list[Color]]] = {}
        self._last: dict[str, Float32Array] = {}
        self._units = {
            "balls": trimesh.creation.icosphere(subdivisions=2, radius=1.0),
            "rods": trimesh.creation.cylinder(radius=1.0, height=1.0, sections=14),
        }
        self._cones = {
            "person": self._cone("/person_gaze", _PERSON_CONE),
            "robot": self._cone("/robot_gaze", _ROBOT_CONE),
        }
        self._labels = {
            name: self._api.add_label(f"/{name}_label", name, anchor="bottom-center")
            for name in ("person", "robot")
        }
        self._paths: dict[str, Any] = {}
        self.disc = self._disc() if handle else None
        self._drawn_at = math.nan  # [s], when the paths were
        self._stage: Stage | None = None

    def draw(self, stage: Stage, shown: Shown, place: int) -> None:
        """Draw an instant.

        Args:
            stage: the encounter.
            shown: the instant.
            place: of its snapshot, up to which the paths are drawn.
        """
        pieces, face, look = stage.form.draw(shown.robot)
        self._body("robot", pieces)
        self._aim("robot", face, look)
        self._ring_frame.position = (float(shown.robot[0]), float(shown.robot[1]), 0.0)
        self._person(shown)
        self._write(shown, face)
        due = place % _SELDOM == 0 and shown.snapshot.t != self._drawn_at
        if due or self._stage is not stage:
            self._drawn_at, self._stage = shown.snapshot.t, stage
            self._draw_paths(stage, place)

    def point_out(self, place: Sequence[float]) -> None:
        """Put the disc where the user's person is going [m]."""
        if self.disc is not None:
            self.disc.position = (float(place[0]), float(place[1]), 0.01)

    # ---- the bodies

    def _person(self, shown: Shown) -> None:
        row = shown.person
        there = row is not None
        for name in ("person_balls", "person_rods"):
            if name in self._batches:
                self._batches[name][0].visible = there
        self._cones["person"].visible = row is not None and bool(np.isfinite(row[:7]).all())
        self._labels["person"].visible = there
        if row is None:
            return
        self._body("person", draw_person(row))
        if np.isfinite(row[:7]).all():
            x, y, z, qx, qy, qz, qw = row[:7].astype(float).tolist()
            self._aim("person", (x, y, z), (qw, qx, qy, qz))

    def _body(self, name: str, pieces: Pieces) -> None:
        balls, rods = pieces.arrays()
        self._batch(f"{name}_balls", "balls", balls, pieces.ball_colors)
        self._batch(f"{name}_rods", "rods", rods, pieces.rod_colors)

    def _batch(self, name: str, unit: str, rows: Float32Array, colors: list[Color]) -> None:
        assert rows.shape[1] == COLUMNS
        # A millimetre is fine enough, and rounded numbers make a smaller recording.
        rows = np.round(rows, 3)
        if name in self._last and np.array_equal(self._last[name], rows):
            return
        self._last[name] = rows
        places, turns, sizes = rows[:, :3], rows[:, 3:7], rows[:, 7:]
        old = self._batches.get(name)
        if old is not None and old[1] == colors:
            mesh = old[0]
            mesh.batched_positions, mesh.batched_wxyzs = places, turns
            mesh.batched_scales = sizes
            return
        shape = self._units[unit]
        mesh = self._api.add_batched_meshes_simple(
            f"/{name}", np.asarray(shape.vertices), np.asarray(shape.faces), turns, places,
            batched_scales=sizes, batched_colors=np.array(colors, dtype=np.uint8), lod="off",
        )  # fmt: skip
        self._batches[name] = mesh, list(colors)

    # ---- gaze, distance, way

    def _cone(self, name: str, color: Color) -> viser.MeshHandle:
        """The cone of visual attention (thesis 3.3.3), its tip at the face."""
        turns = np.linspace(0, 2 * math.pi, 33)[:-1]
        radius = _CONE * math.tan(CONE_ANGLE / 2)
        rim = np.stack([np.full(32, _CONE), radius * np.cos(turns), radius * np.sin(turns)], axis=1)
        around = np.arange(32)
        faces = np.stack([np.zeros(32, dtype=int), around + 1, (around + 1) % 32 + 1], axis=1)
        return self._api.add_mesh_simple(
            name, np.vstack([np.zeros((1, 3)), rim]), faces, color=color, opacity=0.16,
            side="double", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _aim(self, name: str, face: Sequence[float], look: Sequence[float]) -> None:
        self._cones[name].position = (face[0], face[1], face[2])
        self._cones[name].wxyz = (look[0], look[1], look[2], look[3])

    def _rings(self) -> None:
        self._ring_frame = self._api.add_frame("/rings", show_axes=False)
        for name, radius in RINGS:
            turns = np.linspace(0, 2 * math.pi, 97)
            circle = np.stack([radius * np.cos(turns), radius * np.sin(turns)], axis=1)
            points = np.column_stack([circle, np.full(97, 0.006)])
            self._api.add_line_segments(
                f"/rings/{name}", np.stack([points[:-1], points[1:]], axis=1),
                colors=_RING_COLOR, thickness=1.5, thickness_units="screen",
            )  # fmt: skip
            if radius > 1:
                self._api.add_label(
                    f"/rings/{name}_label", f"{name} {radius:g} m", anchor="center-center",
                    position=(0.0, -radius, 0.02), font_screen_scale=0.8,
                )  # fmt: skip

    def _disc(self) -> viser.MeshHandle:
        """What the user drags over the floor to send the person somewhere."""
        turns = np.linspace(0, 2 * math.pi, 49)[:-1]
        rim = np.stack([np.cos(turns), np.sin(turns), np.zeros(48)], axis=1)
        around = np.arange(48)
        after = (around + 1) % 48
        inner, outer = rim * 0.16, rim * 0.34
        faces = np.vstack(
            [np.stack([around, around + 48, after], axis=1),
             np.stack([after, around + 48, after + 48], axis=1)]
        )  # fmt: skip
        return self._api.add_mesh_simple(
            "/goal", np.vstack([inner, outer]), faces, color=(0, 114, 178), opacity=0.8,
            side="double", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _draw_paths(self, stage: Stage, place: int) -> None:
        every = max(1, round(_STEP * 10))
        first = max(0, place - round(_PATH * 10))
        first -= first % every  # so that the corners stay where they are
        way = [stage.snapshots[i] for i in range(first, place + 1, every)]
        person = [(s.ground, s.phase) for s in way]
        self._path("person", *person_segments(person))
        robot = np.array([[s.pose.x, s.pose.y, 0.012] for s in way]).reshape(-1, 3)
        lines = np.stack([robot[:-1], robot[1:]], axis=1)
        self._path("robot", lines, np.full((len(lines), 2, 3), _ROBOT_PATH, dtype=np.uint8))

    def _path(self, name: str, lines: FloatArray, colors: Any) -> None:
        if not len(lines):  # viser draws no empty lines
            lines, colors = np.zeros((1, 2, 3)), np.zeros((1, 2, 3), dtype=np.uint8)
        if name in self._paths:
            path = self._paths[name]
            path.points, path.colors = lines.astype(np.float32), colors
        else:
            self._paths[name] = self._api.add_line_segments(
                f"/{name}_path",
                lines.astype(np.float32),
                colors=colors,
                thickness=4.0,
                thickness_units="screen",
            )

    # ---- words

    def _write(self, shown: Shown, face: Sequence[float]) -> None:
        snapshot = shown.snapshot
        phase = snapshot.phase
        self._set_label("person", phase.title if phase else "the person")
        if shown.person is not None:
            x, y, z = shown.person[:3].astype(float).tolist()
            self._labels["person"].position = (x, y, (1.6 if math.isnan(z) else z) + 0.4)
        self._set_label("robot", robot_words(snapshot))
        self._labels["robot"].position = (face[0], face[1], face[2] + 0.35)

    def _set_label(self, name: str, text: str) -> None:
        if self._labels[name].text != text:
            self._labels[name].text = text


def robot_words(snapshot: Snapshot) -> str:
    """What the label over the robot says."""
    return f"“{snapshot.saying}”" if snapshot.saying else f"the robot {snapshot.doing}"


def person_segments(
    way: Sequence[tuple[tuple[float, float] | None, Phase | None]],
) -> tuple[FloatArray, Any]:
    """A person's way as lines (N, 2, 3) [m] in the colours of the phases (N, 2, 3)."""
    lines, colors = [], []
    for (a, _), (b, phase) in itertools.pairwise(way):
        if a is not None and b is not None:
            lines.append(((*a, 0.012), (*b, 0.012)))
            colors.append([hex_rgb(phase.color if phase else "#777777")] * 2)
    return (
        np.array(lines, dtype=float).reshape(-1, 2, 3),
        np.array(colors, dtype=np.uint8).reshape(-1, 2, 3),
    )
