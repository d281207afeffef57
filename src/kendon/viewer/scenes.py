"""What pictures of an encounter show at each instant: robot, person, camera, and words.

The flow ticks ten times a second and pictures need more, so that the person is interpolated
between ticks; the robot's own motion is known forty times a second (`MujocoRobot.history`).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from kendon.errors import ParameterError
from kendon.estimate import stretches
from kendon.geometry import ORIGIN, Pose2D, Vec3
from kendon.greeter import Encounter
from kendon.person import JOINTS, FloatArray
from kendon.phases import Phase
from kendon.robots.base import CommandKind
from kendon.robots.mujoco import MujocoRobot
from kendon.viewer.mannequin import Stance

#: How much of the path the person's walk is read off [s], and over how much gestures fade.
_WALK, _FADE = 0.5, 0.5
#: Slower than this a person stands, and at this they stride fully [m/s].
_STANDS, _STRIDES = 0.15, 0.9
#: How often a waving hand goes to and fro [1/s].
_WAVES = 1.4
#: How often highlights are looked for [1/s].
_PACE = 10.0
#: How smoothly the camera follows [s].
_CAMERA = 2.0
#: A gesture is best seen so long after its start [s]: the arm is up and moving.
_AT_ITS_BEST = 1.7


@dataclass(frozen=True, slots=True)
class View:
    """Where a camera is; see `Stage.draw`."""

    look_at: Vec3  # [m]
    distance: float  # [m]
    azimuth: float  # [rad]
    elevation: float  # [rad]


@dataclass(frozen=True, slots=True)
class Instant:
    """One image's content."""

    t: float  # [s]
    positions: FloatArray  # of the robot's joints
    robot: Pose2D
    stance: Stance | None  # of the person; None when out of sight
    phase: Phase | None  # as read
    doing: str  # the robot, in a few words
    saying: str  # what it says, "" when silent
    view: View  # of both
    close_up: View  # of the robot's face


