"""Control nodes with the semantics of BehaviorTree.CPP v4, as py_trees composites (thesis 2.3).

Why none of py_trees's own composites is used: at the start of a round they send
``stop(INVALID)`` to children that have completed. In kendon that call means one thing only, "you
are halted: cancel your commands", and a Sequence that starts over must not cancel the gesture a
completed leaf has started. Besides, py_trees's Parallel knows no thresholds and py_trees has no
SequenceWithMemory and no Switch. All nodes here are ordinary py_trees behaviours all the same:
its printers and visitors work on them, and its leaves below them.

Three words:

- *halt* a node, ``stop(INVALID)``: it and everything below it stops, commands are cancelled.
  It reaches completed nodes too, since their command may still run.
- *reset* a node: it has completed and its status is forgotten; nothing is cancelled.
- *skipped*: a node that was ticked and answers INVALID did nothing (BehaviorTree.CPP's SKIPPED,
  which only `RunOnce` gives here); sequences and fallbacks go on to the next child.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Sequence as SequenceOf
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite

from kendon.errors import KendonError, TreeError
from kendon.trees.ports import Input

SUCCESS, FAILURE, RUNNING, SKIPPED = (
    Status.SUCCESS,
    Status.FAILURE,
    Status.RUNNING,
    Status.INVALID,
)


class DirectTick:
    """Ticks and halts by plain calls, downwards through the whole tree.

    py_trees ticks through nested generators, so that visitors can look at every node in between;
    in a tree as deep as the greeting's that costs more than the nodes themselves. `tick` is
    kept for py_trees's visitors, which see the nodes after the tick. py_trees's `stop` writes a
    line for a log at every node, whether or not anybody reads it.
    """

    def tick(self: Any) -> Iterator[Behaviour]:
        """Tick once, then yield every node that is not idle, this one last."""
        self.tick_once()
        for node in self.iterate():
            if node is self or node.status is not Status.INVALID:
                yield node

    def stop(self: Any, new_status: Status = Status.INVALID) -> None:
        """Halt this node and everything below it."""
        self.terminate(new_status)
        if new_status is Status.INVALID:
            for child in self.children:
                child.stop(new_status)
        self.status = new_status


def reset(node: Behaviour) -> None:
    """Forget a completed node's status; a node that is still running is halted."""
    if node.status is RUNNING:
        node.stop(Status.INVALID)
    elif node.status is not Status.INVALID:
        node.status = Status.INVALID
        for child in node.children:
            reset(child)


class ControlNode(DirectTick, Composite):
    """The base of all control nodes: subclasses write `_route`."""

    def tick_once(self) -> None:
        """Tick the children as `_route` says."""
        self.feedback_message = ""
        try:
            self.status = self._route()
        except KendonError as error:  # a port that cannot be read; leaves keep theirs
            self._reset_from(0)
            self._forget()
            self.feedback_message, self.status = str(error), FAILURE

    def _route(self) -> Status:
        """Tick children and return this node's status."""
        return SKIPPED

    def terminate(self, new_status: Status) -> None:
        """Forget where the round stood when halted."""
        if new_status is Status.INVALID:
            self._forget()

    def _forget(self) -> None:
        """Forget where the round stood; called when the node is halted."""

    def _reset_from(self, index: int) -> None:
        for child in self.children[index:]:
            if child.status is not Status.INVALID:
                reset(child)


class _Line(ControlNode):
    """Ticks children from left to right until one does not answer `go_on`.

    The two columns of table 2.2 mirror each other: a Sequence goes on after SUCCESS, a
    Fallback after FAILURE. Either remembers its place unless it is reactive.
    """

    go_on: Status
    reactive = False
    keeps_place = False

    def __init__(self, name: str, children: SequenceOf[Behaviour]) -> None:
        super().__init__(name, children)
        self._index = 0  # the child to go on with
        self._skipped = 0

    def _route(self) -> Status:
        if self.reactive or self.status is not RUNNING:
            self._skipped = 0
        if self.reactive:
            self._index = 0
        while self._index < len(self.children):
            child = self.children[self._index]
            self.current_child = child
            child.tick_once()
            status = child.status
            if status is self.go_on or status is SKIPPED:
                self._skipped += status is SKIPPED
                self._index += 1
                continue
            # What stands to the right belongs to an earlier round or has just been overtaken.
            self._reset_from(self._index + 1)
            if status is not RUNNING and not self.keeps_place:
                self._index = 0
            return status
        self._index = 0
        return SKIPPED if self._skipped == len(self.children) else self.go_on

    def _forget(self) -> None:
        self.current_child = None
        if not self.keeps_place:
            self._index = 0


