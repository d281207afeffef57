"""kendon as a node of ROS 2: people in, beliefs out, and a robot that greets; any transport."""

from __future__ import annotations

import functools
import importlib
import math
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from typing import Any

from kendon.errors import KendonError
from kendon.features import ROBOT_FACE
from kendon.geometry import Vec3
from kendon.greeter import Flow, Moment
from kendon.models import GreetingModel
from kendon.observations import FEATURES
from kendon.ros.arrivals import Arrivals
from kendon.ros.overlap import Overlap
from kendon.ros.ros2_names import STATE
from kendon.ros.ros2_reading import FACES, ODOMETRY, TICK, PeopleReader, Told
from kendon.ros.ros2_record import Recorder
from kendon.ros.ros2_robot import Ros2Robot
from kendon.ros.ros2_settings import HeardPlace
from kendon.ros.ros2_transport import Fields, Offer, Transport
from kendon.ros.ros2_types import (
    BELIEF,
    ENGAGEMENT,
    FACE,
    OBSERVATION,
    STRING,
    TRANSFORMS,
    header_fields,
)
from kendon.sources.bag_people import BagOptions, listed
from kendon.sources.live_people import PATIENCE, HeardFrame
from kendon.trees import GreetingTree

#: The message types of topics that are known; of others only the publisher's word is.
KINDS: Mapping[str, str] = {
    FACES: FACE,
    ODOMETRY: "nav_msgs/msg/Odometry",
    "/tf": TRANSFORMS,
    "/tf_static": TRANSFORMS,
    "/humans/candidate_matches": "hri_msgs/msg/IdsMatch",
}
_ENDINGS = {
    "facs": "hri_msgs/msg/FacialActionUnits",
    "tracked": "hri_msgs/msg/IdsList",
    "face_id": STRING,
    "body_id": STRING,
    "alias": STRING,
}
#: Messages that were taken in so long after they came are more than the computer can do [ns].
BEHIND = 1_000_000_000
#: So many of the robot's commands are remembered.
_LOGGED = 100
#: The topics of somebody who is gone stay for so long, until all have read the last word [ns].
LINGER = 5_000_000_000
_NANO = 1e-9


