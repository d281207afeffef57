"""Models as readers: those with a name, and those that learn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evaluation_data import walk_up

from kendon import load_model
from kendon.errors import ParameterError, UnknownNameError
from kendon.estimate import Decoder
from kendon.evaluation import learned_readers, model_readers
from kendon.models import save_model


def test_a_reader_reads_what_its_model_does() -> None:
    greeting = walk_up("ann")
    model = load_model("kendon")
    by_filter, by_path, *_ = model_readers(["kendon"])
    beliefs = model.filter(greeting.values)
    np.testing.assert_array_equal(by_filter.read(greeting), beliefs.argmax(axis=1) + 1)
    np.testing.assert_array_equal(by_path.read(greeting), model.decode(greeting.values))
    assert (by_filter.causal, by_path.causal) == (True, False)


def test_models_are_read_once_and_the_published_ones_join(tmp_path: Path) -> None:
    save_model(load_model("kendon"), tmp_path / "mine.toml")
    mine = str(tmp_path / "mine.toml")
    readers = model_readers([mine, "data-driven", mine], [Decoder.FILTER])
    names = [reader.name for reader in readers]
    assert names == ["mine (filter)", "data-driven (filter)", "kendon (filter)"]


def test_models_that_no_table_could_tell_apart_are_refused(tmp_path: Path) -> None:
    save_model(load_model("data-driven"), tmp_path / "kendon.toml")
    with pytest.raises(ParameterError, match="two of the models are called 'kendon'"):
        model_readers([str(tmp_path / "kendon.toml")])
    with pytest.raises(UnknownNameError, match="kendom"):
        model_readers(["kendom"])


def test_learned_readers_know_what_they_have_learned() -> None:
    greetings = [walk_up(f"greeting {i}", 3.5 + 0.5 * i) for i in range(6)]
    readers = learned_readers(greetings, 0, [Decoder.FILTER])
    assert [reader.name for reader in readers] == [
        "learned robust (filter)", "learned gaussian (filter)", "learned unlabelled (filter)",
    ]  # fmt: skip
    for reader in readers[:2]:
        right = [(reader.read(g) == g.phases).mean() for g in greetings]
        assert np.mean(right) > 0.9
    # Without labels, what the labels are makes no difference.
    shuffled = [replace(g, phases=np.roll(g.phases, 3)) for g in greetings if g.phases is not None]
    again = learned_readers(shuffled, 0, [Decoder.FILTER])
    for one in greetings:
        np.testing.assert_array_equal(readers[2].read(one), again[2].read(one))
