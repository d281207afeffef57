"""Decorators against BehaviorTree.CPP's rules."""

from __future__ import annotations

import pytest
from py_trees.common import Status
from trees.tree_fakes import STATUS, ScriptedLeaf, Stage, TeleportRobot

from kendon.trees import TickContext
from kendon.trees.decorators import (
    DecoratorNode,
    ForceFailure,
    ForceSuccess,
    Inverter,
    KeepRunningUntilFailure,
    Repeat,
    RetryUntilSuccessful,
    RunOnce,
    SubTree,
    Timeout,
)
from kendon.trees.ports import Input, Port, Scope
from kendon.trees.state import TreeState


def given(text: str, kind: str = "int") -> Input:
    return Input(Port("p", type=kind), text, Scope())


def answers(node: DecoratorNode, ticks: int) -> str:
    letters = {status: letter for letter, status in STATUS.items()}
    seen = ""
    for _ in range(ticks):
        node.tick_once()
        seen += letters[node.status]
    return seen


@pytest.mark.parametrize(
    ("node_class", "wanted"),
    [
        (Inverter, "FSRK"),
        (ForceSuccess, "SSRK"),
        (ForceFailure, "FFRK"),
        (SubTree, "SFRK"),
        (KeepRunningUntilFailure, "RFRR"),
    ],
)
def test_plain_decorators(node_class: type[DecoratorNode], wanted: str) -> None:
    assert answers(node_class(name="D", child=ScriptedLeaf("SFRK")), 4) == wanted


@pytest.mark.parametrize(
    "node_class", [Inverter, ForceSuccess, ForceFailure, SubTree, KeepRunningUntilFailure]
)
def test_plain_decorators_hand_a_halt_down(node_class: type[DecoratorNode]) -> None:
    child = ScriptedLeaf("R")
    node = node_class(name="D", child=child)
    node.tick_once()
    node.stop(Status.INVALID)
    assert (child.halts, child.status, node.status) == (1, Status.INVALID, Status.INVALID)


def test_repeat_gives_a_child_that_succeeds_at_once_one_round_a_tick() -> None:
    assert answers(Repeat("D", ScriptedLeaf("S"), given("3")), 4) == "RRSR"


def test_repeat_goes_on_in_the_same_tick_when_the_child_had_been_running() -> None:
    child = ScriptedLeaf("RSRSS")
    assert answers(Repeat("D", child, given("2")), 3) == "RRS"
    assert child.ticks == 4


def test_repeat_ends_with_the_first_failure_and_starts_over() -> None:
    assert answers(Repeat("D", ScriptedLeaf("SFSSS"), given("2")), 4) == "RFRS"


def test_repeat_for_ever_and_never() -> None:
    assert answers(Repeat("D", ScriptedLeaf("S"), given("-1")), 50) == "R" * 50
    never = ScriptedLeaf("S")
    assert answers(Repeat("D", never, given("0")), 1) == "S"
    assert never.ticks == 0


def test_retry_tries_again_and_gives_up() -> None:
    assert answers(RetryUntilSuccessful("D", ScriptedLeaf("FFS"), given("3")), 3) == "RRS"
    assert answers(RetryUntilSuccessful("D", ScriptedLeaf("F"), given("2")), 4) == "RFRF"
    assert answers(RetryUntilSuccessful("D", ScriptedLeaf("F"), given("-1")), 9) == "R" * 9
    assert answers(RetryUntilSuccessful("D", ScriptedLeaf("S"), given("0")), 1) == "F"


def test_a_halt_resets_the_count() -> None:
    node = Repeat("D", ScriptedLeaf("S"), given("2"))
    node.tick_once()
    node.stop(Status.INVALID)
    assert answers(node, 2) == "RS"


def test_run_once_skips_or_repeats_its_answer_even_after_a_halt() -> None:
    for then_skip, wanted in (("true", "RFKK"), ("false", "RFFF")):
        child = ScriptedLeaf("RFS")
        node = RunOnce("D", child, given(then_skip, "bool"))
        assert answers(node, 4) == wanted
        node.stop(Status.INVALID)
        assert answers(node, 1) == wanted[-1]
        assert child.ticks == 2


def test_timeout_runs_on_the_flows_clock() -> None:
    state, child = TreeState(), ScriptedLeaf("R")
    node = Timeout("D", child, given("300"), state)
    seen = ""
    for i in range(4):
        state.update(TickContext(i / 10, None, None, TeleportRobot()))
        seen += answers(node, 1)
    assert seen == "RRRF"
    assert (child.ticks, child.halts) == (3, 1)
    assert "0.3 s" in node.feedback_message


def test_timeout_of_zero_never_ends_and_a_quick_child_passes() -> None:
    stage = Stage('<Timeout msec="0"><WaitForXSeconds seconds="2"/></Timeout>')
    assert stage.run(None, 2.0) is Status.RUNNING
    assert stage.run(None, 0.1) is Status.SUCCESS


def test_an_unwritten_port_fails_the_decorator_with_its_sentence() -> None:
    stage = Stage('<Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat>')
    assert stage.run(None) is Status.FAILURE
    assert stage.message("Repeat") == ("port 'num_cycles' reads {n}, which no node has written yet")
