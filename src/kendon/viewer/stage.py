"""A lit stage on which MuJoCo draws a robot and a person, without a window.

On Linux, MuJoCo draws through EGL or OSMesa, whichever is installed; the environment variable
MUJOCO_GL names one of them where the choice matters.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import importlib
import math
import os
import sys
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from kendon.errors import RendererError
from kendon.geometry import Pose2D
from kendon.person import FloatArray
from kendon.robots.mujoco.description import RobotDescription
from kendon.robots.mujoco.model import read_model
from kendon.viewer.mannequin import Color, Shape

Image = NDArray[np.uint8]

#: Hall's (1966) zones around the robot, outermost first: how far they reach [m], and the colours
#: of their ground and rim.
_ZONES: tuple[tuple[float, Color, Color], ...] = (
    (3.6, (0.83, 0.87, 0.88, 1), (0.62, 0.71, 0.75, 1)),
    (1.2, (0.75, 0.83, 0.85, 1), (0.48, 0.62, 0.68, 1)),
)
_FLOOR: Color = (0.89, 0.88, 0.86, 1)
_RIM = 0.025  # [m], how wide a zone's rim is
_SHEET = 0.002  # [m], how thick each layer of colour on the floor is
_SKY_TOP, _SKY_LOW = (0.73, 0.80, 0.87), (0.94, 0.95, 0.96)
_LIGHT_AWAY = 6.0  # [m], from what is looked at to the lamp
#: The most shapes a person and the zones need.
_MOST_SHAPES = 200
_PACKAGES = "on Debian: apt-get install libegl1 libopengl0 libgl1-mesa-dri, or libosmesa6"


class Stage:
    """Draws a robot as it stands, with a person and the floor, into images.

    Args:
        description: the robot.
        width: of the images [pixels].
        height: likewise.

    Raises:
        RendererError: nothing that MuJoCo can draw with is installed.
        DataError: the robot's model cannot be read.
    """

    def __init__(self, description: RobotDescription, width: int, height: int) -> None:
        spec, _ = read_model(description)
        spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
        self._dress(spec)
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        self._context = gl_context(width, height)
        self._context.make_current()
        self._render = mujoco.MjrContext(self.model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._render)
        self._scene = mujoco.MjvScene(self.model, maxgeom=self.model.ngeom + _MOST_SHAPES)
        self._option, self._camera = mujoco.MjvOption(), mujoco.MjvCamera()
        self._size = width, height

    def pose(self, positions: FloatArray) -> None:
        """Bring the robot into a state.

        Args:
            positions: of all joints, as its body has them (`MujocoRobot.history`).
        """
        self.data.qpos[:] = positions
        mujoco.mj_forward(self.model, self.data)

    def draw(
        self,
        look_at: Sequence[float],
        distance: float,
        azimuth: float,
        elevation: float,
        person: Sequence[Shape] = (),
        zones: Pose2D | None = None,
        size: tuple[int, int] | None = None,
    ) -> Image:
        """The stage seen by a camera, (height, width, 3).

        Args:
            look_at: the point in the middle of the image [m].
            distance: from the camera to it [m].
            azimuth: the direction the camera looks in, over the floor [rad].
            elevation: how far it looks up [rad].
            person: what to draw beside the robot.
            zones: around whom to draw Hall's zones; nobody where it is left out.
            size: width and height of the image, if it is to be smaller than the stage's [pixels].
        """
        width, height = size or self._size
        camera = self._camera
        camera.lookat[:] = look_at
        camera.distance = distance
        camera.azimuth, camera.elevation = math.degrees(azimuth), math.degrees(elevation)
        self._context.make_current()
        mujoco.mjv_updateScene(
            self.model, self.data, self._option, None, camera,
            mujoco.mjtCatBit.mjCAT_ALL.value, self._scene,
        )  # fmt: skip
        for light in self._scene.lights[: self._scene.nlight]:
            if light.castshadow:  # it shines on what is looked at, wherever that is
                light.pos[:] = np.asarray(look_at) - _LIGHT_AWAY * np.asarray(light.dir)
        if zones is not None:
            self._add_zones(zones)
        for shape in person:
            self._add(shape)
        viewport = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(viewport, self._scene, self._render)
        image: Image = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(image, None, viewport, self._render)
        return np.flipud(image)

    def close(self) -> None:
        """Give the graphics memory back."""
        self._render.free()
        self._context.free()

    def _add(self, shape: Shape) -> None:
        ball = bool(np.allclose(shape.start, shape.end))
        kind = mujoco.mjtGeom.mjGEOM_SPHERE if ball else mujoco.mjtGeom.mjGEOM_CAPSULE
        size = np.full(3, shape.radius)
        geom = self._new(kind, size, shape.start, shape.color)
        if geom is not None and not ball:
            mujoco.mjv_connector(geom, kind, shape.radius, shape.start, shape.end)

    def _add_zones(self, around: Pose2D) -> None:
        disc = mujoco.mjtGeom.mjGEOM_CYLINDER
        for layer, (reach, ground, rim) in enumerate(_ZONES):
            for step, (radius, color) in enumerate(((reach + _RIM, rim), (reach, ground))):
                height = (2 * layer + step + 1) * _SHEET / 2
                size = np.array([radius, height, 0.0])
                geom = self._new(disc, size, np.array([around.x, around.y, height]), color)
                if geom is not None:
                    geom.specular = 0.0

    def _new(self, kind: Any, size: FloatArray, place: FloatArray, color: Color) -> Any:
        """One more shape in the scene, or None when it is full."""
        scene = self._scene
        if scene.ngeom >= scene.maxgeom:
            return None
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(
            geom, kind, size, np.asarray(place, dtype=float), np.eye(3).ravel(),
            np.array(color, dtype=np.float32),
        )  # fmt: skip
        geom.category = mujoco.mjtCatBit.mjCAT_DYNAMIC  # decorations would cast no shadow
        geom.specular, geom.shininess = 0.15, 0.3
        scene.ngeom += 1
        return geom

    @staticmethod
    def _dress(spec: Any) -> None:
        """Give the robot's world a floor, a sky and light."""
        visual, world = spec.visual, spec.worldbody
        visual.quality.shadowsize, visual.quality.offsamples = 4096, 4
        visual.quality.numslices = 32
        visual.headlight.ambient = [0.42, 0.42, 0.42]
        visual.headlight.diffuse = [0.28, 0.28, 0.28]
        visual.headlight.specular = [0.0, 0.0, 0.0]
        visual.map.znear, visual.map.zfar = 0.02, 60.0
        visual.map.shadowclip = 1.8
        visual.rgba.haze = [*_SKY_LOW, 1]
        visual.map.fogstart, visual.map.fogend = 12.0, 40.0
        spec.stat.extent, spec.stat.center = 5.0, [0, 0, 0.6]
        spec.add_texture(
            name="kendon_sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, rgb1=_SKY_TOP, rgb2=_SKY_LOW,
            width=256, height=1536,
        )  # fmt: skip
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        spec.add_material(name="kendon_floor", rgba=_FLOOR, specular=0.0)
        world.add_geom(type=plane, size=[40, 40, 0.1], material="kendon_floor")
        world.add_light(
            pos=[2, -4, 7], dir=[-0.3, 0.5, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            castshadow=True, diffuse=[0.56, 0.55, 0.52], specular=[0.25, 0.25, 0.25],
        )  # fmt: skip


def require_renderer() -> None:
    """Make sure that pictures can be drawn; asked before an encounter rather than after it.

    Raises:
        RendererError: they cannot; the message says what to install.
    """
    gl_context(16, 16).free()


def gl_context(width: int, height: int) -> Any:
    """A place to draw on that needs no screen.

    Raises:
        RendererError: there is none; the message says what to install.
    """
    if not sys.platform.startswith("linux"):
        return mujoco.GLContext(width, height)
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    backends = {"egl": "EGL", "osmesa": "OSMesa"}
    if wanted in backends:
        found = [wanted]
    else:
        found = [name for name, library in backends.items() if ctypes.util.find_library(library)]
    if not found:
        raise RendererError(f"drawing needs EGL or OSMesa, and neither is installed; {_PACKAGES}")
    try:
        return importlib.import_module(f"mujoco.{found[0]}").GLContext(width, height)
    except (
        ImportError, RuntimeError, AttributeError, OSError,
        ctypes.ArgumentError,  # what PyOpenGL says when EGL is there without OpenGL
    ) as error:  # fmt: skip
        why = " ".join(str(error).split()) or type(error).__name__
        raise RendererError(
            f"{backends[found[0]]} is there but does not draw ({why}); {_PACKAGES},"
            " and MUJOCO_GL=egl or osmesa chooses one"
        ) from None
