"""People who greet, drawn at random: to train models on, and to try them on.

Durations, distances, speeds, orders and odds are those that Kendon and the thesis report (2.1,
3.4, 3.5.2); where they are silent, the numbers are ours and say so. A person comes straight to a
robot that stands still: sights it, perhaps salutes, walks up, stops and salutes again.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from kendon.person import FloatArray, IntArray, Track
from kendon.phases import Phase
from kendon.simulation.embodiment import Salutation, with_body
from kendon.simulation.limbs import clip
from kendon.simulation.motion import look_along
from kendon.simulation.walk import Walk

#: Frames a second.
RATE = 30.0
#: How many people smile whatever they do; ours.
_SMILERS = 0.05
#: In which phases, by their numbers, people smile.
_SMILING = np.isin(np.arange(7), (Phase.DS, Phase.FA, Phase.CS))
#: Where the robot's face is that people look at [m].
_ROBOT_FACE = np.array([0.0, 0.0, 1.2])


@dataclass(frozen=True)
class Greeter:
    """Everything that chance decides about one greeting; times from its beginning [s]."""

    start: float  # [m]
    bearing: float  # [rad], direction in which the person stands at the start
    aside: float  # [m], by which the way misses the robot's centre
    height: float  # [m], of the face
    speed: float  # [m/s]
    acceleration: float  # [m/s^2], setting off
    braking: float  # [m/s^2], coming to a stop
    stop: float  # [m] from the robot
    sighting: float  # how long they stand before they set off; still sighted until under way
    pause_at: float  # [m] from the robot; NaN = they walk through
    pause: float  # how long they hesitate there
    final: float  # [m] from the robot, where the final approach begins
    wave_at: float  # when the distance salutation begins; NaN = there is none
    wave: float  # how long it lasts
    dip_after: float  # from the salutation to the head dip; NaN = there is none
    dip: float  # how long that lasts
    closing: float  # from coming to a stop to the close salutation; a hand may go out before
    close: float  # how long that lasts
    stares: bool  # looks at the robot all the way
    aversion: float  # [rad], how far the look is averted
    downward: bool  # averted to the ground, not to the side
    calm_smile: float  # [0-5], the face between salutations
    smile: float  # [0-5], the face in salutations


def draw_greeter(rng: np.random.Generator) -> Greeter:
    """Draw the facts of one greeting."""
    # Rooms from 2.5 m on, of which the robot takes some, up to those of the thesis's videos (2 to
    # 4 m); larger rooms; and Kendon's garden. Most robots stand in rooms (ours).
    low, high = ((1.6, 4.0), (4.0, 7.0), (7.0, 12.0))[choose(rng, (0.5, 0.27, 0.23))]
    start = float(rng.uniform(low, high))
    stop = clip(rng.normal(1.1, 0.2), 0.6, min(1.6, start - 0.4))
    speed = clip(rng.normal(1.2, 0.2), 0.7, 1.9)  # 3.4: medium to slow
    # Walkers reach their speed at the end of the first step (Breniere and Do 1986), some 0.5 s.
    acceleration = float(speed / rng.uniform(0.3, 0.7))
    # Toward a person they brake over the last steps, as gap closures in general are: gently.
    braking = float(speed / rng.uniform(0.5, 1.8))  # ours
    sighting = clip(rng.gamma(4, 0.2), 0.3, 2.0)  # 3.4: 0.5 s; people hold it longer
    final = float(rng.normal(3.0, 0.1))  # 2.1.5: less than 3 m
    pauses = rng.random() < 0.05 and start > 4.5  # ours: some hesitate on the way
    pause_at = float(rng.uniform(3.5, start - 0.5)) if pauses else math.nan
    pause = float(rng.uniform(0.4, 1.5))

    walk = Walk(start, stop, speed, acceleration, braking, sighting, pause_at, pause)
    arrival, border = walk.arrival, walk.time_at(final)
    # 2.1.2, 3.4: ten in a hundred salute before they set off, twenty in the final approach, the
    # others on the way; in the videos 18 of 33 salute at all (table 3.2).
    wave = clip(rng.lognormal(math.log(1.0), 0.4), 0.3, 2.2)
    wave_at = math.nan
    if rng.random() < 0.6:
        when = choose(rng, (0.1, 0.7, 0.2))
        if when == 0:
            wave_at = sighting * rng.uniform(0.4, 0.9)
        elif when == 1 and border - sighting > 0.8:
            wave_at = rng.uniform(sighting + 0.3, border - 0.2)
        else:
            earliest = max(border, sighting + 0.3)
            wave_at = rng.uniform(earliest, max(earliest, arrival - 0.5))
    # 2.1.3: half of the salutations early in the approach are followed by a dip, late ones never.
    dips = wave_at + wave < border and rng.random() < 0.5
    return Greeter(
        start=start,
        bearing=float(rng.uniform(-1.0, 1.0)),
        aside=float(rng.normal(0, 0.1)),
        height=clip(rng.normal(1.55, 0.1), 1.2, 1.9),
        speed=speed,
        acceleration=acceleration,
        braking=braking,
        stop=stop,
        sighting=sighting,
        pause_at=pause_at,
        pause=pause,
        final=final,
        wave_at=float(wave_at),
        wave=wave,
        dip_after=float(rng.uniform(0.0, 0.3)) if dips else math.nan,
        dip=float(rng.uniform(0.3, 0.9)),  # 3.4: 0.3 s; longer in recordings
        closing=clip(rng.normal(0.1, 0.3), -0.4, 1.0),
        close=float(rng.uniform(1.0, 3.0)),
        stares=bool(rng.random() < 0.35),
        aversion=float(rng.uniform(0.45, 1.0)),
        downward=bool(rng.random() < 0.5),
        # Some smile all the time, as in the thesis's fifth experiment.
        calm_smile=(
            float(rng.uniform(1.5, 4.0))
            if rng.random() < _SMILERS
            else clip(rng.normal(0.9, 0.25), 0.2, 1.6)
        ),
        # 3.4: 8 of 70 do not smile in the final approach.
        smile=clip(rng.normal(2.1, 0.35), 1.0, 4.0) if rng.random() > 8 / 70 else 1.0,
    )


def choose(rng: np.random.Generator, odds: Sequence[float]) -> int:
    """One of the places in a row, as likely as its share of the odds.

    What ``rng.choice(len(odds), p=odds)`` draws, a hundred times as fast.
    """
    sums = list(accumulate(odds))
    return bisect_right([total / sums[-1] for total in sums], rng.random())


def perform(
    greeter: Greeter, rng: np.random.Generator, name: str = "", *, joints: bool = False
) -> Track:
    """The track of a drawn greeting before a robot that stands at the origin, with true phases.

    The gestures are given by hand: the thesis's keys, pressed by the true phases (3.3.5). Or the
    person gets a body (`joints`), moves, and leaves it to detectors to find the gestures.
    """
    g = greeter
    walk = Walk(
        g.start, g.stop, g.speed, g.acceleration, g.braking, g.sighting, g.pause_at, g.pause
    )
    closes = walk.arrival + g.closing
    t = np.arange(0.0, closes + g.close, 1 / RATE)
    way = walk.distance(t)
    phases = _phases(g, t, way, walk.under_way, closes)
    moving = _rate_of_change(way) < -0.2
    steps = 2 * math.pi * 1.8 * t + rng.uniform(0, 6)  # 1.8 steps a second, ours
    sway = np.where(moving, 1.0, 0.2)
    # Who stands shifts their weight: some centimetres, at up to some 10 cm/s (ours).
    along = way + 0.015 * sway * np.sin(steps) + _wander(t, rng.uniform(0.003, 0.015), rng)
    across = g.aside * way / g.start + 0.02 * sway * np.sin(steps / 2)
    c, s = math.cos(g.bearing), math.sin(g.bearing)
    head = np.stack(
        [c * along - s * across, s * along + c * across, g.height + 0.02 * sway * np.cos(steps)],
        axis=1,
    )
    # A body dips its head itself, from where it looked in the salutation.
    looks = np.where(phases == Phase.HD, Phase.DS, phases) if joints else phases
    track = Track.build(
        t,
        head,
        head_rotation=_look(g, t, looks, head, rng),
        smile=_smile(g, t, phases, rng),
        phases=phases,
        name=name,
    )
    if joints:
        across = g.aside * way / g.start
        ground = np.stack([c * way - s * across, s * way + c * across], axis=1)
        heading = np.full(len(t), g.bearing + math.pi)
        # Of their own chance, so that joints change nothing else that is drawn.
        return with_body(rng.spawn(1)[0], track, ground, heading, g.height, _salutations(g, closes))
    return track.with_gestures_from_phases()


def _salutations(g: Greeter, closes: float) -> list[Salutation]:
    dip = g.wave_at + g.wave + g.dip_after
    all_three = [
        Salutation(Phase.DS, g.wave_at, g.wave),
        Salutation(Phase.HD, dip, g.dip),
        Salutation(Phase.CS, closes, g.close),
    ]
    return [s for s in all_three if math.isfinite(s.begin)]


def _phases(
    g: Greeter, t: FloatArray, way: FloatArray, under_way: float, closes: float
) -> IntArray:
    phases = np.where(way < g.final, Phase.FA.value, Phase.APP.value)
    phases[t < under_way] = Phase.IA
    if g.wave_at == g.wave_at:
        phases[(t >= g.wave_at) & (t < g.wave_at + g.wave)] = Phase.DS
    if g.dip_after == g.dip_after:
        dip = g.wave_at + g.wave + g.dip_after
        phases[(t >= dip) & (t < dip + g.dip)] = Phase.HD
    phases[t >= closes] = Phase.CS
    return phases


def _look(
    g: Greeter, t: FloatArray, phases: IntArray, head: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Where the head points: at the robot's face in salutations, away on the way (2.1.4)."""
    away = np.zeros(len(t))
    down = np.zeros(len(t))
    averted = (phases == Phase.APP.value) & (not g.stares)
    # 2.1.1: the first half of the sighting is often without a direct look.
    averted |= (t < g.sighting / 2) & (not g.stares)
    (down if g.downward else away)[averted] = g.aversion * (1 if rng.random() < 0.5 else -1)
    if g.downward:
        down = np.abs(down)
    down[phases == Phase.HD.value] = rng.uniform(0.6, 1.1)
    # People seldom point their noses exactly at whom they look at.
    away += rng.normal(0, 0.12) + _wander(t, 0.06, rng)
    # Up and down they move little: recorded people's heads by a degree or two (ours).
    down += rng.normal(0, 0.12) + _wander(t, 0.025, rng)
    away, down = _smooth(away, 0.12), _smooth(down, 0.12)
    to_face = _ROBOT_FACE - head
    yaw = np.arctan2(to_face[:, 1], to_face[:, 0]) + away
    pitch = np.arctan2(-to_face[:, 2], np.hypot(to_face[:, 0], to_face[:, 1])) + down
    return look_along(yaw, pitch)


