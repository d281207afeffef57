"""Distance and speed of a person (thesis 3.3.1-3.3.2)."""

from __future__ import annotations

import numpy as np

from kendon.person import FloatArray


def distance(head: FloatArray) -> FloatArray:
    """Ground-plane distance between the robot's base and the face (thesis 3.1) [m].

    Args:
        head: faces in ``base_footprint``, shape (..., 3) [m].

    Returns:
        Shape (...).
    """
    return np.asarray(np.hypot(head[..., 0], head[..., 1]))


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
    before: FloatArray, now: FloatArray, robot_before: FloatArray, dt: FloatArray
) -> FloatArray:
    """How fast the person came nearer to where the robot was (thesis 3.2-3.3) [m/s].

    Both distances are taken to the robot's **previous** position, so that the robot's own
    motion does not show up as the person's speed.

    Args:
        before: the person in the world at t - dt, shape (..., 2) [m].
        now: the person in the world at t, shape (..., 2) [m].
        robot_before: the robot in the world at t - dt, shape (..., 2) [m].
        dt: the time between the two, shape (...) [s].

    Returns:
        Shape (...); positive when coming closer.
    """
    was, is_now = before - robot_before, now - robot_before
    way = np.hypot(was[..., 0], was[..., 1]) - np.hypot(is_now[..., 0], is_now[..., 1])
    return np.asarray(way / dt)