class Sequence(_Line):
    """Succeeds when all children have; goes on at the running child; starts over on FAILURE."""

    go_on = SUCCESS


class SequenceWithMemory(Sequence):
    """Like Sequence, but goes on at the same child even after FAILURE or a halt."""

    keeps_place = True


class ReactiveSequence(Sequence):
    """Like Sequence, but ticks from the first child every time and halts what it overtakes."""

    reactive = True


class Fallback(_Line):
    """Fails when all children have; goes on at the running child."""

    go_on = FAILURE


class ReactiveFallback(Fallback):
    """Like Fallback, but ticks from the first child every time and halts what it overtakes."""

    reactive = True


def threshold(count: int, children: int) -> int:
    """How many children a Parallel's count means; negative counts from the end, -1 is all.

    Raises:
        TreeError: the count is larger than the number of children, or below its negative.

    >>> threshold(-1, 3), threshold(2, 3)
    (3, 2)
    """
    if not -children <= count <= children:
        raise TreeError(
            f"a Parallel with {children} children takes counts from {-children} to {children},"
            f" not {count}"
        )
    return children + count + 1 if count < 0 else count


class Parallel(ControlNode):
    """Ticks all children; M successes make SUCCESS, too many failures FAILURE (table 2.2).

    A child that has completed is not ticked again before the Parallel itself has. The thesis's
    "more than N - M children fail" follows from the first rule of failure below and holds
    whatever `failure_count` says; `failure_count` may only end it earlier.

    Args:
        name: the node's name.
        children: ticked from left to right.
        success_count: M; -1 is all children.
        failure_count: this many failures make FAILURE; -1 is all children.
    """

    def __init__(
        self,
        name: str,
        children: SequenceOf[Behaviour],
        success_count: Input,
        failure_count: Input,
    ) -> None:
        super().__init__(name, children)
        self._success_count, self._failure_count = success_count, failure_count
        self._completed: set[int] = set()
        self._succeeded = 0
        self._failed = 0

    def _route(self) -> Status:
        total = len(self.children)
        wanted: int = self._success_count.get()
        needed = threshold(wanted, total)
        allowed = threshold(self._failure_count.get(), total)
        if self.status is not RUNNING:
            self._reset_from(0)
        skipped = 0
        for i, child in enumerate(self.children):
            if i not in self._completed:
                child.tick_once()
                if child.status is SUCCESS:
                    self._completed.add(i)
                    self._succeeded += 1
                elif child.status is FAILURE:
                    self._completed.add(i)
                    self._failed += 1
                elif child.status is SKIPPED:
                    skipped += 1
            done = self._succeeded + (skipped if wanted < 0 else 0)
            if done >= needed:
                return self._end(SUCCESS)
            if total - self._failed < needed or self._failed == allowed:
                return self._end(FAILURE)
        return SKIPPED if skipped == total else RUNNING

    def _end(self, status: Status) -> Status:
        for child in self.children:
            if child.status is RUNNING:
                child.stop(Status.INVALID)
        self._forget()
        return status

    def _forget(self) -> None:
        self._completed.clear()
        self._succeeded = self._failed = 0


class Switch(ControlNode):
    """Ticks the child whose case equals the variable, or the last child, the default.

    When the choice changes, the child chosen before is halted even if it has completed: a new
    phase ends what is left of the old one's drives and looks (BehaviorTree.CPP has nothing left to
    end, since there a completed node owns no running command).
    """

    def __init__(
        self, name: str, children: SequenceOf[Behaviour], variable: Input, cases: SequenceOf[Input]
    ) -> None:
        super().__init__(name, children)
        self._variable, self._cases = variable, list(cases)
        self._chosen: int | None = None

    def _route(self) -> Status:
        chosen = self._choose()
        if self._chosen is not None and self._chosen != chosen:
            self.children[self._chosen].stop(Status.INVALID)
        self._chosen = chosen
        child = self.current_child = self.children[chosen]
        child.tick_once()
        return child.status

    def _choose(self) -> int:
        try:
            value = self._variable.get()
        except TreeError:  # not written yet: BehaviorTree.CPP takes the default
            return len(self._cases)
        for i, case in enumerate(self._cases):
            if same(value, case.get()):
                return i
        return len(self._cases)

    def _forget(self) -> None:
        self.current_child = None
        self._chosen = None


def same(a: Any, b: Any) -> bool:
    """Whether two values are equal as texts or as numbers: ``"1"``, ``1`` and ``"1.0"`` are."""
    if a == b:
        return True
    try:
        return float(a) == float(b)
    except (TypeError, ValueError):
        return False
