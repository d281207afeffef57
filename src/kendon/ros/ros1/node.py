"""kendon as a ROS 1 node: faces in, the state out, and the robot's answers (thesis figure 4.1)."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from kendon.robots.base import CommandKind, CommandStatus, Robot
from kendon.ros.hearing import LOCALISED, STATE, STATIC, TRANSFORMS, Hearing
from kendon.ros.humans import make_stream
from kendon.ros.parts import Told, make_part
from kendon.ros.ros1.connection import MasterWatch, flush, require_type
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.ros1.human_topics import Heard, HumanTopics
from kendon.ros.ros1.record import BagRecorder, RawMessage
from kendon.ros.ros1.rviz import MarkerPublisher
from kendon.ros.settings import Input, NodeSettings, Part, StateType
from kendon.ros.telling import fill_belief, fill_observation, fill_state
from kendon.sources.ros_place import RobotPlace

#: So many messages may wait, those of ten people of some seconds; older ones are dropped, but for
#: static transforms. rospy drops only what it has read in one go: so much [bytes], or kernels would
#: hold minutes of messages for a node that cannot keep up.
_WAITING, _READ = 1000, 2**22
#: What has waited for so long while newer messages have come is left out [ns].
_STALE = 1_000_000_000
#: How long to wait for a message until time goes on without it [s].
_PAUSE = 0.02
#: How long to wait for somebody to tell where the robot is until the user is told [s].
_NO_PLACE = 3.0
#: So many sentences are remembered, not to tell them again.
_SENTENCES = 200
#: How often the master is looked to [s].
_WATCHED = 0.5
#: How long simulated time may stand still until the user is told [s].
_NO_CLOCK = 5.0

#: The topics on which people are told of.
_TOPICS = {Input.FACES: "faces", Input.PEOPLE: "people", Input.HUMANS: TRANSFORMS}
#: Topics that are found in a recording by these names, whatever they are called here.
_RECORDED_AS = (TRANSFORMS, STATIC)


class GreetingNode:
    """The node, in a process that `kendon.ros.ros1.connection.start_node` has made one.

    Args:
        robot: answers; told where it is by the same `place`.
        place: where the robot is.
        settings: what the user said.
        tell: called with each sentence for the user, when it is known.
        recorder: is given all that is heard and told.

    Raises:
        DataError: the input topic carries messages of another type.
        KendonError: the model or the tree of the settings cannot be read.
    """

    def __init__(
        self,
        robot: Robot,
        place: RobotPlace,
        settings: NodeSettings,
        tell: Callable[[str], None] = lambda sentence: None,
        recorder: BagRecorder | None = None,
    ) -> None:
        self._rospy = rospy = ros_module("rospy")
        self._master = MasterWatch()
        self.robot = robot
        self.place = place
        self.settings = settings
        self.lost = 0  # messages that came faster than they could be taken in
        self._tell = tell
        self._told: dict[str, None] = {}  # the sentences, in their order
        self._ending = False
        self._inbox: queue.Queue[Heard] = queue.Queue()
        self._recorder = recorder
        self._kendon = messages("kendon_msgs")
        self._geometry = ros_module("geometry_msgs.msg")
        self._state_class = self._class_of_state()
        name = _TOPICS[settings.input]
        self.stream = make_stream(place, settings, rospy.resolve_name(name))
        self.part = make_part(self.stream, robot, settings)
        self.hearing = Hearing(place, self.stream, self.part)
        self._publish = self._publishers()
        self._subscribe(name)
        self._humans = HumanTopics(self._put) if settings.input is Input.HUMANS else None
        self._changes: queue.SimpleQueue[str] = queue.SimpleQueue()  # of the master
        self._markers = MarkerPublisher(robot, place) if settings.markers else None
        self._started = time.monotonic()

    def run(self) -> Iterator[Told]:
        """What there is to tell, published, until `stop`; then the robot is stopped.

        Likewise when ROS ends the node (``rosnode kill``, or another node of its name).
        """
        rospy = self._rospy
        over = threading.Event()

        def end() -> None:
            """Keep the topics open, which ROS closes after this, until the robot has stopped."""
            self.stop()
            over.wait(3 * self.settings.patience)

        rospy.on_shutdown(end)
        threading.Thread(target=self._watch, daemon=True).start()
        try:
            while not (self._ending or rospy.is_shutdown()):
                try:
                    heard = self._inbox.get(timeout=_PAUSE)
                except queue.Empty:
                    if now := rospy.get_rostime().to_nsec():
                        yield from self._tell_all(self.hearing.pass_time(now))
                    self._look_around()
                    continue
                if self._is_stale(heard):
                    self.lost += 1
                    continue
                came = self.hearing.arrival(heard.came)
                if self._recorder is not None and heard.role != STATE:
                    self._recorder.write(
                        heard.role if heard.role in _RECORDED_AS else heard.topic,
                        heard.raw or RawMessage.of(heard.message),
                        came,
                    )
                yield from self._tell_all(self.hearing.take(heard.role, heard.message, came))
                if self._inbox.empty():
                    self._look_around()
        finally:
            try:
                self.part.end()
                self._settle()
            finally:
                over.set()

    def stop(self) -> None:
        """Let `run` end; may be called in a signal handler."""
        self._ending = True

    def _settle(self) -> None:
        """Wait until the robot has stopped, and all that was told has left."""
        stop = self.robot.running(CommandKind.STOP)
        while stop and stop.running:  # no longer than the robot's patience
            time.sleep(_PAUSE)
            self.robot.update(self.robot.time + _PAUSE)
        if stop and stop.status is CommandStatus.FAILED:
            self._tell(f"The robot has not said that it stopped: {stop.reason}.")
        if stuck := flush(self.settings.patience):
            self._tell(f"Nobody took the last messages of {', '.join(stuck)}.")

    def _tell_all(self, told: Iterable[Told]) -> Iterator[Told]:
        """Publish what there is to tell."""
        for one in told:
            moment = one.moment
            if moment.is_new and moment.observation and moment.belief:
                stamp = self._rospy.Time.from_sec(one.stamp)
                belief, observation = self._kendon.Belief(), self._kendon.Observation()
                for message in (belief, observation):
                    message.header.stamp = stamp
                    message.header.frame_id = self.place.bases[0]
                self._send("belief", fill_belief(belief, moment.belief))
                self._send("observation", fill_observation(observation, moment.observation))
                self._send("state", fill_state(self._state_class(), moment.belief.phase))
            if self._markers is not None:
                self._markers.show(moment)
            yield one

    def _send(self, name: str, message: Any) -> None:
        topic = self._publish[name]
        topic.publish(message)
        if self._recorder is not None:
            raw = RawMessage.of(message)
            self._recorder.write(topic.resolved_name, raw, self.hearing.newest)

    def _publishers(self) -> dict[str, Any]:
        if self.settings.part is Part.ANSWERING:
            return {}
        types = {
            "state": self._state_class,
            "belief": self._kendon.Belief,
            "observation": self._kendon.Observation,
        }
        publisher = self._rospy.Publisher
        return {name: publisher(name, kind, queue_size=10) for name, kind in types.items()}

    def _subscribe(self, name: str) -> None:
        transforms = ros_module("tf2_msgs.msg").TFMessage
        if self.settings.input is Input.PEOPLE:
            self._listen(name, self._geometry.PoseArray)
        elif self.settings.input is Input.FACES:
            self._listen(name, self._kendon.FaceExtraction)
        if self.settings.part is Part.ANSWERING:
            self._listen(STATE, self._state_class)
        self._listen(TRANSFORMS, transforms)
        self._listen(STATIC, transforms)
        self._listen(LOCALISED, self._geometry.PoseWithCovarianceStamped)

    def _listen(self, name: str, kind: Any) -> None:
        """Put the messages of a topic into the inbox."""
        topic = self._rospy.resolve_name(name)
        others = ", ".join(choice.value for choice in Input)
        require_type(
            topic, kind._type, f"choose the input ({others}) or remap it ({name}:=/other/topic)"
        )

        def came(message: Any) -> None:
            self._put(Heard(name, topic, message))

        self._rospy.Subscriber(
            name, kind, came, queue_size=_WAITING, buff_size=_READ, tcp_nodelay=True
        )

    def _is_stale(self, heard: Heard) -> bool:
        """Whether a message of people has waited too long, and newer ones are there."""
        if heard.role in (STATE, TRANSFORMS, STATIC, LOCALISED) or self._inbox.empty():
            return False
        return bool(self._rospy.get_rostime().to_nsec() - heard.came > _STALE)

    def _put(self, heard: Heard) -> None:
        """Take in a message, in whatever thread of ROS."""
        now = self._rospy.get_rostime().to_nsec()
        if not now:
            return  # simulated time that has not begun
        with self._inbox.mutex:
            waiting = self._inbox.queue
            if len(waiting) >= _WAITING:  # what is static is told only once
                oldest = next((i for i, one in enumerate(waiting) if one.role != STATIC), 0)
                del waiting[oldest]
                self.lost += 1
        self._inbox.put(heard._replace(came=now))

    def _class_of_state(self) -> Any:
        standard = ros_module("std_msgs.msg")
        return standard.String if self.settings.state_type is StateType.STRING else standard.Int32

    def _look_around(self) -> None:
        """Tell what has become known meanwhile."""
        refused = list(self._humans.refused.values()) if self._humans else []
        for sentence in (*self.stream.notes, *refused):
            self._note(sentence)
        while not self._changes.empty():
            self._tell(self._changes.get())  # each time anew
        waited = time.monotonic() - self._started
        if self._recorder is not None and self._recorder.trouble:
            self._note(f"{self._recorder.trouble}.")
        if not self.place.known and waited > _NO_PLACE:
            names = ", ".join(map(self._rospy.resolve_name, (LOCALISED, TRANSFORMS)))
            self._note(f"Nobody tells where the robot is ({names}): it is taken to stand still.")
        if self.lost:
            self._note("Messages come faster than they can be taken in; some are left out.")
        if not self._rospy.get_time() and waited > _NO_CLOCK:
            self._note("use_sim_time is set, but nothing tells the time on /clock: waiting for it.")

    def _watch(self) -> None:
        """Look to the master, which may take its time to answer; in a thread of its own."""
        while not (self._ending or self._rospy.is_shutdown()):
            if changed := self._master.check():
                self._changes.put(changed)
            if self._humans is not None:
                self._humans.follow()
            time.sleep(_WATCHED)

    def _note(self, sentence: str) -> None:
        if sentence not in self._told:
            self._told[sentence] = None
            self._tell(sentence)
            if len(self._told) > _SENTENCES:
                del self._told[next(iter(self._told))]
