"""Models by name and from files: the thesis's numbers, and files that are not models."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import kendon
from kendon.errors import DataError, UnknownNameError
from kendon.models import DEFAULT_MODEL, load_model, model_names
from kendon.person import FloatArray

# Copied from the text of the thesis a second time, phase by phase: the tables of 3.4, in its
# units. Rows: transitions as printed, then distance [mm] speed [mm/s] gaze smile dsal csal hdip.
KENDON_TABLES: dict[str, tuple[list[float], list[float]]] = {
    "IA": ([2 / 3, 1 / 30, 0, 1 / 5, 1 / 15, 1 / 30], [7000, 0, 1, 1, 0, 0, 0]),
    "DS": ([0, 1 / 2, 1 / 4, 3 / 25, 3 / 25, 1 / 100], [5500, 1200, 0.5, 2, 1, 0, 0]),
    "HD": ([0, 0, 1 / 2, 19 / 40, 1 / 40, 0], [6500, 1200, 1.5, 1, 0, 0, 1]),
    "APP": ([0, 4 / 75, 0, 22 / 25, 1 / 15, 0], [5000, 1200, 1, 1, 0, 0, 0]),
    "FA": ([0, 1 / 25, 0, 0, 19 / 25, 1 / 5], [2250, 1200, 0.5, 2, 0, 0, 0]),
    "CS": ([0, 0, 0, 0, 0, 1], [1500, 0, 0.5, 2, 0, 1, 0]),
}

# The same numbers from the sentences of 3.4 rather than from its tables.
KENDON_SENTENCES = {
    (0, 0): 2 / 3,  # "P(IA|IA) = 2/3"
    (0, 1): 0.1 / 3,  # "P(DS|IA) = 0.1/3"
    (0, 3): 0.6 / 3,  # "P(APP|IA) = 0.6/3"
    (0, 4): 0.2 / 3,  # "P(FA|IA) = 0.2/3"
    (1, 1): 0.5,  # "a same-state transition probability of 0.5"
    (1, 3): 0.8 * 0.3 * 0.5,  # "P(APP|DS) = 0.8 * 0.3 * 0.5"
}

# The matrices of 3.5.3.
DATA_DRIVEN_A = """
0.608 0.144 0     0.030 0.218 0
0     0.625 0.075 0     0.300 0
0     0     0.400 0.198 0.402 0
0.066 0     0     0.631 0.303 0
0     0.051 0     0     0.673 0.277
0     0     0     0     0     1
"""
DATA_DRIVEN_M = """
2068 99   1.47 1.33 0 0 0
1617 142  0.80 1.89 1 0 0
1635 256  1.26 1.40 0 0 1
2771 1896 0.97 1.77 0 0 0
1569 389  0.68 1.73 0 0 0
1083 131  0.57 1.91 0 1 0
"""
DATA_DRIVEN_PI = [0.929, 0, 0, 0.071, 0, 0]

TO_SI = np.array([1e-3, 1e-3, 1, 1, 1, 1, 1])


def matrix(text: str) -> FloatArray:
    return np.array([[float(cell) for cell in line.split()] for line in text.strip().splitlines()])


def test_the_kendon_model_is_the_tables_of_the_thesis() -> None:
    model = load_model("kendon")
    rows = list(KENDON_TABLES.values())
    np.testing.assert_allclose(model.transmat, [row for row, _ in rows], atol=1e-12)
    np.testing.assert_allclose(model.means, np.array([m for _, m in rows]) * TO_SI, atol=1e-12)
    assert model.startprob.tolist() == [1, 0, 0, 0, 0, 0]
    for place, value in KENDON_SENTENCES.items():
        assert model.transmat[place] == pytest.approx(value)


def test_the_data_driven_model_is_the_matrices_of_the_thesis() -> None:
    model = load_model("data-driven")
    A = matrix(DATA_DRIVEN_A)
    for row in (0, 1, 2, 3, 5):
        assert A[row].sum() == pytest.approx(1, abs=1e-12)
        np.testing.assert_allclose(model.transmat[row], A[row], atol=1e-12)
    # The fifth row sums to 1.001 in print: the proportions are kept.
    assert A[4].sum() == pytest.approx(1.001, abs=1e-12)
    np.testing.assert_allclose(model.transmat[4], A[4] / 1.001, atol=1e-12)
    np.testing.assert_allclose(model.means, matrix(DATA_DRIVEN_M) * TO_SI, atol=1e-12)
    np.testing.assert_allclose(model.startprob, DATA_DRIVEN_PI, atol=1e-12)


@pytest.mark.parametrize("name", model_names())
def test_published_models_are_models_in_si_units(name: str) -> None:
    model = load_model(name)
    assert model.name == name
    assert model.title
    assert "thesis 3." in model.source or "scripts/train_default.py" in model.source
    np.testing.assert_allclose(model.transmat.sum(axis=1), 1, atol=1e-15)
    assert model.startprob.sum() == pytest.approx(1, abs=1e-15)
    # Nobody greets from a kilometre: a forgotten conversion from millimetres would show.
    assert model.means[:, 0].max() < 10
    assert model.variances[:, 0].max() < 10


def test_the_variances_are_the_documented_deviations_squared() -> None:
    model = load_model("kendon")
    deviations = np.sqrt(model.variances)
    np.testing.assert_allclose(deviations[:, 0], [2.9, 2.02, 2.02, 1.15, 0.43, 0.5])
    np.testing.assert_allclose(deviations[:, 1], [0.15, 0.4, 0.4, 0.4, 0.4, 0.15])
    np.testing.assert_allclose(deviations[:, 2:], [[0.5, 0.83, 0.2, 0.2, 0.2]] * 6)


def test_names_and_default() -> None:
    assert model_names() == ["data-driven", "kendon", "trained"]
    assert DEFAULT_MODEL == "trained"
    assert load_model().name == "trained"
    assert kendon.load_model is load_model


@pytest.mark.parametrize("name", ["kendn", "data_driven", "no/such/model", "", "x" * 5000, "a\0b"])
def test_an_unknown_name_answers_with_those_that_exist(name: str) -> None:
    with pytest.raises(
        UnknownNameError, match=r"valid: data-driven, kendon, trained, or a path"
    ) as caught:
        load_model(name)
    assert caught.value.name == name


def test_published_models_are_read_once_and_cannot_be_changed() -> None:
    model = load_model("kendon")
    assert load_model("kendon") is model
    for field in ("startprob", "transmat", "means", "variances"):
        assert not getattr(model, field).flags.writeable


def test_a_near_miss_is_asked_back() -> None:
    with pytest.raises(UnknownNameError, match=r"did you mean 'kendon'\?"):
        load_model("Kendon")


# ---- files


def published_text() -> str:
    folder = resources.files("kendon.models") / "published"
    return (folder / "kendon.toml").read_text(encoding="utf-8")


def test_a_copy_of_a_published_file_is_the_same_model(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(published_text(), encoding="utf-8")
    mine, published = load_model(path), load_model("kendon")
    assert mine.name == "mine"
    for field in ("startprob", "transmat", "means", "variances"):
        assert getattr(mine, field).tolist() == getattr(published, field).tolist()
    assert load_model(str(path)).name == "mine"


def test_a_file_may_be_in_metres_begin_with_a_mark_and_have_any_suffix(tmp_path: Path) -> None:
    path = tmp_path / "mine.txt"
    text = published_text().replace('length_unit = "mm"\n', "")
    path.write_text(text, encoding="utf-8-sig")
    assert load_model(path).means[0, 0] == 7000  # metres where nothing is said


WRONG: dict[str, tuple[Callable[[str], str], str]] = {
    "torn": (lambda s: s[: len(s) // 2], "needs standard_deviations as well"),
    "torn in a list": (lambda s: s[: s.index("means = [") + 20], "not a readable model file"),
    "empty": (lambda _: "", "needs phases, features, startprob, transmat, means"),
    "no toml": (lambda _: "greetings, robot", "not a readable model file"),
    "nested for ever": (lambda _: "a = " + "[" * 5000, "not a readable model file"),
    "a key less": (lambda s: s.replace("means =", "mean ="), "needs means as well"),
    "a key misspelt": (
        lambda s: s.replace("length_unit", "length_units"),
        "there is no key 'length_units'; valid: .* did you mean 'length_unit'",
    ),
    "a phase less": (
        lambda s: s.replace('"HD", ', ""),
        "phases must be IA, DS, HD, APP, FA, CS in this order",
    ),
    "phases a number": (lambda s: s.replace('phases = ["IA", "DS", "HD", "APP", "FA", "CS"]',
                        "phases = 6"), "phases must be IA, DS, HD, APP, FA, CS in this order"),
    "features in another order": (
        lambda s: s.replace('"distance", "speed"', '"speed", "distance"'),
        "features must be distance, speed, gaze, smile, dsal, csal, hdip in this order",
    ),
    "another unit": (lambda s: s.replace('"mm"', '"cm"'), "length_unit is 'cm'; valid: m, mm"),
    "units in a list": (lambda s: s.replace('"mm"', '["m"]'), "valid: m, mm"),
    "a row short": (lambda s: s.replace('"1/5", "1/15", "1/30"]', '"1/5", "1/15"]'),
                    "transmat must hold finite numbers .* rows of equal length"),
    "a word for a number": (lambda s: s.replace('"2/3"', '"two thirds"'), "transmat must hold"),
    "divided by zero": (lambda s: s.replace('"2/3"', '"2/0"'), "transmat must hold"),
    "a truth for a number": (lambda s: s.replace("= [1, 0", "= [true, 0"), "startprob must hold"),
    "a date for a number": (lambda s: s.replace("[1, 0", "[1979-05-27, 0"), "startprob must hold"),
    "too long a number": (lambda s: s.replace("[1, 0", f"[{'9' * 400}, 0"), "startprob must hold"),
    "not a number": (lambda s: s.replace("[7000,", "[nan,"), "means must hold finite numbers"),
    "infinite": (lambda s: s.replace("[7000,", "[-inf,"), "means must hold finite numbers"),
    "a vector too short": (lambda s: s.replace("= [1, 0, 0, 0, 0, 0]", "= [1, 0, 0, 0, 0]"),
                           r"startprob has shape \(5,\) instead of \(6,\)"),
    "one number for all deviations": (
        lambda s: s[: s.index("standard_deviations = [")] + "standard_deviations = 0.5",
        r"standard_deviations has shape \(\) instead of \(6, 7\)",
    ),
    "a negative probability": (lambda s: s.replace('["2/3", "1/30"', '["11/15", "-1/30"'),
                               "transmat holds a negative probability, -0.0333"),
    "a row that does not sum to one": (
        lambda s: s.replace('"2/3"', '"1/3"'),
        r"transmat must hold probabilities that sum to 1 in each row, not \[0.6667 1",
    ),
    "a zero deviation": (lambda s: s.replace("[2900, 150", "[2900, 0"), "must be positive"),
    "a negative deviation": (lambda s: s.replace("[2900, 150", "[2900, -1"), "must be positive"),
    "a deviation that vanishes": (lambda s: s.replace("[2900", "[1e-200"), "must be positive"),
    "a deviation beyond numbers": (lambda s: s.replace("[2900", "[1e200"), "variances .* finite"),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRONG)
def test_a_file_that_is_not_a_model_is_refused_in_one_sentence(kind: str, tmp_path: Path) -> None:
    spoil, reason = WRONG[kind]
    text = spoil(published_text())
    assert text != published_text()
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=reason) as caught:
        load_model(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_binary_file_a_folder_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    binary = tmp_path / "model.toml"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    for path, reason in (
        (binary, "not a readable model file"),
        (tmp_path, "this is a folder, not a model file"),
        (tmp_path / "none.toml", "there is no such model file"),
    ):
        with pytest.raises(DataError, match=reason) as caught:
            load_model(path)
        assert caught.value.file == str(path)


def test_a_mistake_in_a_row_of_the_transitions_can_be_within_the_thesis_rounding(
    tmp_path: Path,
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(published_text().replace('"2/3"', "0.668"), encoding="utf-8")
    total = 0.668 + 1 / 30 + 1 / 5 + 1 / 15 + 1 / 30
    assert load_model(path).transmat[0, 0] == pytest.approx(0.668 / total)
