"""Simulated people who mind what the robot does.

    person = ReactingPerson(temperament("shy"), Pose2D(5.0, 0.0, math.pi))
    while not person.finished:
        frames = person.live(robot.appearance)

What a person is about is a generator: each `yield` is a tenth of a second of their life.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kendon.geometry import Pose2D
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.robots.base import Appearance
from kendon.simulation.actor import ACCELERATION, FINAL, Actor
from kendon.simulation.body import Body
from kendon.simulation.deeds import Gesture, Look, Smile, Stand, Turn, WalkTo
from kendon.simulation.embodiment import REPERTOIRE, Salutation, draw_salutation
from kendon.simulation.movements import Movement, draw_movement
from kendon.simulation.sight import Sight
from kendon.simulation.temperaments import Temperament

#: How often people make up their minds [1/s], and how late they see what happens [s]: choice
#: reactions take 0.2 to 0.4 s (Woodworth & Schlosberg 1954).
RATE = 10.0
#: And so many frames of theirs are seen in between.
FRAMES = 3
REACTION = 0.3
#: Nobody looks away for a moment only: listeners do for so long on average [s] (Andrist et al.
#: 2014).
_AVERTED = 1.14
#: Who salutes with the head looks at the robot first, for so long at most [s]; ours.
_FIRST_LOOK = 0.8
#: Who steps back goes this far beyond their comfort, at this pace (ours) [m], [m/s].
_BACK, _BACK_PACE = 0.3, 0.7
#: Within this a robot that comes too fast frightens [m].
_FRIGHTENING = 2.0
#: Whoever has come no nearer to the robot by half a pace [m] for so long [s] gives up.
NEARER, STUCK = 0.3, 10.0
#: How far somebody goes who leaves [m].
_AWAY = 3.0
#: What people show close by: nobody hugs a robot here, or stands and looks alone.
_CLOSE = {kind: odds for kind, odds in REPERTOIRE[Phase.CS].items() if kind not in ("hug", "")}
#: How long after the answer to their close salutation people stay [s]; ours.
_STAYING = 1.0


#: Why somebody leaves whom the robot did no wrong.
MIND = "they changed their mind"


class _Leaves(Exception):  # noqa: N818 - a decision, not an error
    """The person gives up on the greeting."""


class ReactingPerson:
    """A person who greets a robot, as they feel about what it does.

    They salute and wait to be answered, walk up, step back from a robot that comes too close or
    too fast, hold out a hand and give up on one that does not take it.

    Args:
        temperament: how they greet.
        start: where they stand at first.
        body: whose; drawn if left out.
        past: how near somebody who greets nobody passes the robot's place [m].
        seed: of chance.
    """

    def __init__(
        self, temperament: Temperament, start: Pose2D, *, body: Body | None = None,
        past: float = 1.5, seed: int = 0,
    ) -> None:  # fmt: skip
        self._rng = np.random.default_rng([seed, 1])
        self.temperament = temperament
        self.actor = Actor(start, body=body, speed=temperament.speed, rate=FRAMES * RATE, seed=seed)
        self.finished = False
        self.gave_up = ""  # why, in a clause
        self.answered: dict[Phase, float] = {}  # [s], when each of their salutations was seen to be
        self.step_backs = 0
        self.made: list[Movement] = []  # every salutation and dip, as it was meant to go
        self._past = past
        self._sight = Sight(self.actor, round(REACTION * RATE))
        self._stage: Phase | None = None
        self._saluting = False
        self._under_way = False
        self._greeted = False  # the close salutation has begun: nearness is welcome
        self._life = self._decide()

    @property
    def t(self) -> float:
        """The person's clock [s]."""
        return self.actor.t

    @property
    def phase(self) -> Phase | None:
        """What the person is really doing; None = not greeting (any more)."""
        if self._stage is None:
            return None
        if self._stage is Phase.CS or self.actor.showing("csal"):
            return Phase.CS
        if self.actor.showing("dsal"):
            return Phase.DS
        if self.actor.showing("hdip"):
            return Phase.HD
        if self._stage is Phase.APP and self._sight.away < FINAL:
            return Phase.FA
        return self._stage

    def live(self, robot: Appearance) -> list[PersonFrame]:
        """Live on for a tenth of a second in the presence of a robot; its frames, in the world."""
        self._sight.take(robot)
        if not self.finished:
            try:
                next(self._life)
            except StopIteration:
                self.finished = True
        return self.actor.frames(FRAMES)

    # ---- what the person does

    def _decide(self) -> Iterator[None]:
        try:
            if self.temperament.greets:
                yield from self._greet()
            else:
                yield from self._pass_by()
        except _Leaves as reason:
            self.gave_up = str(reason)
            yield from self._leave()

    def _greet(self) -> Iterator[None]:
        own, rng = self.temperament, self._rng
        start = self._sight.away
        self._stage = Phase.IA
        self.actor.act(Look(aside=0.5 if own.aversion else 0.0))
        yield from self._wait(own.sighting / 2)
        self._look_at_robot()
        yield from self._wait(own.sighting / 2)
        salutes = rng.random() < own.salutes
        # 2.1.2, 3.4: ten in a hundred before they set off, twenty in the final approach.
        when = rng.choice(3, p=(0.1, 0.7, 0.2)) if salutes else 3
        if when == 0:
            yield from self._salute(walking=False)
        self._stage = Phase.APP
        if when == 1:
            yield from self._approach(max(FINAL + 0.6, start - rng.uniform(0.3, 2.5)))
            yield from self._salute(walking=not own.waits)
        if rng.random() < own.pauses and self._sight.away > FINAL + 1.0:
            yield from self._approach(float(rng.uniform(FINAL + 0.5, self._sight.away - 0.3)))
            self.actor.act(Stand())
            self._look_at_robot()
            yield from self._wait(float(rng.uniform(0.5, 1.5)))
        if own.turns_at == own.turns_at:
            yield from self._approach(start - own.turns_at * (start - own.stop))
            raise _Leaves(MIND)
        if when == 2:
            yield from self._approach(min(FINAL - 0.4, self._sight.away - 0.1))
            yield from self._salute(walking=True)
        yield from self._approach(own.stop)
        yield from self._close()

    def _salute(self, *, walking: bool) -> Iterator[None]:
        """A distance salutation, perhaps held until it is answered, perhaps with a head dip."""
        own, rng = self.temperament, self._rng
        for attempt in range(2 if own.again else 1):
            if attempt and self._sight.away < FINAL:
                break  # now they are there sooner than they have waved again
            self._saluting = True
            self._look_at_robot()
            self.actor.act(Smile(own.smile))
            if not walking:
                self.actor.act(Stand())
            drawn = self._draw(Phase.DS, math.log(1.0), 0.4)
            looks = self.t + _FIRST_LOOK
            while not drawn.hands and not self.actor.looks_there and self.t < looks:
                # A distance salutation has direct gaze (4.1.2): the head comes up, then salutes.
                yield from self._tick(walk=walking)
            shown = self._make(drawn)
            since = self.t
            end = shown.end - (shown.fall / 2 if shown.hands else 0.0)  # as labels have it
            waiting = not walking and own.waits
            while self.t < end or (waiting and self.t < end + own.patience):
                if not walking and self._stage in (Phase.APP, Phase.FA):
                    self._stage = Phase.DS  # standing, they are in it until it is answered
                if self._note_answer(Phase.DS, since) and self.t >= end:
                    break
                yield from self._tick(walk=walking)
            if self._stage is Phase.DS:
                self._stage, self._under_way = Phase.APP, False
            self._saluting = False
            # 2.1.3: half of the salutations early in the approach, never those in the final one.
            if not attempt and self._sight.away > FINAL + 0.5 and rng.random() < own.dips:
                dip = self._make(self._draw(Phase.HD, math.log(0.5), 0.3))
                while self.t < dip.end:
                    yield from self._tick(walk=walking)
            if Phase.DS in self.answered or attempt or not own.again:
                break
            hoped = self.t + 0.8
            while self.t < hoped and not self._note_answer(Phase.DS, since):
                yield from self._tick(walk=walking)
            if Phase.DS in self.answered:
                break
        if own.waits and not walking and Phase.DS not in self.answered:
            raise _Leaves("their salutation was not answered")

    def _approach(self, until: float) -> Iterator[None]:
        """Walk up to the robot, down to a distance."""
        nearest, since = math.inf, self.t
        while self._sight.away > until + 0.05:
            if until <= FINAL and self._sight.away < 1.8 and self._sight.hand_offered:
                break  # its hand is out
            if self._sight.away < nearest - NEARER:
                nearest, since = self._sight.away, self.t
            elif self.t - since > STUCK:
                raise _Leaves("they could not reach the robot")
            yield from self._tick(walk=True)

    def _close(self) -> Iterator[None]:
        """The close salutation: a hand held out until it is taken, or what else people do."""
        own, rng = self.temperament, self._rng
        self.actor.act(Stand())
        self._look_at_robot()
        self.actor.act(Smile(own.smile))
        self._greeted = True
        odds = np.array(list(_CLOSE.values()))
        kind = str(rng.choice(list(_CLOSE), p=odds / odds.sum()))
        if self._sight.hand_offered:
            kind = "handshake"
        since = self.t
        if kind == "handshake":
            shown = self._hold_out_hand()
        else:
            drawn = draw_movement(kind, rng, handed=self.actor.body.handed, near=True)
            shown = self._make(replace(drawn, gesture="csal"))
        while self.t < since + shown.rise / 2:
            yield from self._tick()
        self._stage = Phase.CS
        while self.t < since + shown.rise + own.patience:
            if kind != "handshake" and self._note_answer(Phase.CS, since):
                break
            if kind == "handshake" and self._sight.hand_offered and self._sight.away < 1.8:
                self.answered[Phase.CS] = self.t
                shown = self._shake(shown)
                break
            yield from self._tick()
        if Phase.CS not in self.answered:
            self.actor.lower(shown)
            raise _Leaves("their close salutation was not answered")
        while self.t < shown.end + _STAYING:
            yield from self._tick()

    def _hold_out_hand(self) -> Movement:
        drawn = draw_movement("handshake", self._rng, handed=self.actor.body.handed)
        shaking = drawn.duration - drawn.rise - drawn.wait - drawn.fall
        wait = 2 * self.temperament.patience
        held = replace(
            drawn, wait=wait, duration=drawn.rise + wait + shaking + drawn.fall, gesture="csal"
        )
        return self._make(held)

    def _shake(self, held: Movement) -> Movement:
        """The hand is taken: shake it, now."""
        wait = max(0.0, self.t - held.begin - held.rise)
        duration = held.duration - (held.wait - wait)
        return self.actor.change(held, replace(held, wait=wait, duration=duration))

    def _pass_by(self) -> Iterator[None]:
        """Straight on, past the place where the robot stood at first, around it if need be."""
        x, y = self.actor.place
        robot = self._sight.pose
        dx, dy = robot.x - x, robot.y - y
        way = math.hypot(dx, dy)
        side = 1 if self._rng.random() < 0.5 else -1
        off = side * (math.asin(self._past / way) if self._past < way else math.pi / 2)
        course = math.atan2(dy, dx) + off
        far = 2 * way * math.cos(off)
        goal = (x + far * math.cos(course), y + far * math.sin(course))
        self.actor.heading = course
        self.actor.act(Look(aside=0.0))
        glance = self.t + float(self._rng.uniform(0.5, 3.0))  # people glance at what moves
        glances = self._rng.random() < 0.5
        self.actor.act(WalkTo(*goal))
        while not self.actor.arrived:
            at_robot = glances and glance <= self.t < glance + 0.7
            self.actor.act(Look(self._sight.noticed.face) if at_robot else Look())
            if self._sight.away < self.temperament.comfort and self._sight.coming_at > 0.1:
                yield from self._step_back()
                self.actor.act(WalkTo(*goal))
            yield

    def _leave(self) -> Iterator[None]:
        self._stage = None
        x, y = self.actor.place
        robot = self._sight.pose
        away = math.atan2(y - robot.y, x - robot.x) + float(self._rng.uniform(-0.7, 0.7))
        self.actor.act(Look())
        self.actor.act(Smile(1.0))
        self.actor.act(WalkTo(x + _AWAY * math.cos(away), y + _AWAY * math.sin(away)))
        while not self.actor.arrived:
            yield

    # ---- a tenth of a second of each

    def _tick(self, *, walk: bool = False) -> Iterator[None]:
        if not self._greeted and self._crowded():
            yield from self._step_back()
        if walk:
            self._walk_on()
        yield

    def _wait(self, seconds: float) -> Iterator[None]:
        end = self.t + seconds
        while self.t < end - 1e-9:
            yield from self._tick()

    def _walk_on(self) -> None:
        """One glance at where the robot is, and on toward the place before it."""
        own, robot = self.temperament, self._sight.pose
        toward = math.atan2(self.actor.y - robot.y, self.actor.x - robot.x)
        # Whoever walks up to somebody who comes, too, allows for that while they stop.
        room = own.stop + max(0.0, self._sight.coming_at) * self.actor.walking_at / ACCELERATION
        goal = (robot.x + room * math.cos(toward), robot.y + room * math.sin(toward))
        if self._sight.away > room:
            self.actor.act(WalkTo(*goal))
        else:
            self.actor.act(Stand())
        self._set_off()
        away = 0.0 if self._saluting or self.phase is not Phase.APP else own.aversion
        self._look_at_robot(0.3 * away, 0.8 * away)
        smiling = self.phase in (Phase.DS, Phase.FA, Phase.CS)
        self.actor.act(Smile(own.smile if smiling else min(1.0, own.smile)))

    def _set_off(self) -> None:
        """Into the approach, or straight into the final one where there is hardly any way before.

        What tells the final approach is the look and the smile that come back (2.1.5): whoever
        has not the time to take them away, as after a salutation not far from there, keeps them.
        """
        if self.phase is not Phase.APP:
            self._under_way = False
        elif not self._under_way:
            self._under_way = True
            left = self._sight.away - FINAL
            if left < _AVERTED * (self.temperament.speed + max(0.0, self._sight.coming_at)):
                self._stage = Phase.FA

    def _crowded(self) -> bool:
        if self._sight.away < self.temperament.comfort:
            return True
        return self._sight.away < _FRIGHTENING and self._sight.coming_at > self.temperament.fright

    def _step_back(self) -> Iterator[None]:
        """Give way, facing the robot, until there is room again or the robot stands."""
        self.step_backs += 1
        until = max(self.temperament.comfort, self._sight.away) + _BACK
        began = self.t
        while self._sight.away < until and self.t < began + 3.0:
            robot = self._sight.pose
            away = math.atan2(self.actor.y - robot.y, self.actor.x - robot.x)
            x, y = (
                robot.x + (until + 0.1) * math.cos(away),
                robot.y + (until + 0.1) * math.sin(away),
            )
            self.actor.act(WalkTo(x, y, speed=_BACK_PACE, backward=True))
            self._look_at_robot()
            yield
        self.actor.act(Stand())
        robot = self._sight.pose
        self.actor.act(Turn(math.atan2(robot.y - self.actor.y, robot.x - self.actor.x)))

    def _look_at_robot(self, aside: float = 0.0, down: float = 0.0) -> None:
        self.actor.act(Look(self._sight.noticed.face, aside, down))

    def _draw(self, phase: Phase, typical: float, spread: float) -> Movement:
        """A salutation or dip as drawn greeters show it, about so long [log s] (3.4)."""
        seconds = float(np.clip(self._rng.lognormal(typical, spread), 0.3, 2.2))
        told = Salutation(phase, self.t, seconds)
        drawn = draw_salutation(self._rng, told, self.actor.body.handed)
        assert drawn is not None  # only a close salutation may be to stand and look
        return drawn

    def _make(self, movement: Movement) -> Movement:
        made = self.actor.act(Gesture(movement.kind, movement))
        assert made is not None
        self.made.append(made)
        return made

    def _note_answer(self, phase: Phase, since: float) -> bool:
        """Whether the robot has answered a salutation; notes when that was first seen."""
        if phase not in self.answered and self._sight.saluted and self._sight.noticed.t >= since:
            self.answered[phase] = self.t
        return phase in self.answered
