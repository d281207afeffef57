from __future__ import annotations

import math

import numpy as np

from kendon.geometry import Pose2D
from kendon.greeter import Greeter
from kendon.ros.markers import ZONES, ShapeType, shapes
from kendon.sources import open_source


def test_everything_known_is_shown_and_nothing_else() -> None:
    greeter = Greeter(open_source("simulated:normal"))
    seen: set[str] = set()
    for moment in greeter.run():
        drawn = list(shapes(moment, greeter.robot))
        names = {shape.name for shape in drawn}
        seen |= names
        assert ("person" in names) == (moment.person is not None)
        assert len({(s.name, s.number) for s in drawn}) == len(drawn)
        for shape in drawn:
            if shape.name == "goal":
                assert shape.in_world
            if shape.type is ShapeType.TRIANGLES:  # a cone of 60 degrees about x
                rim = np.array(shape.points).reshape(-1, 3, 3)[:, 1]
                angles = np.arctan2(np.hypot(rim[:, 1], rim[:, 2]), rim[:, 0])
                np.testing.assert_allclose(angles, math.radians(30))
    assert seen == {"zones", "person", "gaze", "phase", "goal"}


def test_zones_are_circles_about_the_robot() -> None:
    greeter = Greeter(open_source("simulated:normal"))
    moment = next(greeter.run())
    circles = [shape for shape in shapes(moment, greeter.robot) if shape.name == "zones"]
    for radius, circle in zip(ZONES, circles, strict=True):
        distances = np.hypot(*np.array(circle.points)[:, :2].T)
        np.testing.assert_allclose(distances, radius)
    assert Pose2D(0, 0, 0) == moment.robot