class Scenes:
    """An encounter as a sequence of instants.

    Args:
        encounter: what happened.
        robot: whose `history` was kept meanwhile.

    Raises:
        ParameterError: nothing was kept, or nothing happened.
    """

    def __init__(self, encounter: Encounter, robot: MujocoRobot) -> None:
        if not robot.history or not encounter.moments:
            raise ParameterError("there is nothing to draw: the robot's history is empty")
        self.encounter = encounter
        self.robot = robot
        self._times = [t for t, _ in robot.history]
        self._positions = [q for _, q in robot.history]
        self._ticks = np.array([m.t for m in encounter.moments])
        self._frames = [
            m.person.seen_from(ORIGIN) if m.person is not None else None for m in encounter.moments
        ]

    def film(self, rate: float) -> list[Instant]:
        """Instants at a steady rate [1/s], from the first tick to the last."""
        count = int(self.encounter.duration * rate) + 1
        return self._instants(np.arange(count) / rate)

    def highlights(self) -> list[Instant]:
        """One instant a phase, from its longest visit and at its most telling moment."""
        chosen: dict[Phase, tuple[float, float]] = {}  # how long the visit is, and when to look
        for start, stop, number in stretches(self.encounter.moment_phases):
            begin, end = float(self._ticks[start]), float(self._ticks[stop - 1])
            if not number or end - begin < chosen.get(Phase(number), (-1.0, 0.0))[0]:
                continue
            salutes = [
                # While the person is still at it, whose hand sinks toward the end.
                max(
                    action.start,
                    min(action.start + _AT_ITS_BEST, action.end - 0.1, begin + 0.7 * (end - begin)),
                )
                for action in self.encounter.actions
                if action.command.kind is CommandKind.GESTURE
                and action.command.asked["name"] != "home"
                and begin <= action.start <= end
            ]
            best = salutes[0] if salutes else (begin + end) / 2
            chosen[Phase(number)] = end - begin, best
        # All at the film's own pace, so that what is smoothed over time looks the same.
        film = self.film(_PACE)
        return [
            replace(film[min(len(film) - 1, round(t * _PACE))], phase=phase)
            for phase, (_, t) in sorted(chosen.items(), key=lambda item: item[1][1])
        ]

    def _instants(self, times: FloatArray) -> list[Instant]:
        h = float(times[1] - times[0]) if len(times) > 1 else 1.0
        stances = self._stances(times, h)
        phases = self.encounter.moment_phases
        ticks = np.clip(np.searchsorted(self._ticks, times + 1e-9, side="right") - 1, 0, None)
        states = [self._state(t) for t in times]
        robots = [Pose2D(*q[:3].tolist()) for q in states]
        views = self._views(robots, stances, h)
        made = []
        for i, t in enumerate(times.tolist()):
            number = int(phases[ticks[i]])
            doing, saying = self._words(t)
            made.append(
                Instant(
                    t, states[i], robots[i], stances[i], Phase(number) if number else None,
                    doing, saying, views[i], self._close_up(robots[i]),
                )
            )  # fmt: skip
        return made

    def _state(self, t: float) -> FloatArray:
        return self._positions[max(0, bisect_right(self._times, t + 1e-9) - 1)]

    def _words(self, t: float) -> tuple[str, str]:
        doing, saying = [], ""
        for action, end, _ in self.encounter.stretches:
            if action.start <= t < end:
                if action.command.kind is CommandKind.SAY:
                    saying = action.label
                elif action.channel in ("base", "arms") and action.label != "home":
                    doing.append(action.label)
        shown = [a.label for a in self.encounter.actions if a.channel == "face" and a.start <= t]
        if shown and shown[-1] != "neutral":
            doing.append(shown[-1])
        return ", ".join(doing), saying

    # ---- the person

    def _stances(self, times: FloatArray, h: float) -> list[Stance | None]:
        seen = np.array([frame is not None for frame in self._frames])
        if not seen.any():
            return [None] * len(times)
        known = [frame for frame in self._frames if frame is not None]
        at = self._ticks[seen]

        def over_time(rows: Sequence[Sequence[float]] | FloatArray) -> FloatArray:
            table = np.array(rows, dtype=float)
            return np.stack([np.interp(times, at, column) for column in table.T], axis=1)

        head = over_time([f.head for f in known])
        rotation = over_time(_continuous([f.head_rotation for f in known]))
        rotation /= np.linalg.norm(rotation, axis=1, keepdims=True)
        marks = np.nan_to_num(over_time([(f.smile, f.dsal, f.csal) for f in known]))
        marks[:, 1:] = uniform_filter1d(marks[:, 1:], max(1, round(_FADE / h)), axis=0)
        joints = {
            name: over_time([f.joints.get(name, (math.nan,) * 3) for f in known]) for name in JOINTS
        }
        way = uniform_filter1d(head[:, :2], max(1, round(_WALK / h)), axis=0, mode="nearest")
        steps = np.gradient(way, h, axis=0) if len(way) > 1 else np.zeros_like(way)
        speed = np.linalg.norm(steps, axis=1)
        walked = np.cumsum(speed) * h
        heading = self._headings(times, head, steps, speed, h)
        there = seen[np.clip(np.searchsorted(self._ticks, times), 0, len(seen) - 1)]
        hands, withdrawn = self._hands(times, h)
        marks[:, 2] *= 1 - withdrawn
        return [
            Stance(
                head=_point(head[i]),
                head_rotation=(
                    float(rotation[i, 0]), float(rotation[i, 1]),
                    float(rotation[i, 2]), float(rotation[i, 3]),
                ),
                heading=float(heading[i]),
                joints={n: _point(p[i]) for n, p in joints.items() if np.isfinite(p[i]).all()},
                smile=float(marks[i, 0]),
                walked=float(walked[i]),
                stride=float(np.clip((speed[i] - _STANDS) / (_STRIDES - _STANDS), 0, 1)),
                wave=float(marks[i, 1]),
                swing=math.sin(2 * math.pi * _WAVES * float(times[i])),
                reach=float(marks[i, 2]),
                target=None if hands is None else _point(hands[i]),
            )
            if there[i]
            else None
            for i in range(len(times))
        ]  # fmt: skip

    def _headings(
        self, times: FloatArray, head: FloatArray, steps: FloatArray, speed: FloatArray, h: float
    ) -> FloatArray:
        """Where the body faces: the way it walks; standing, toward the robot (N,) [rad]."""
        robot = np.array([self._state(t)[:2] for t in times])
        toward = robot - head[:, :2]
        toward /= np.linalg.norm(toward, axis=1, keepdims=True) + 1e-9
        walking = np.clip(speed / _STRIDES, 0, 1)[:, None]
        facing = walking * steps / (speed[:, None] + 1e-9) + (1 - walking) * toward
        facing = uniform_filter1d(facing, max(1, round(_WALK / h)), axis=0, mode="nearest")
        angles: FloatArray = np.arctan2(facing[:, 1], facing[:, 0])
        return angles

    def _hands(self, times: FloatArray, h: float) -> tuple[FloatArray | None, FloatArray]:
        """Where the person's hand meets the robot's (N, 3) [m], None if it is never held out.

        And how far the robot has withdrawn it again (N,): the person then does so, too.
        """
        offered = [self._offered(t) for t in times]
        out = np.array([place is not None for place in offered])
        places = np.array([place for place in offered if place is not None])
        if not len(places):
            return None, np.zeros(len(times))
        hands = np.stack([np.interp(times, times[out], column) for column in places.T], axis=1)
        gone = (np.cumsum(out) > 0) & ~out
        return hands, uniform_filter1d(gone.astype(float), max(1, round(_FADE / h)))

    def _offered(self, t: float) -> Vec3 | None:
        """Where the robot's hand is if it is held out [m], else None."""
        body, name = self.robot.body, self.robot.description.hand
        if name is None:
            return None
        body.data.qpos[:] = self._state(t)
        body.settle()
        hand = _point(body.sight(name)[0])
        pose = Pose2D(*body.data.qpos[:3].tolist())
        return hand if pose.to_local(hand)[0] > 0.3 else None

    # ---- the cameras

    def _views(self, robots: list[Pose2D], stances: list[Stance | None], h: float) -> list[View]:
        """From the robot's right, a little ahead of it, with both in the image."""
        places = []
        last = (robots[0].x + 2.0, robots[0].y)
        for robot, stance in zip(robots, stances, strict=True):
            last = (stance.head[0], stance.head[1]) if stance else last
            places.append((robot.x, robot.y, *last))
        smooth = uniform_filter1d(
            np.array(places), max(1, round(_CAMERA / h)), axis=0, mode="nearest"
        )
        views = []
        for rx, ry, px, py in smooth.tolist():
            apart = math.hypot(px - rx, py - ry)
            distance = max(3.1, (apart + 1.3) / 1.2)
            # The middle of the image lies nearer to the person: the close-up needs room there.
            share = 0.5 + 0.13 * distance / max(apart, 0.5)
            views.append(
                View(
                    (rx + share * (px - rx), ry + share * (py - ry), 0.80),
                    distance,
                    math.atan2(py - ry, px - rx) + math.pi / 2 + 0.42,
                    -0.16,
                )
            )
        return views

    def _close_up(self, robot: Pose2D) -> View:
        x, y, z = robot.to_world((0.03, 0.0, self.robot.face[2] - 0.02))
        return View((x, y, z), 0.78, robot.yaw + math.pi + 0.35, -0.05)


def _continuous(rotations: Sequence[Sequence[float]]) -> FloatArray:
    """Quaternions with signs chosen so that neighbours are near each other, (N, 4)."""
    q = np.array(rotations, dtype=float)
    flips = np.sign((q[1:] * q[:-1]).sum(axis=1))
    flips[flips == 0] = 1
    q[1:] *= np.cumprod(flips)[:, None]
    return q


def _point(row: FloatArray) -> Vec3:
    x, y, z = row.tolist()
    return (x, y, z)
