"""Decorators with the semantics of BehaviorTree.CPP v4.

py_trees's own are used where they mean the same: Inverter, FailureIsSuccess (ForceSuccess),
SuccessIsFailure (ForceFailure) and PassThrough (SubTree); all four hand RUNNING, a halt and a
skipped child through. Those below differ:

- Repeat, RetryUntilSuccessful: BehaviorTree.CPP starts the next repetition in the same tick
  when the child had been running before; py_trees always waits for the next tick.
- KeepRunningUntilFailure: stays RUNNING over a skipped child; py_trees's SuccessIsRunning
  hands the skip through.
- RunOnce: skips, or repeats the answer, for the rest of the tree's life, halts included;
  py_trees's OneShot has no skip.
- Timeout: on the flow's clock, so that a recording replays the same at any speed; py_trees's
  runs on the wall clock.
"""

from __future__ import annotations

from py_trees import decorators as own
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from kendon.errors import KendonError
from kendon.trees.control import FAILURE, RUNNING, SKIPPED, SUCCESS, DirectTick
from kendon.trees.ports import Input
from kendon.trees.state import TreeState

__all__ = [
    "ForceFailure",
    "ForceSuccess",
    "Inverter",
    "KeepRunningUntilFailure",
    "Repeat",
    "RetryUntilSuccessful",
    "RunOnce",
    "SubTree",
    "Timeout",
]


class DecoratorNode(DirectTick, own.Decorator):
    """The base of all decorators: subclasses write `update`, or `_route` to tick otherwise."""

    def tick_once(self) -> None:
        """Tick the child as `_route` says."""
        self.feedback_message = ""
        try:
            self.status = self._route()
        except KendonError as error:  # a port that cannot be read
            if self.decorated.status is RUNNING:
                self.decorated.stop(Status.INVALID)
            self.feedback_message, self.status = str(error), FAILURE

    def _route(self) -> Status:
        """Tick the child and return this node's status."""
        self.decorated.tick_once()
        return self.update()

    def update(self) -> Status:
        """This node's status, from that of the child just ticked."""
        return self.decorated.status


# py_trees says what these mean (`update`); kendon says how they are ticked.


class Inverter(own.Inverter, DecoratorNode):
    """SUCCESS becomes FAILURE and the other way round."""


class ForceSuccess(own.FailureIsSuccess, DecoratorNode):
    """FAILURE becomes SUCCESS."""


class ForceFailure(own.SuccessIsFailure, DecoratorNode):
    """SUCCESS becomes FAILURE."""


class SubTree(own.PassThrough, DecoratorNode):
    """Stands for another tree and answers what that answers."""


class KeepRunningUntilFailure(DecoratorNode):
    """FAILURE when the child fails, RUNNING otherwise; a child that succeeded starts again."""

    def update(self) -> Status:
        """FAILURE or RUNNING."""
        return FAILURE if self.decorated.status is FAILURE else RUNNING


class _Again(DecoratorNode):
    """Ticks the child again after `again`, up to a number of times; -1 is for ever."""

    again: Status

    def __init__(self, name: str, child: Behaviour, limit: Input) -> None:
        super().__init__(name=name, child=child)
        self._limit = limit
        self._count = 0

    def _route(self) -> Status:
        limit: int = self._limit.get()
        while limit == -1 or self._count < limit:
            fresh = self.decorated.status is not RUNNING
            self.decorated.tick_once()
            status = self.decorated.status
            if status is not self.again:
                if status is SUCCESS or status is FAILURE:
                    self._count = 0
                return status
            self._count += 1
            # A child that completes at once gives the rest of the tree its turn first.
            if fresh and (limit == -1 or self._count < limit):
                return RUNNING
        self._count = 0
        return self.again

    def terminate(self, new_status: Status) -> None:
        """Forget the count when halted."""
        if new_status is Status.INVALID:
            self._count = 0


class Repeat(_Again):
    """Repeats a succeeding child `num_cycles` times; its first FAILURE ends it."""

    again = SUCCESS


class RetryUntilSuccessful(_Again):
    """Tries a failing child up to `num_attempts` times; its first SUCCESS ends it."""

    again = FAILURE


class RunOnce(DecoratorNode):
    """Lets the child complete once in the tree's life; afterwards skips or repeats its answer."""

    def __init__(self, name: str, child: Behaviour, then_skip: Input) -> None:
        super().__init__(name=name, child=child)
        self._then_skip = then_skip
        self._answer: Status | None = None

    def _route(self) -> Status:
        if self._answer is not None:
            return SKIPPED if self._then_skip.get() else self._answer
        self.decorated.tick_once()
        status = self.decorated.status
        if status is SUCCESS or status is FAILURE:
            self._answer = status
        return status


class Timeout(DecoratorNode):
    """Halts a child that has been running for `msec` of the flow's clock and fails; 0 is never."""

    def __init__(self, name: str, child: Behaviour, msec: Input, state: TreeState) -> None:
        super().__init__(name=name, child=child)
        self._msec, self._state = msec, state
        self._since = 0.0  # [s]

    def _route(self) -> Status:
        limit = self._msec.get() / 1000.0
        if self.status is not RUNNING:
            self._since = self._state.t
        # The clock counts in tenths that no float holds exactly: half a millisecond of slack.
        elif limit > 0 and self._state.t - self._since >= limit - 5e-4:
            self.decorated.stop(Status.INVALID)
            self.feedback_message = f"timed out after {limit:g} s"
            return FAILURE
        self.decorated.tick_once()
        return self.decorated.status