def _smile(g: Greeter, t: FloatArray, phases: IntArray, rng: np.random.Generator) -> FloatArray:
    """A smile in salutations and in the final approach, fading between (2.1.2, 2.1.4, 2.1.5)."""
    smiling = _SMILING[phases]
    level = np.where(smiling, max(g.smile, g.calm_smile), g.calm_smile)
    smile: FloatArray = clip(_smooth(level, 0.2) + _wander(t, 0.05, rng), 0.0, 5.0)
    return smile


def _rate_of_change(values: FloatArray) -> FloatArray:
    """Central differences at `RATE`; at the ends, those to the neighbour."""
    rate = np.empty_like(values)
    rate[1:-1] = (values[2:] - values[:-2]) * (RATE / 2)
    rate[0], rate[-1] = (values[1] - values[0]) * RATE, (values[-1] - values[-2]) * RATE
    return rate


def _wander(t: FloatArray, size: float, rng: np.random.Generator) -> FloatArray:
    """A slow, smooth coming and going of a given size."""
    turns, starts = rng.uniform(2, 9, 3), rng.uniform(0, 2 * math.pi, 3)  # [rad/s], [rad]
    a, b, c = np.sin(turns[:, None] * t + starts[:, None])
    return np.asarray(size * (a + b + c) / math.sqrt(1.5))


