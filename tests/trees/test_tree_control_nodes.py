"""Control nodes against table 2.2 of the thesis and BehaviorTree.CPP's rules, enumerated."""

from __future__ import annotations

import itertools

import pytest
from py_trees.common import Status
from trees.tree_fakes import STATUS, ScriptedLeaf, scripted

from kendon.errors import TreeError
from kendon.trees.control import (
    ControlNode,
    Fallback,
    Parallel,
    ReactiveFallback,
    ReactiveSequence,
    Sequence,
    SequenceWithMemory,
    Switch,
    same,
    threshold,
)
from kendon.trees.ports import Entry, Input, Port, Scope

Line = type[Sequence] | type[Fallback]
LINES: list[tuple[Line, str]] = [
    (Sequence, "S"),
    (SequenceWithMemory, "S"),
    (ReactiveSequence, "S"),
]
LINES += [(Fallback, "F"), (ReactiveFallback, "F")]


def number(value: int) -> Input:
    return Input(Port("count", type="int"), str(value), Scope())


def parallel(scripts: list[str], success: int, failure: int) -> Parallel:
    return Parallel("P", scripted(scripts), number(success), number(failure))


def ticks(node: ControlNode) -> list[int]:
    return [leaf.ticks for leaf in node.children if isinstance(leaf, ScriptedLeaf)]


def halts(node: ControlNode) -> list[int]:
    return [leaf.halts for leaf in node.children if isinstance(leaf, ScriptedLeaf)]


def combos(*sizes: int) -> list[tuple[str, ...]]:
    return [c for n in sizes for c in itertools.product("SFR", repeat=n)]


@pytest.mark.parametrize(("node_class", "go_on"), LINES)
@pytest.mark.parametrize("letters", combos(1, 2, 3, 4))
def test_first_tick_of_lines_follows_table_2_2(
    node_class: Line, go_on: str, letters: tuple[str, ...]
) -> None:
    leaves = scripted(letters)
    node = node_class("N", leaves)
    node.tick_once()
    stop = next((i for i, letter in enumerate(letters) if letter != go_on), None)
    assert node.status is STATUS[go_on if stop is None else letters[stop]]
    ticked = len(letters) if stop is None else stop + 1
    assert [leaf.ticks for leaf in leaves] == [1] * ticked + [0] * (len(letters) - ticked)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_parallel_follows_table_2_2_for_every_m(n: int) -> None:
    for m in range(1, n + 1):
        for letters in itertools.product("SFR", repeat=n):
            node = parallel(list(letters), m, -1)
            node.tick_once()
            if letters.count("S") >= m:
                wanted = Status.SUCCESS
            elif letters.count("F") > n - m:
                wanted = Status.FAILURE
            else:
                wanted = Status.RUNNING
            assert node.status is wanted, (m, letters)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_parallel_thresholds_exhaustively(n: int) -> None:
    counts = [c for c in range(-n, n + 1) if c]
    for success, failure in itertools.product(counts, counts):
        needed = success if success > 0 else n + success + 1
        allowed = failure if failure > 0 else n + failure + 1
        for letters in itertools.product("SFR", repeat=n):
            wanted, ticked = Status.RUNNING, n
            for i in range(1, n + 1):  # decided after each child, from left to right
                won, lost = letters[:i].count("S"), letters[:i].count("F")
                if won >= needed:
                    wanted, ticked = Status.SUCCESS, i
                    break
                if lost >= allowed or n - lost < needed:
                    wanted, ticked = Status.FAILURE, i
                    break
            node = parallel(list(letters), success, failure)
            node.tick_once()
            assert node.status is wanted, (success, failure, letters)
            assert ticks(node) == [1] * ticked + [0] * (n - ticked)


def test_parallel_does_not_tick_a_completed_child_until_it_ends_itself() -> None:
    node = parallel(["S", "RRS"], 2, 1)
    for _ in range(3):
        node.tick_once()
    assert node.status is Status.SUCCESS
    assert ticks(node) == [1, 3]
    node.tick_once()
    assert ticks(node) == [2, 4]


def test_parallel_halts_what_still_runs_when_it_ends() -> None:
    node = parallel(["R", "S"], 1, -1)
    node.tick_once()
    assert node.status is Status.SUCCESS
    assert halts(node) == [1, 0]


def test_halted_parallel_forgets_its_completed_children() -> None:
    node = parallel(["S", "R"], 2, 1)
    node.tick_once()
    node.stop(Status.INVALID)
    node.tick_once()
    assert ticks(node) == [2, 2]


def test_threshold_range() -> None:
    assert [threshold(v, 3) for v in (-3, -2, -1, 0, 3)] == [1, 2, 3, 0, 3]
    for bad in (-4, 4):
        with pytest.raises(TreeError, match="from -3 to 3"):
            threshold(bad, 3)


