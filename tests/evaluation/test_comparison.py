"""Intervals that cover what they should, and splits that repeat."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from evaluation_data import Nearest, learn_distances, walk_up
from hypothesis import given
from hypothesis import strategies as st

from kendon.errors import MissingExtraError, ParameterError, UnknownNameError
from kendon.evaluation import Reader, Tally, bootstrap, random_splits, repeated_splits, tally
from kendon.evaluation.cluster import dask_cluster, require_dask
from kendon.observations import Observations

GREETINGS = [walk_up(f"greeting {i}", start=2.0 + 0.5 * i) for i in range(9)]


def tallies(shares: Sequence[float], observations: int = 40) -> Tally:
    right = np.rint(np.array(shares) * observations).astype(np.int64)
    return Tally(right, np.full(len(right), observations))


# ---- intervals


@given(st.lists(st.floats(0, 1), min_size=2, max_size=20), st.integers(0, 99))
def test_readers_that_are_alike_differ_by_exactly_nothing(shares: list[float], seed: int) -> None:
    one = tallies(shares)
    assert bootstrap(one, one, seed=seed, resamples=200) == (0.0, 0.0, 0.0)


def test_the_interval_is_that_of_the_mean_of_many_greetings() -> None:
    rng = np.random.default_rng(1)
    shares = rng.uniform(0.4, 1.0, 200)
    value, low, high = bootstrap(tallies(shares.tolist(), 1000), seed=3)
    assert value == pytest.approx(shares.mean(), abs=1e-3)
    # The central limit theorem: 1.96 standard errors either side.
    error = shares.std() / math.sqrt(200)
    assert low == pytest.approx(value - 1.96 * error, abs=0.1 * error)
    assert high == pytest.approx(value + 1.96 * error, abs=0.1 * error)


def test_intervals_cover_a_known_difference_about_as_often_as_they_say() -> None:
    rng = np.random.default_rng(5)
    covered = 0
    for trial in range(200):
        # Greetings differ in how hard they are, the same for both readers.
        hard = rng.uniform(0.5, 0.8, 40)
        first, second = rng.binomial(50, hard + 0.1), rng.binomial(50, hard)
        labelled = np.full(40, 50)
        _, low, high = bootstrap(
            Tally(first, labelled), Tally(second, labelled), seed=trial, resamples=500
        )
        covered += low <= 0.1 <= high
    assert 0.88 <= covered / 200 <= 0.99


def test_pairing_makes_the_interval_narrow() -> None:
    hard = np.linspace(0.2, 0.9, 20)
    first, second = tallies((hard + 0.1).tolist(), 100), tallies(hard.tolist(), 100)
    _, low, high = bootstrap(first, second, seed=0)
    assert [low, high] == pytest.approx([0.1, 0.1])
    _, low, high = bootstrap(first, seed=0)
    assert high - low > 0.1


def test_long_greetings_weigh_more() -> None:
    value, _, _ = bootstrap(Tally(np.array([10, 0]), np.array([10, 90])), seed=0)
    assert value == 0.1


def test_an_interval_is_seeded_and_one_greeting_has_none() -> None:
    one = tallies([0.1, 0.5, 0.9])
    assert bootstrap(one, seed=4) == bootstrap(one, seed=4)
    value, low, high = bootstrap(tallies([0.5]), seed=0)
    assert value == 0.5
    assert math.isnan(low)
    assert math.isnan(high)


def test_other_greetings_are_no_comparison() -> None:
    with pytest.raises(ParameterError, match="same greetings"):
        bootstrap(tallies([1, 1]), tallies([1, 1, 1]), seed=0)


# ---- splits


@given(st.integers(2, 60), st.integers(1, 5), st.integers(0, 99), st.floats(0.01, 0.99))
def test_splits_are_disjoint_whole_and_seeded(
    greetings: int, number: int, seed: int, share: float
) -> None:
    splits = random_splits(greetings, number, seed=seed, test_share=share)
    assert len(splits) == number
    for split in splits:
        assert set(split.train).isdisjoint(split.test)
        assert sorted(split.train + split.test) == list(range(greetings))
        assert split.train
        assert split.test
    assert splits == random_splits(greetings, number, seed=seed, test_share=share)
    # More splits begin with the same ones.
    assert splits == random_splits(greetings, number + 1, seed=seed, test_share=share)[:-1]


def test_splits_are_the_thesis_s_and_differ() -> None:
    splits = random_splits(33, 15, seed=0)
    assert {(len(s.train), len(s.test)) for s in splits} == {(25, 8)}
    assert len({s.test for s in splits}) == 15
    assert len({s.seed for s in splits}) == 15
    assert splits != random_splits(33, 15, seed=1)


@pytest.mark.parametrize(("greetings", "number"), [(1, 5), (0, 5), (9, 0)])
def test_splits_that_cannot_be(greetings: int, number: int) -> None:
    with pytest.raises(ParameterError, match="at least"):
        random_splits(greetings, number, seed=0)


def spreads(n_jobs: int = 1, **where: object) -> dict[str, list[float]]:
    splits = random_splits(len(GREETINGS), 6, seed=2)
    calls: list[None] = []
    result = repeated_splits(
        GREETINGS,
        splits,
        {"fixed": tally([(_truth(g), Nearest((9, 9, 9, 6, 2, 1)).read(g)) for g in GREETINGS])},
        learn_distances,
        n_jobs=n_jobs,
        progress=lambda: calls.append(None),
        **where,  # type: ignore[arg-type]
    )
    assert len(calls) == 6
    return {name: spread.accuracies.tolist() for name, spread in result.items()}


def test_splits_give_what_learning_and_testing_by_hand_gives() -> None:
    found = spreads()
    assert list(found) == ["nearest", "fixed"]
    for place, split in enumerate(random_splits(len(GREETINGS), 6, seed=2)):
        (learned,) = learn_distances([GREETINGS[i] for i in split.train], split.seed)
        for name, reader in (("nearest", learned), ("fixed", Nearest((9, 9, 9, 6, 2, 1)))):
            tested = [GREETINGS[i] for i in split.test]
            right = np.concatenate([reader.read(g) == _truth(g) for g in tested])
            assert found[name][place] == pytest.approx(right.mean())


def test_two_processes_give_what_one_gives() -> None:
    assert spreads(n_jobs=2) == spreads(n_jobs=1)


def test_spread_is_mean_and_sample_deviation() -> None:
    splits = random_splits(9, 3, seed=0)
    fixed = {"one": tallies([0.1 * i for i in range(9)])}
    spread = repeated_splits(GREETINGS, splits, fixed)["one"]
    by_hand = [np.mean([0.1 * i for i in split.test]) for split in splits]
    assert spread.mean == pytest.approx(np.mean(by_hand), abs=0.02)
    assert spread.deviation == pytest.approx(np.std(spread.accuracies, ddof=1))


def refuse(greetings: Sequence[Observations], seed: int) -> Sequence[Reader]:
    raise UnknownNameError("phase", "XX", ["IA"])


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_what_cannot_be_learned_is_one_sentence_from_any_process(n_jobs: int) -> None:
    with pytest.raises(ParameterError, match="there is no phase 'XX'"):
        repeated_splits(GREETINGS, random_splits(9, 2, seed=0), {}, refuse, n_jobs=n_jobs)


# ---- a cluster


def test_without_the_extra_a_cluster_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"kendon\[cluster\]"):
        require_dask()


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """The address of a scheduler on this machine, with two workers."""
    distributed = pytest.importorskip(
        "distributed", reason="Dask is not installed; it is the extra 'cluster'"
    )
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, protocol="tcp",
        host="127.0.0.1", dashboard_address="127.0.0.1:0",
    ) as local:  # fmt: skip
        yield local.scheduler_address


@pytest.mark.filterwarnings("default")  # Dask's, of which kendon knows nothing
def test_a_dask_cluster_gives_what_this_machine_gives(cluster: str) -> None:
    assert spreads(backend=dask_cluster(cluster)) == spreads()


@pytest.mark.filterwarnings("default")
def test_a_cluster_that_is_not_there_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed; it is the extra 'cluster'")
    monkeypatch.setattr("kendon.evaluation.cluster.PATIENCE", 0.5)
    for address in ("tcp://127.0.0.1:9", "nonsense://x"):
        with (
            pytest.raises(ParameterError, match=r"no Dask scheduler answers"),
            dask_cluster(address),
        ):
            pass


@pytest.mark.filterwarnings("default")
def test_a_cluster_without_workers_is_refused() -> None:
    distributed = pytest.importorskip(
        "distributed", reason="Dask is not installed; it is the extra 'cluster'"
    )
    with distributed.LocalCluster(
        n_workers=0, processes=False, protocol="tcp", host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as local:  # fmt: skip
        refused = pytest.raises(ParameterError, match="no workers")
        with refused, dask_cluster(local.scheduler_address):
            pass


def _truth(greeting: Observations) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    assert greeting.phases is not None
    return greeting.phases
