"""The six experiments of the thesis (3.6.4, tables 3.7 and 3.8), and six of ours.

What the thesis tells is set as it tells it: the start, the distance after which somebody salutes,
where they stop, the constant gaze and smile, the number of labels. It leaves open how fast they
walk, how long they sight, salute and dip, where the final approach begins and where the third
experiment starts and salutes. `ASSUMED` says what stands here instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from kendon.geometry import ORIGIN, Pose2D
from kendon.person import FloatArray, PersonFrame, Track
from kendon.phases import Phase
from kendon.simulation.actor import Actor
from kendon.simulation.deeds import Deed, Gesture, Look, Turn, WalkTo
from kendon.simulation.person import SimulatedPerson
from kendon.simulation.scripts import WALKING_SPEED, Act, Script
from kendon.simulation.sensors import SENSORS, Sensor

ASSUMED = (
    "They walk at 1.2 m/s, a medium-to-slow walk (3.4): with it the labels of the second and"
    " fourth experiments come to just what table 3.8 counts.",
    "They sight the robot for 0.6 s (3.4 takes 0.5 s; labels come every 0.2 s), and the close"
    " salutation lasts as long as table 3.8 has labels for.",
    "A distance salutation is a wave of 1.2 s, which arms need to be plainly seen to stroke once,"
    " and a head dip takes 0.4 s, both while walking.",
    "The final approach begins 3 m from the robot (2.1.5), or after the head dip if that is later.",
    "The third experiment starts 5 m away, and its wave begins at 2.6 m.",
    "The person sights the robot in a fourth experiment with no approach before the final one, as"
    " table 3.7 has it.",
)
#: Frames a second; Algorithm 2 sets ten, cameras more.
_RATE = 30.0
_SIGHTING, _WAVE, _DIP = 0.6, 1.2, 0.4


@dataclass(frozen=True)
class Scene:
    """One experiment: who does what, before which robot, seen through what."""

    number: int
    title: str
    play: Callable[[bool, int], Track]  # with keys? whose body? -> the person with true phases
    labels: int = 0  # in the thesis; 0 = it is ours
    correct: int = 0  # of them, in the thesis
    sensor: Sensor | None = None
    lost: tuple[float, float] | None = None  # [s], nobody is seen in between

    def record(self, *, keys: bool, seed: int) -> Track:
        """The person as the sensor sees them, with true phases (0 = not greeting)."""
        track = self.play(keys, seed)
        if self.lost:
            track = _hide(track, *self.lost)
        if self.sensor:
            track = self.sensor.see(track, np.random.default_rng([self.number, seed]))
        return track


def _greeting(
    start: float, labels: int, between: tuple[Act, ...], gaze: float = 1.0, smile: float = 1.5
) -> Script:
    """Sighting, what is between, and a close salutation that makes up the number of labels."""
    walk = (start - 1.0) / WALKING_SPEED
    closing = max(0.2, labels * 0.2 - _SIGHTING - walk)
    acts = (Act(Phase.IA, seconds=_SIGHTING), *between, Act(Phase.CS, seconds=closing))
    return Script(start, tuple(replace(act, gaze=gaze, smile=smile) for act in acts))


def _walk(phase: Phase, until: float) -> Act:
    return Act(phase, until_distance=until, walking=True)


_DS = Act(Phase.DS, seconds=_WAVE, walking=True)
_HD = Act(Phase.HD, seconds=_DIP, walking=True)
_EVERY = (_walk(Phase.APP, 4.0), _DS, _HD, _walk(Phase.FA, 1.0))
_PLAIN = (_walk(Phase.APP, 3.0), _walk(Phase.FA, 1.0))
_CLOSE_WAVE = (_walk(Phase.APP, 3.0), _walk(Phase.FA, 2.6), _DS, _walk(Phase.FA, 1.0))
# Cut short by the arrival.
_LATE_WAVE = (
    _walk(Phase.APP, 3.0), _walk(Phase.FA, 1.9), Act(Phase.DS, until_distance=1.0, walking=True),
)  # fmt: skip


def _still(_: float) -> Pose2D:
    return ORIGIN


@dataclass(frozen=True)
class _Scripted:
    """A script played before a robot whose pose is a function of time."""

    script: Script
    robot: Callable[[float], Pose2D] = _still

    def __call__(self, keys: bool, seed: int) -> Track:
        person = SimulatedPerson(self.script, _RATE, keys=keys, seed=seed)
        frames, phases = [], []
        while not person.finished:
            pose = self.robot(person.t)
            frames.append(person.frame(pose))
            phases.append(int(person.phase))
            person.step(pose)
        frames.append(person.frame(self.robot(person.t)))  # which ends the last interval
        phases.append(phases[-1])
        return _track(frames, phases)


@dataclass(frozen=True)
class _Told:
    """A body that is told what to do at which times, and does it with real accelerations."""

    start: Pose2D
    deeds: tuple[tuple[float, Deed], ...]
    seconds: float

    def __call__(self, keys: bool, seed: int) -> Track:
        actor = Actor(self.start, rate=_RATE, seed=seed)
        waiting = list(self.deeds)
        frames: list[PersonFrame] = []
        phases: list[int] = []
        while actor.t < self.seconds:
            while waiting and waiting[0][0] <= actor.t:
                actor.act(waiting.pop(0)[1])
            frames += actor.frames(1)
            phases.append(int(actor.phase(ORIGIN) or 0))
        track = _track(frames, phases)
        return track.with_gestures_from_phases() if keys else track


def _track(frames: list[PersonFrame], phases: list[int]) -> Track:
    return replace(Track.from_frames(frames), phases=np.array(phases, dtype=np.int64))


def _hide(track: Track, begin: float, end: float) -> Track:
    hidden = (track.t >= begin) & (track.t < end)

    def without(values: FloatArray) -> FloatArray:
        values = values.copy()
        values[hidden] = np.nan
        return values

    return replace(
        track,
        head=without(track.head),
        head_rotation=without(track.head_rotation),
        smile=without(track.smile),
        joints={name: without(places) for name, places in track.joints.items()},
    )


def _driving(t: float) -> Pose2D:
    """A robot that sets off after 1.4 s and drives 1.2 m at 0.5 m/s."""
    return Pose2D(min(1.2, max(0.0, 0.5 * (t - 1.4))), 0.0, 0.0)


_FACE = (0.0, 0.0, 1.2)

THESIS: tuple[Scene, ...] = (
    Scene(1, "Normal greeting with every state", _Scripted(_greeting(5.5, 25, _EVERY)), 25, 24),
    Scene(2, "Greeting without DS or HD", _Scripted(_greeting(6.0, 27, _PLAIN)), 27, 24),
    Scene(3, "Greeting with DS only close to person",
          _Scripted(_greeting(5.0, 23, _CLOSE_WAVE)), 23, 23),
    Scene(4, "Greeting starting at short distance",
          _Scripted(_greeting(2.0, 10, (_walk(Phase.FA, 1.0),))), 10, 10),
    Scene(5, "Smiling greeting (smile = 2.5)",
          _Scripted(_greeting(5.5, 32, _EVERY, smile=2.5)), 32, 32),
    Scene(6, "Gazing greeting (gaze = 0.4)",
          _Scripted(_greeting(5.5, 30, _EVERY, gaze=0.4)), 30, 22),
)  # fmt: skip

OURS: tuple[Scene, ...] = (
    Scene(7, "A wave at 1.9 m, just before the handshake",
          _Scripted(_greeting(5.0, 27, _LATE_WAVE))),
    Scene(8, "Turns away at 3.5 m and leaves", _Told(
        Pose2D(6.0, 0.0, math.pi),
        ((0.0, Look(_FACE)), (0.8, WalkTo(3.5, 0.0)), (3.6, Look()), (3.6, Turn(0.6)),
         (4.0, WalkTo(7.0, 2.0))), 7.0)),
    Scene(9, "The robot drives toward them, too",
          _Scripted(_greeting(7.0, 32, _EVERY), _driving)),
    Scene(10, "The first one through a noisy sensor",
          _Scripted(_greeting(5.5, 25, _EVERY)), sensor=SENSORS["noisy"]),
    Scene(11, "The first one, with the face lost for 1 s",
          _Scripted(_greeting(5.5, 25, _EVERY)), lost=(1.2, 2.2)),
    Scene(12, "Walks past at 1.5 m with a telephone", _Told(
        Pose2D(1.5, -4.0, math.pi / 2),
        ((0.0, WalkTo(1.5, 4.0)), (2.0, Gesture("text"))), 6.0)),
)  # fmt: skip
SCENES = (*THESIS, *OURS)