def test_parallel_with_a_threshold_from_the_blackboard_out_of_range_fails() -> None:
    scope = Scope()
    scope.entry("m").value = 5
    count = Input(Port("success_count", type="int"), "{m}", scope)
    node = Parallel("P", scripted("SS"), count, number(1))
    node.tick_once()
    assert node.status is Status.FAILURE
    assert "from -2 to 2" in node.feedback_message


def counts(node: ControlNode, rounds: int) -> list[int]:
    for _ in range(rounds):
        node.tick_once()
    return ticks(node)


def test_memory_against_reactive_while_running() -> None:
    assert counts(Sequence("N", scripted(["S", "R", "S"])), 3) == [1, 3, 0]
    assert counts(SequenceWithMemory("N", scripted(["S", "R", "S"])), 3) == [1, 3, 0]
    assert counts(ReactiveSequence("N", scripted(["S", "R", "S"])), 3) == [3, 3, 0]
    assert counts(Fallback("N", scripted(["F", "R", "F"])), 3) == [1, 3, 0]
    assert counts(ReactiveFallback("N", scripted(["F", "R", "F"])), 3) == [3, 3, 0]


def test_memory_against_plain_after_failure() -> None:
    assert counts(Sequence("N", scripted(["S", "F", "S"])), 3) == [3, 3, 0]
    assert counts(SequenceWithMemory("N", scripted(["S", "F", "S"])), 3) == [1, 3, 0]
    assert counts(ReactiveSequence("N", scripted(["S", "F", "S"])), 3) == [3, 3, 0]


@pytest.mark.parametrize(("node_class", "again"), [(Sequence, 2), (SequenceWithMemory, 1)])
def test_memory_after_a_halt(node_class: type[Sequence], again: int) -> None:
    node = node_class("N", scripted(["S", "R"]))
    node.tick_once()
    node.stop(Status.INVALID)
    node.tick_once()
    assert ticks(node) == [again, 2]


@pytest.mark.parametrize("change", ["R", "F"])
def test_reactive_sequence_halts_what_it_overtakes(change: str) -> None:
    node = ReactiveSequence("N", scripted([f"S{change}", "R"]))
    node.tick_once()
    node.tick_once()
    assert node.status is STATUS[change]
    assert halts(node) == [0, 1]


@pytest.mark.parametrize("change", ["R", "S"])
def test_reactive_fallback_halts_what_it_overtakes(change: str) -> None:
    node = ReactiveFallback("N", scripted([f"F{change}", "R"]))
    node.tick_once()
    node.tick_once()
    assert node.status is STATUS[change]
    assert halts(node) == [0, 1]


def test_every_line_starts_over_after_it_has_completed() -> None:
    for node_class, go_on in LINES:
        node = node_class("N", scripted([go_on, go_on]))
        assert counts(node, 3) == [3, 3]


@pytest.mark.parametrize(("node_class", "go_on"), LINES)
def test_skipped_children_are_passed_over(node_class: Line, go_on: str) -> None:
    node = node_class("N", scripted(["K", go_on]))
    node.tick_once()
    assert node.status is STATUS[go_on]
    all_skipped = node_class("N", scripted(["K", "K"]))
    all_skipped.tick_once()
    assert all_skipped.status is Status.INVALID


def test_skipped_children_count_only_for_a_negative_success_count() -> None:
    node = parallel(["K", "S"], -1, 1)
    node.tick_once()
    assert node.status is Status.SUCCESS
    node = parallel(["K", "S"], 2, 1)
    node.tick_once()
    assert node.status is Status.RUNNING


def switch(scripts: list[str], cases: list[str]) -> tuple[Switch, Entry]:
    scope = Scope()
    port = Port("variable", type="any")
    inputs = [Input(port, case, scope) for case in cases]
    return Switch("S", scripted(scripts), Input(port, "{v}", scope), inputs), scope.entry("v")


def test_switch_chooses_by_text_and_by_number_and_else_the_default() -> None:
    node, variable = switch(["S", "S", "S"], ["1", "two"])
    for value in (1, "1", "1.0", 1.0, "two", "three", 2):
        variable.value = value
        node.tick_once()
    assert ticks(node) == [4, 1, 2]


def test_switch_takes_the_default_while_the_variable_is_unset() -> None:
    node, _ = switch(["S", "S"], ["1"])
    node.tick_once()
    assert ticks(node) == [0, 1]


def test_switch_halts_the_child_it_leaves() -> None:
    node, variable = switch(["R", "R", "R"], ["1", "2"])
    variable.value = "1"
    node.tick_once()
    variable.value = "2"
    node.tick_once()
    assert halts(node) == [1, 0, 0]
    assert node.children[0].status is Status.INVALID
    node.stop(Status.INVALID)
    assert halts(node) == [1, 1, 0]


def test_same() -> None:
    assert same("1", 1)
    assert same("a", "a")
    assert not same("a", 1)
    assert not same(None, "1")


def test_py_trees_visitors_see_the_ticked_nodes() -> None:
    node = Sequence("N", scripted(["S", "R", "S"]))
    assert [n.name for n in node.tick()] == ["S", "R", "N"]