class Ros2Node:
    """Reads everybody, tells what it reads, and may let a robot greet whoever came first.

    Args:
        transport: carries the topics.
        model: reads the phases.
        options: what is known of the robot's frames.
        face: the robot's face in its base frame [m].
        recorder: is given all messages heard and told.
        patience: how late messages may be [s].
        clock: when messages are received, by [ns].
    """

    def __init__(
        self,
        transport: Transport,
        model: GreetingModel,
        *,
        options: BagOptions | None = None,
        face: Vec3 = ROBOT_FACE,
        recorder: Recorder | None = None,
        patience: float = PATIENCE,
        clock: Callable[[], int] = time.time_ns,
    ) -> None:
        self.transport = transport
        self.place = HeardPlace((options or BagOptions()).base)
        self.reader = PeopleReader(model, options, face, self.place, self._on_frame, patience)
        self.robot: Ros2Robot | None = None
        self._recorder = recorder
        self._clock = clock
        self._open = True
        self._arrivals = Arrivals()
        self._late = 0  # frames that came too late for the robot
        self._behind = False  # whether ever more came than could be taken in
        self._heard: dict[str, set[Offer]] = {}
        self._overlaps: dict[str, Overlap] = {}
        self._refused: dict[str, str] = {}  # topics that cannot be read, and why
        self._leaving: list[tuple[int, str]] = []  # topics of people gone, and since when [ns]
        self._told: list[Told] = []
        self._moments: list[Moment] = []
        self._flow: Flow | None = None
        self._shift = 0.0  # [s], from the frames' time to the flow's
        self._flow_at = -math.inf  # [s], the flow's time
        importlib.import_module("scipy.spatial.transform")  # half a second, before anybody comes
        transport.advertise(STATE, STRING)

    def greet_with(self, robot: Ros2Robot, tree: GreetingTree | None = None) -> None:
        """Let a robot greet whoever has been there longest."""
        self.robot = robot
        self._flow = Flow(robot, self.reader.model, tree)

    @property
    def notes(self) -> list[str]:
        """What a user should know, one sentence each."""
        notes = [*self.reader.notes, *self._refused.values(), *self.transport.notes]
        if self.late:
            notes.append(
                f"Frames come more than {self.reader.hold * _NANO:g} s late, and are left out"
                " (--lateness waits longer)."
            )
        if self._recorder is not None and self._recorder.trouble:
            notes.append(f"{self._recorder.trouble}.")
        if self._behind:
            notes.append("This computer is too slow for all that is heard: beliefs are late.")
        return notes

    @property
    def late(self) -> int:
        """Frames that were left out, as they came too late."""
        return self.reader.late + self._late

    @property
    def waiting(self) -> str:
        """What the node waits for; "" once a frame of somebody was heard."""
        if self.reader.frames:
            return ""
        where = f"on domain {self.transport.domain}"
        if not self._heard:
            transforms, faces = map(self.transport.called, ("/tf", FACES))
            return (
                f"nobody publishes /humans/faces/tracked with {transforms} (ROS4HRI), or {faces},"
                f" {where}; is ROS_DOMAIN_ID the same there?"
            )
        if unplaced := self.reader.people.unplaced():
            return f"{where}: {unplaced}"
        heard = listed(sorted(map(self.transport.called, self._heard)))
        return f"nobody is there yet; heard are {heard} {where}"

    def run(self) -> Generator[tuple[list[Told], list[Moment]], None, None]:
        """Run for ever, a step of 0.1 s at a time: what was told of people, what the robot did.

        However it ends, the robot is told to stop, and the recording is finished.

        Raises:
            DataError: when it is closed, the recording cannot be finished.
        """
        try:
            while True:
                yield self._step()
        finally:
            self.close()

    def close(self) -> None:
        """Stop the robot, leave, and finish the recording.

        Raises:
            DataError: the recording cannot be finished.
        """
        if not self._open:
            return
        self._open = False
        try:
            if self._flow is not None and self.robot is not None:
                self._flow.end()
                self.robot.close()
        finally:
            self.transport.close()
            if self._recorder is not None:
                self._recorder.close()

    def _step(self) -> tuple[list[Told], list[Moment]]:
        self._follow_offers()
        now = self._take_in((self._clock() // TICK + 1) * TICK)
        self._tell(self.reader.pass_time(self._arrivals.newest))
        if self._flow is not None:
            self._pass_flow(self.reader.clock(now))
            self._flow.shorten_log(_LOGGED)
        self._withdraw(now)
        told, moments = self._told, self._moments
        self._told, self._moments = [], []
        return told, moments

    def _take_in(self, end: int) -> int:
        """Take in all that comes until `end`; the time then [ns].

        Time passes for the reader only when all that had come before has been taken in: what
        waited while this process did not run is not late. The robot's time passes in any case.
        """
        while True:
            now = self._clock()
            if self.transport.spin(max(0, end - now) * _NANO):
                if now < end + TICK:
                    continue
                self._behind |= now - self._arrivals.newest > BEHIND
            elif now < end:
                continue
            else:
                self._arrivals.pass_time(now)
            return now

    # ---- in

    def _follow_offers(self) -> None:
        offers = self.transport.offers()
        for topic in filter(self.reader.wanted, offers.keys() | self._heard.keys()):
            kind = KINDS.get(topic) or _ENDINGS[topic.rsplit("/", 1)[1]]
            known = self._heard.get(topic, set())
            ways = {offer for offer in offers.get(topic, ()) if offer.kind == kind}
            for offer in offers.get(topic, set()) - ways:
                name = self.transport.called(topic)
                self._refused[topic] = f"{name} is published as {offer.kind}, not as {kind}."
            if ways == known:
                continue
            for offer in ways - known:
                callback = functools.partial(self._hear, topic, offer)
                self.transport.subscribe(topic, offer, callback)
            for offer in known - ways:
                self.transport.unsubscribe(topic, offer)
            self._heard[topic], self._overlaps[topic] = ways, Overlap()
            if not ways:
                del self._heard[topic], self._overlaps[topic]

    def _hear(self, topic: str, offer: Offer, raw: bytes, message: Any, sent: int) -> None:
        if len(self._heard[topic]) > 1 and not self._overlaps[topic].is_new(offer, raw):
            return
        came = self._arrivals.take(sent, self._clock())
        if self._recorder is not None:
            self._recorder.write(topic, offer.kind, came, raw)
        self._tell(self.reader.hear(topic, message, came))

    # ---- the robot

    def _on_frame(self, heard: HeardFrame, number: int) -> None:
        if self._flow is None:
            return
        t = heard.frame.t + self._shift
        if t <= self._flow_at:
            if self._flow_at - t < 1.0:
                self._late += 1  # the flow's clock went on without it
                return
            self._shift += self._flow_at - t + TICK * _NANO
            t = heard.frame.t + self._shift
        frame = heard.frame._replace(t=t, who=number, robot=self.place.at(heard.stamp * _NANO))
        self._flow_at = t
        self._take(self._flow.take(frame))

    def _pass_flow(self, clock: int) -> None:
        assert self._flow is not None
        if not clock:
            return
        # The flow waits for frames that may be under way as long as the reader does.
        t = (clock - self.reader.zero - self.reader.hold) * _NANO + self._shift
        if t > self._flow_at:
            self._flow_at = t
            self._take(self._flow.advance(t))

    def _take(self, moments: Iterator[Moment]) -> None:
        self._moments += moments

    # ---- out

    def _tell(self, all_told: list[Told]) -> None:
        self._told += all_told
        for told in all_told:
            header = header_fields(told.stamp, self.place.bases[0])
            engaged = {"header": header, "level": int(told.engagement)}
            person = f"/humans/persons/{told.name}"
            self._publish(f"{person}/engagement_status", ENGAGEMENT, engaged)
            own = f"/kendon/{told.name}"
            if told.observation is not None:
                values = {name: getattr(told.observation, name) for name in FEATURES}
                self._publish(f"{own}/observation", OBSERVATION, {"header": header, **values})
            if told.belief is not None:
                number = told.belief.phase.value
                belief = {
                    "header": header,
                    "phase": number,
                    "probabilities": told.belief.probabilities,
                }
                self._publish(f"{own}/belief", BELIEF, belief)
                if told.name == self.reader.followed:
                    self._publish(STATE, STRING, {"data": str(number)})
            if told.observation is None:
                topics = (f"{person}/engagement_status", f"{own}/observation", f"{own}/belief")
                self._leaving += [(self._arrivals.newest, topic) for topic in topics]
                if self.robot is not None and self.reader.followed is None:
                    self.robot.stop()

    def _withdraw(self, now: int) -> None:
        """Close the topics of people who have been gone for a while."""
        while self._leaving and now - self._leaving[0][0] > LINGER:
            self.transport.withdraw(self._leaving.pop(0)[1])

    def _publish(self, topic: str, kind: str, fields: Fields) -> None:
        self._leaving = [(since, name) for since, name in self._leaving if name != topic]
        try:
            raw = self.transport.publish(topic, kind, fields)
        except KendonError as error:
            self._refused[topic] = f"{error}."[0].upper() + f"{error}."[1:]
            return
        if self._recorder is not None:
            self._recorder.write(topic, kind, self._arrivals.pass_time(0), raw)
