"""Leaves that sense, compute and compare; those that command the robot are in `commands`."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from kendon.errors import KendonError
from kendon.trees.control import FAILURE, RUNNING, SUCCESS, DirectTick
from kendon.trees.ports import BoundPorts
from kendon.trees.poses import BASE_FRAME, approach_goal, gaze_down, ground_pose, turn_goal
from kendon.trees.state import TreeState


class Leaf(DirectTick, Behaviour):
    """The base of all execution nodes: subclasses write `update`, and `initialise` if needed.

    Hooks, none of which may block:
        `initialise`: at a tick when the leaf was not running.
        `update`: at every tick; returns SUCCESS, FAILURE or RUNNING. A KendonError raised in it
            makes FAILURE, with its sentence as the leaf's message.
        `terminate`: when the leaf is halted; with INVALID.

    Args:
        name: the node's name.
        ports: bound to the blackboard of the leaf's tree.
        state: shared by all nodes of the tree.
    """

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name)
        self.ports = ports
        self.state = state

    def tick_once(self) -> None:
        """Tick the leaf: py_trees's rules, less its logging, plus kendon's errors."""
        self.feedback_message = ""
        try:
            if self.status is not RUNNING:
                self.initialise()
            self.status = self.update()
        except KendonError as error:
            self.feedback_message, self.status = str(error), FAILURE


class GetState(Leaf):
    """Writes the phase as the thesis's number, a text "1" to "6"; FAILURE without a belief."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._out = ports.output("state")

    def update(self) -> Status:
        """Read the phase of this tick."""
        phase = self.state.phase
        if phase is None:
            self.feedback_message = "there is no belief about the phase yet"
            return FAILURE
        self._out.set(str(phase.value))
        return SUCCESS


class IsGreeting(Leaf):
    """SUCCESS while the person probably means to greet the robot, FAILURE otherwise.

    The thesis assumes that everybody does (3.6.4). A robot that drives up to whoever walks past
    would be a nuisance.
    """

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._least = ports.input("probability")

    def update(self) -> Status:
        """Compare the belief of this tick."""
        if self.state.greets >= self._least.get():
            return SUCCESS
        self.feedback_message = f"the person greets with a probability of {self.state.greets:.2f}"
        return FAILURE


class GetPoseFromFace(Leaf):
    """Writes the face's pose in the asked frame; FAILURE when it has been lost for too long.

    The thesis's node hands out the last message it got. Here it may be at most `patience` old
    [s], so that one missed detection does not stop the robot and a person who left does.
    """

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._out = ports.output("closest_face")
        self._patience, self._frame = ports.input("patience"), ports.input("frame_id")

    def update(self) -> Status:
        """Read the face of this tick, or the last one seen."""
        state = self.state
        face = state.face
        if face is None:
            self.feedback_message = "no face has been seen yet"
            return FAILURE
        age = state.t - state.face_seen
        if age > self._patience.get():
            self.feedback_message = f"no face has been seen for {age:.1f} s"
            return FAILURE
        if self._frame.get() == BASE_FRAME:
            face = face.in_base(state.robot.pose)
        self._out.set(face)
        return SUCCESS


class TurnToPersonCoords(Leaf):
    """Writes the goal of a turn on the spot towards the face (Algorithm 3)."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._face, self._out = ports.input("closest_face"), ports.output("goal_pose")

    def update(self) -> Status:
        """Compute the goal for where robot and person are now."""
        robot = self.state.robot.pose
        face = self._face.get().in_world(robot)
        self._out.set(ground_pose(turn_goal(face.position, robot)))
        return SUCCESS


class GetApproachCoords(Leaf):
    """Writes the goal in front of the person (Algorithm 4)."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._face, self._out = ports.input("closest_face"), ports.output("goal_pose")
        self._distance, self._retreat = ports.input("distance"), ports.input("retreat")

    def update(self) -> Status:
        """Compute the goal for where robot and person are now."""
        robot = self.state.robot.pose
        goal = approach_goal(
            self._face.get().in_world(robot),
            robot,
            self._distance.get(),
            retreat=self._retreat.get(),
        )
        self._out.set(ground_pose(goal))
        return SUCCESS


class GazeDownCoords(Leaf):
    """Writes the face's pose at half its height (thesis 4.1.2, Head Dip)."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._face, self._out = ports.input("closest_face"), ports.output("fixation_pose")

    def update(self) -> Status:
        """Lower the pose; both frames have their z at the floor, so either may be halved."""
        self._out.set(gaze_down(self._face.get()))
        return SUCCESS


class WaitForXSeconds(Leaf):
    """RUNNING for a number of seconds of the flow's clock, then `result`; ``inf`` is for ever."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._seconds, self._result = ports.input("seconds"), ports.input("result")
        self._since = 0.0  # [s]

    def initialise(self) -> None:
        """Start the clock."""
        self._since = self.state.t

    def update(self) -> Status:
        """Look at the clock."""
        left = self._seconds.get() - (self.state.t - self._since)
        if left > 5e-4:  # ticks of 0.1 s are not exact in floats
            return RUNNING
        return SUCCESS if self._result.get() == "SUCCESS" else FAILURE


class SetBlackboard(Leaf):
    """Writes a value to a blackboard entry."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._value, self._out = ports.input("value"), ports.output("output_key")

    def update(self) -> Status:
        """Copy the value."""
        self._out.set(self._value.get())
        return SUCCESS


#: What CompareInt and CompareDouble compare by (Vizzy's five operators).
COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    "==": operator.eq,
    ">=": operator.ge,
    ">": operator.gt,
}


class Compare(Leaf):
    """SUCCESS when ``A Condition B`` holds, FAILURE otherwise."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._a, self._b = ports.input("A"), ports.input("B")
        self._condition = ports.input("Condition")

    def update(self) -> Status:
        """Compare the values of this tick."""
        holds = COMPARISONS[self._condition.get()](self._a.get(), self._b.get())
        return SUCCESS if holds else FAILURE


class AlwaysSuccess(Leaf):
    """Always SUCCESS."""

    def update(self) -> Status:
        """Answer."""
        return SUCCESS


class AlwaysFailure(Leaf):
    """Always FAILURE."""

    def update(self) -> Status:
        """Answer."""
        return FAILURE
