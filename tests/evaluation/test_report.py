"""The evaluation as a whole: its numbers for programs, its page, its figures."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from evaluation_data import Scripted, pass_by, unknown, walk_up

from kendon.errors import DataError, ParameterError
from kendon.evaluation import (
    BASELINES,
    Evaluation,
    Spread,
    evaluate,
    model_readers,
    sort_material,
)
from kendon.evaluation.figures import draw_figures
from kendon.evaluation.report import page, write_report
from kendon.phases import PHASE_NAMES, Phase

VOID = {"meta", "br", "link", "img", "input", "hr"}


class Page(HTMLParser):
    """A page's elements; every one that is opened must be closed in its turn."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def whole() -> Evaluation:
    """Three greetings, a passer-by with a spiteful name, somebody unlabelled, splits."""
    people = [walk_up(f"greeting {i}", 3.0 + i) for i in range(3)]
    spiteful = pass_by("<script>alert('bob')</script>")
    material = sort_material([*people, spiteful, replace(walk_up("who"), phases=None)])
    readers = [*model_readers(["kendon"]), *BASELINES]
    spreads = {"learned": Spread(np.array([0.5, 0.7])), "once": Spread(np.array([0.5]))}
    return replace(
        evaluate(material, readers, seed=7),
        command="kendon evaluate 'my folder' --seed 7",
        gestures_from_phases=True,
        spreads=spreads,
    )


@pytest.fixture(scope="module")
def evaluation() -> Evaluation:
    return whole()


# ---- what is evaluated


def test_greetings_passers_by_and_unlabelled_are_told_apart() -> None:
    greeting, mixed, passing, partly, nothing = (
        unknown(letters, letters) for letters in ("IAFC", "--AF", "----", "?--?", "????")
    )
    bare = replace(nothing, phases=None)
    material = sort_material([nothing, passing, greeting, bare, mixed, partly])
    assert material.greetings == (greeting, mixed)
    assert material.passersby == (passing, partly)
    assert material.unlabelled == (nothing, bare)


def test_without_any_labels_there_is_nothing_to_evaluate() -> None:
    with pytest.raises(DataError, match="no greeting with true phases"):
        sort_material([unknown("----"), unknown("????")])


def test_results_by_hand() -> None:
    material = sort_material([unknown("IIAACC", "a"), unknown("AAFF", "b"), unknown("---", "p")])
    perfect = Scripted("perfect")
    wrong = Scripted("wrong", (("a", "IIAAFF"), ("b", "AAAF"), ("p", "ACA")))
    first, second = evaluate(material, [perfect, wrong]).results
    assert first.accuracy == (1, 1, 1)
    assert first.difference is None
    assert second.accuracy.value == 0.7
    assert second.difference is not None
    assert second.difference.value == pytest.approx(-0.3)
    assert (second.transitions.true, second.transitions.found) == (3, 2)
    missed, late = second.delays(Phase.CS), second.delays(Phase.FA)
    assert missed == pytest.approx((1, 1, math.nan), nan_ok=True)
    assert late == pytest.approx((1, 0, 0.2))
    np.testing.assert_allclose(second.mean_shares, [0, 0, 0, 2 / 3, 0, 1 / 3])
    assert (second.ever(Phase.CS), second.ever(Phase.DS)) == (1, 0)
    assert second.tally.accuracy([0]) == pytest.approx(4 / 6)


def test_published_models_and_baselines_are_in_every_comparison(evaluation: Evaluation) -> None:
    names = [result.name for result in evaluation.results]
    assert names == [
        "kendon (filter)", "kendon (viterbi)", "data-driven (filter)", "data-driven (viterbi)",
        "state machine", "zones",
    ]  # fmt: skip
    assert [r.causal for r in evaluation.results] == [True, False, True, False, True, True]
    assert evaluation.results[0].accuracy.value > 0.9  # a textbook greeting


def test_readers_need_different_names() -> None:
    material = sort_material([unknown("IA")])
    with pytest.raises(ParameterError, match="different names"):
        evaluate(material, [Scripted("one"), Scripted("one")])


# ---- for programs


def test_the_layout_of_the_numbers_stays(evaluation: Evaluation) -> None:
    record = json.loads(json.dumps(evaluation.record(), allow_nan=False))
    assert list(record) == [
        "format", "kendon", "command", "settings", "data", "phases", "reference", "readers",
        "splits",
    ]  # fmt: skip
    assert record["format"] == 1
    assert list(record["settings"]) == [
        "seed", "sensor", "gestures_from_phases", "bootstrap_resamples", "entry_grace_s",
        "transition_tolerance_s",
    ]  # fmt: skip
    assert list(record["data"]) == ["greetings", "passersby", "unlabelled"]
    assert list(record["data"]["greetings"][0]) == ["name", "observations", "labelled"]
    assert record["phases"] == list(PHASE_NAMES)
    reader = record["readers"][1]
    assert list(reader) == [
        "name", "causal", "accuracy", "difference", "macro_f1", "phases", "confusion",
        "transitions", "passersby", "greetings",
    ]  # fmt: skip
    assert list(reader["accuracy"]) == list(reader["difference"]) == ["value", "low", "high"]
    assert list(reader["phases"]) == list(PHASE_NAMES)
    assert list(reader["phases"]["IA"]) == [
        "observations", "recall", "precision", "f1", "entries", "entries_missed", "median_delay_s",
    ]  # fmt: skip
    assert list(reader["transitions"]) == ["true", "read", "found", "recall", "precision"]
    assert list(reader["passersby"]) == ["shares", "ever_DS", "ever_CS"]
    assert list(reader["greetings"][0]) == ["name", "accuracy"]
    assert record["readers"][0]["difference"] is None
    assert reader["phases"]["DS"]["recall"] is None  # never happened: unknown, not 0
    assert list(record["splits"]) == ["number", "test_share", "readers"]
    assert record["splits"]["readers"][0] == {
        "name": "learned", "mean": pytest.approx(0.6), "deviation": pytest.approx(0.1 * 2**0.5),
        "accuracies": [0.5, 0.7],
    }  # fmt: skip
    assert record["splits"]["readers"][1]["deviation"] is None


