"""Distance and speed of a person (thesis 3.3.1-3.3.2)."""

from __future__ import annotations

import math

import numpy as np

from kendon.person import FloatArray


def distance(head: FloatArray) -> FloatArray:
    """Ground-plane distance between the robot's base and the face (thesis 3.1) [m].

    Written out rather than with `np.hypot`, which rounds differently from plain numbers.

    Args:
        head: faces in ``base_footprint``, shape (..., 3) [m].

    Returns:
        Shape (...).
    """
    x, y = head[..., 0], head[..., 1]
    return np.asarray(np.sqrt(x * x + y * y))


def to_world(head: FloatArray, robot: FloatArray) -> FloatArray:
    """Where faces stand on the ground of the world, shape (..., 2) [m].

    Args:
        head: faces in ``base_footprint``, shape (..., 3) [m].
        robot: the robot's poses x y yaw at those instants, shape (..., 3) [m, m, rad].
    """
    c, s = np.cos(robot[..., 2]), np.sin(robot[..., 2])
    x, y = head[..., 0], head[..., 1]
    return np.stack([robot[..., 0] + c * x - s * y, robot[..., 1] + s * x + c * y], axis=-1)


def closing_speed(
    before: tuple[float, float],
    now: tuple[float, float],
    robot_before: tuple[float, float],
    dt: float,
) -> float:
    """How fast the person came nearer to where the robot was (thesis 3.2-3.3) [m/s].

    Both distances are taken to the robot's **previous** position, so that the robot's own
    motion does not show up as the person's speed.

    Args:
        before: the person on the ground of the world at t - dt [m].
        now: the person there at t [m].
        robot_before: the robot there at t - dt [m].
        dt: the time between the two [s].

    Returns:
        Positive when coming closer.
    """
    return (math.dist(before, robot_before) - math.dist(now, robot_before)) / dt
