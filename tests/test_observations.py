"""Observations as rows, arrays and a CSV file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from people import assert_one_sentence, tracks

from kendon.errors import DataError, ParameterError
from kendon.features import observe
from kendon.observations import (
    FEATURES,
    UNITS,
    Observation,
    Observations,
    read_observations,
    write_observations,
)
from kendon.person import Track

HEADER = "t,distance,speed,gaze,smile,dsal,csal,hdip,phase"
ROW = ["2", "1.5", "0.4", "1", "0", "0.5", "1", "DS"]


def file_with(path: Path, changes: dict[tuple[int, str], str]) -> Path:
    """Ten observations; cells changed by row, as an editor counts, and column."""
    columns = HEADER.split(",")
    rows = [columns, *([f"{k / 5:g}", *ROW] for k in range(1, 11))]
    for (row, column), value in changes.items():
        rows[row - 1][columns.index(column)] = value
    path.write_text("\n".join(map(",".join, rows)), encoding="utf-8")
    return path


def test_the_features_and_their_units() -> None:
    assert FEATURES == ("distance", "speed", "gaze", "smile", "dsal", "csal", "hdip")
    assert tuple(UNITS) == FEATURES
    assert Observation._fields == ("t", *FEATURES)


def test_an_observation_is_unknown_but_for_its_time() -> None:
    assert np.isnan(Observation(1.0).values).all()
    assert Observation(1.0, 2.0, gaze=0.5).values.shape == (7,)


def test_rows_in_rows_out() -> None:
    rows = [Observation(0.2, 3.0, math.nan, 0.1, 2.0, 1.0, 0.0, 0.5), Observation(0.4, 2.0)]
    table = Observations.from_rows(rows, "a")
    assert (len(table), table.name, table.values.shape) == (2, "a", (2, 7))
    for row, again in zip(rows, table, strict=True):
        np.testing.assert_array_equal(row, again)
    assert Observations.from_rows([]).values.shape == (0, 7)


@pytest.mark.parametrize(
    ("t", "values", "phases"),
    [(3, (2, 7), None), (2, (2, 6), None), (2, (14,), None), (2, (2, 7), 3)],
)
def test_shapes_that_do_not_fit_are_refused(
    t: int, values: tuple[int, ...], phases: int | None
) -> None:
    with pytest.raises(ParameterError, match="observations need"):
        Observations(
            np.zeros(t), np.zeros(values), None if phases is None else np.zeros(phases, dtype=int)
        )


@settings(max_examples=50)
@given(tracks())
def test_written_observations_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, track: Track
) -> None:
    path = tmp_path_factory.getbasetemp() / "observed.csv"
    seen = observe(track)
    write_observations(seen, path)
    again = read_observations(path)
    np.testing.assert_allclose(again.t, seen.t, rtol=0, atol=1e-6)
    np.testing.assert_allclose(again.values, seen.values, atol=2e-6)
    np.testing.assert_array_equal(again.phases, seen.phases)
    assert again.name == "observed"


def test_without_phases_there_is_no_phase_column(tmp_path: Path) -> None:
    path = tmp_path / "o.csv"
    write_observations(Observations.from_rows([Observation(0.2, 1.25)]), path)
    header = "t,distance,speed,gaze,smile,dsal,csal,hdip"
    assert path.read_text(encoding="utf-8") == f"{header}\n0.2,1.25,,,,,,\n"
    assert read_observations(path).phases is None


WRONG: dict[str, tuple[dict[tuple[int, str], str], int, str, str]] = {
    "millimetres": ({(3, "distance"): "2000"}, 3, "distance", "are these millimetres"),
    "behind the robot": ({(3, "distance"): "-1"}, 3, "distance", "-1 is not between 0 and 100"),
    "millimetres a second": ({(9, "speed"): "-1400"}, 9, "speed", "are these millimetres"),
    "gaze": ({(4, "gaze"): "-0.1"}, 4, "gaze", "-0.1 is not at least 0"),
    "smile": ({(2, "smile"): "5.5"}, 2, "smile", "5.5 is not between 0 and 5"),
    "probability": ({(11, "hdip"): "1.01"}, 11, "hdip", "1.01 is not between 0 and 1"),
    "word": ({(5, "csal"): "yes"}, 5, "csal", "'yes' is not a number"),
    "infinite": ({(5, "gaze"): "inf"}, 5, "gaze", "infinite"),
    "time": ({(6, "t"): ""}, 6, "t", "the time is missing"),
    "order": ({(6, "t"): "0.1"}, 6, "t", "0.1 s comes after 0.8 s"),
    "phase": ({(7, "phase"): "WAVE"}, 7, "phase", "'WAVE' is no phase"),
    "column": ({(1, "gaze"): "gase"}, 1, "gaze", "column gaze missing"),
}


@pytest.mark.parametrize(("changes", "row", "column", "says"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named_with_its_place(
    tmp_path: Path, changes: dict[tuple[int, str], str], row: int, column: str, says: str
) -> None:
    path = file_with(tmp_path / "o.csv", changes)
    with pytest.raises(DataError) as refused:
        read_observations(path)
    assert_one_sentence(refused.value, path, row=row, column=column)
    assert says in str(refused.value)


def test_the_unchanged_file_is_right(tmp_path: Path) -> None:
    seen = read_observations(file_with(tmp_path / "o.csv", {}))
    np.testing.assert_array_equal(seen.values, [[2, 1.5, 0.4, 1, 0, 0.5, 1]] * 10)
    assert seen.phases is not None
    assert seen.phases.tolist() == [2] * 10