def test_without_splits_and_passers_by_there_are_none() -> None:
    record = evaluate(sort_material([unknown("IA")]), [Scripted("one")]).record()
    assert record["splits"] is None
    assert record["readers"][0]["passersby"] is None
    assert record["readers"][0]["accuracy"] == {"value": 1.0, "low": None, "high": None}


# ---- for people


def test_the_page_needs_nothing_else(evaluation: Evaluation) -> None:
    text = page(evaluation)
    assert not re.search(r"https?:|//[a-z]|url\(|@import|javascript:", text, re.IGNORECASE)
    tags = {tag for tag, _ in Page(text).elements}
    assert tags.isdisjoint({"script", "link", "img", "iframe", "object", "embed", "use", "image"})
    for _, attributes in Page(text).elements:
        assert attributes.keys().isdisjoint({"src", "href", "xlink:href", "onclick", "onload"})


def test_the_page_tells_everything(evaluation: Evaluation) -> None:
    parsed = Page(page(evaluation))
    words = " ".join(parsed.texts)
    for result in evaluation.results:
        assert result.name in words
        assert f"{result.accuracy.value:.3f}" in words
    # Every person has a timeline of every reader, also the one whose name is no name.
    drawings = [a.get("aria-label") or "" for tag, a in parsed.elements if tag == "svg"]
    for one in (*evaluation.material.greetings, *evaluation.material.passersby):
        timelines = [d for d in drawings if d.startswith(f"{one.name}: true phases")]
        assert len(timelines) == len(evaluation.results)
        assert one.name in words
    assert sum(d.startswith("confusion matrix") for d in drawings) == len(evaluation.results)
    for fact in ("kendon evaluate 'my folder' --seed 7", "who", "by hand", "0.600 ± 0.141", "[s]"):
        assert fact in words


def test_a_phase_has_its_colour_everywhere(evaluation: Evaluation) -> None:
    rects = re.findall(r'fill="(#\w+)"[^>]*><title>\w+: (\w+) ', page(evaluation))
    assert {name for _, name in rects} >= {"IA", "APP", "FA", "CS"}
    for color, name in rects:
        assert color == Phase[name].color


def test_the_same_evaluation_makes_the_same_page_and_numbers(evaluation: Evaluation) -> None:
    again = whole()
    assert page(again) == page(evaluation)
    assert again.record() == evaluation.record()


@pytest.mark.parametrize("letters", ["A", "IA", "I?-A"])
def test_the_smallest_material_makes_a_page(letters: str, tmp_path: Path) -> None:
    evaluation = evaluate(sort_material([unknown(letters, "tiny")]), [Scripted("one")])
    write_report(evaluation, tmp_path / "new" / "report.html")
    words = " ".join(Page((tmp_path / "new" / "report.html").read_text()).texts)
    assert "tiny" in words
    assert "nan" not in words


def test_long_greetings_have_an_axis_that_can_be_read() -> None:
    long = unknown("I" * 3000 + "A" * 3000, "long")  # 20 minutes
    text = page(evaluate(sort_material([long]), [Scripted("one")]))
    timeline = re.search(r'aria-label="long: true.*?</svg>', text, re.DOTALL)
    assert timeline is not None
    assert 3 <= timeline.group().count('class="grid"') <= 9


# ---- for papers


def test_figures_are_drawn_once_as_picture_and_once_as_lines(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    small = Evaluation(evaluation.material, evaluation.results[:1], seed=0)
    files = draw_figures(small, tmp_path / "figures")
    assert sorted(files) == sorted((tmp_path / "figures").iterdir())
    names = {file.stem for file in files}
    assert names == {
        "accuracy", "recall", "confusion_kendon_filter", "timelines_kendon_filter",
    }  # fmt: skip
    for file in files:
        start = b"\x89PNG" if file.suffix == ".png" else b"<?xml"
        assert file.read_bytes().startswith(start)
    assert "time [s]" in (tmp_path / "figures" / "timelines_kendon_filter.svg").read_text()


def test_a_phase_that_never_happens_has_no_recall_rather_than_one_of_0(tmp_path: Path) -> None:
    draw_figures(evaluate(sort_material([unknown("IA", "two")]), [Scripted("one")]), tmp_path)
    text = (tmp_path / "recall.svg").read_text(encoding="utf-8")
    assert text.count(">–<") == 4  # I and A happen


def test_figures_of_readers_that_look_alike_do_not_overwrite_each_other(tmp_path: Path) -> None:
    material = sort_material([unknown("IA", "two")])
    evaluation = evaluate(material, [Scripted("a b"), Scripted("A/b")])
    files = draw_figures(evaluation, tmp_path)
    assert len(set(files)) == len(files) == 2 * (2 + 2 * 2)