def _smooth(values: FloatArray, seconds: float) -> FloatArray:
    """Follow with a delay: the mean over the last stretch of `2 * seconds`."""
    n = max(1, round(2 * seconds * RATE))
    padded = np.empty(n + len(values))
    padded[:n], padded[n:] = values[0], values
    sums = padded.cumsum()
    return np.asarray((sums[n:] - sums[:-n]) / n)


def draw_passerby(rng: np.random.Generator, name: str = "", *, joints: bool = False) -> Track:
    """Somebody who walks past, greets nobody, and looks where they go; phases all 0.

    With joints they have a body, and the gestures are left to detectors.
    """
    speed = clip(rng.normal(1.3, 0.25), 0.6, 2.0)
    nearest = float(rng.uniform(0.8, 3.5))
    bearing = float(rng.uniform(-1.0, 1.0))  # of the nearest point of the way
    course = bearing + math.pi / 2 * (1 if rng.random() < 0.5 else -1)
    half = float(rng.uniform(2.0, 5.0))
    t = np.arange(0.0, 2 * half / speed, 1 / RATE)
    steps = 2 * math.pi * 1.8 * t + rng.uniform(0, 6)
    along, away = speed * t - half, nearest + 0.02 * np.sin(steps / 2)
    height = rng.normal(1.55, 0.1)
    head = np.stack(
        [
            away * math.cos(bearing) + along * math.cos(course),
            away * math.sin(bearing) + along * math.sin(course),
            height + 0.02 * np.cos(steps),
        ],
        axis=1,
    )
    yaw = course + rng.normal(0, 0.1) + _wander(t, 0.1, rng)
    look = look_along(yaw, np.zeros_like(yaw))
    smile = clip(rng.normal(0.8, 0.2) + _wander(t, 0.05, rng), 0.0, 5.0)
    track = Track.build(
        t, head, head_rotation=look, smile=smile, phases=np.zeros(len(t), dtype=np.int64), name=name
    )
    if joints:
        heading = np.full(len(t), course)
        return with_body(rng.spawn(1)[0], track, head[:, :2], heading, height)
    return track.with_gestures_from_phases()
