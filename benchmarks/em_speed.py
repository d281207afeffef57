"""How fast EM is: kendon beside hmmlearn and dynamax, on one core.

    python benchmarks/em_speed.py [--sequences 1000] [--rows 25] [--growth 100000]

One iteration, E-step and M-step, of an all-Gaussian model of six states on greetings drawn from
the Kendon model, every sequence of the same length as dynamax wants them. Then how kendon's time
and memory grow with the number of sequences, whose lengths now differ. hmmlearn and dynamax are
optional: pip install hmmlearn jax dynamax.
"""

from __future__ import annotations

import argparse
import functools
import logging
import os
import time
import tracemalloc
from collections.abc import Callable
from typing import Any, NamedTuple

# One core for all of them; the libraries read this when they are imported.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

import numpy as np  # noqa: E402

from kendon.models import GreetingModel, Prior, load_model, sample  # noqa: E402
from kendon.models.ascent import expect  # noqa: E402
from kendon.models.em import Workspace, pack  # noqa: E402
from kendon.models.prior import Parameters  # noqa: E402


class Timing(NamedTuple):
    """One library's iteration."""

    name: str
    milliseconds: float  # the fastest
    log_likelihood: float


def parameters_of(model: GreetingModel) -> Parameters:
    return Parameters(model.startprob, model.transmat, model.means, model.variances)


def fastest(job: Callable[[], float], repeats: int) -> tuple[float, float]:
    """The shortest time of a job [s], after one that does not count, and its result."""
    result = job()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = job()
        times.append(time.perf_counter() - start)
    return min(times), result


def time_kendon(model: GreetingModel, X: list[Any], repeats: int) -> Timing:
    data, workspace, prior = pack(X), Workspace(), Prior()
    before, allowed = parameters_of(model), np.ones((6, 6), dtype=bool)

    def iterate() -> float:
        expected, log_likelihood = expect(data, before, workspace)
        prior.maximise(expected, before, data.center, allowed)
        return log_likelihood

    seconds, log_likelihood = fastest(iterate, repeats)
    return Timing("kendon", 1e3 * seconds, log_likelihood)


def time_hmmlearn(model: GreetingModel, X: list[Any], repeats: int) -> Timing | None:
    try:
        from hmmlearn.hmm import GaussianHMM
    except ImportError:
        print("hmmlearn is not installed and left out; pip install hmmlearn")
        return None
    logging.getLogger("hmmlearn").setLevel(logging.ERROR)
    rows, lengths = np.concatenate(X), [len(x) for x in X]
    other: Any = GaussianHMM(6, covariance_type="diag", n_iter=1, tol=-np.inf, init_params="")

    def iterate() -> float:
        other.startprob_, other.transmat_ = model.startprob, model.transmat
        other.means_, other.covars_ = model.means, model.variances
        other.fit(rows, lengths)
        return float(other.monitor_.history[-1])

    seconds, log_likelihood = fastest(iterate, max(3, repeats // 10))
    return Timing("hmmlearn", 1e3 * seconds, log_likelihood)


def time_dynamax(model: GreetingModel, X: list[Any], repeats: int) -> Timing | None:
    try:
        import jax
        from dynamax.hidden_markov_model import DiagonalGaussianHMM
    except ImportError:
        print("dynamax is not installed and left out; pip install jax dynamax")
        return None
    jax.config.update("jax_enable_x64", True)
    other: Any = DiagonalGaussianHMM(6, len(model.means[0]))
    parameters, properties = other.initialize(
        jax.random.PRNGKey(0),
        initial_probs=jax.numpy.array(model.startprob),
        transition_matrix=jax.numpy.array(model.transmat),
        emission_means=jax.numpy.array(model.means),
        emission_scale_diags=jax.numpy.sqrt(jax.numpy.array(model.variances)),
    )
    emissions = jax.numpy.array(np.stack(X))

    def iterate(now: Any) -> Any:
        found, log_likelihoods = jax.vmap(functools.partial(other.e_step, now))(emissions)
        state = other.initialize_m_step_state(now, properties)
        return other.m_step(now, properties, found, state)[0], log_likelihoods.sum()

    step: Any = jax.jit(iterate)
    seconds, log_likelihood = fastest(
        lambda: float(jax.block_until_ready(step(parameters))[1]), repeats
    )
    return Timing("dynamax", 1e3 * seconds, log_likelihood)


def compare(sequences: int, rows: int, repeats: int) -> None:
    """One iteration of the three, side by side."""
    model = load_model("kendon")
    X = [greeting.values for greeting in sample(model, [rows] * sequences)]
    kendon = time_kendon(model, X, repeats)
    others = [time_hmmlearn(model, X, repeats), time_dynamax(model, X, repeats)]
    print(f"One EM iteration, {sequences} sequences of {rows} rows, all-Gaussian, one core")
    print(f"{'':<10}{'ms':>10}{'kendon is':>12}{'log-likelihood':>18}{'difference':>12}")
    for timing in [kendon, *(other for other in others if other)]:
        ratio = f"{timing.milliseconds / kendon.milliseconds:.1f}x"
        difference = abs(timing.log_likelihood / kendon.log_likelihood - 1)
        print(
            f"{timing.name:<10}{timing.milliseconds:>10.2f}{ratio:>12}"
            f"{timing.log_likelihood:>18.4f}{difference:>12.1e}"
        )


def grow(sequences: int) -> None:
    """Time of one size, and the memory that EM takes besides the greetings themselves."""
    model, rng = load_model("kendon"), np.random.default_rng(0)
    lengths = rng.integers(10, 41, sequences).tolist()
    X = [  # a thousand at a time: sampling is not what is measured
        greeting.values.copy()
        for start in range(0, sequences, 1000)
        for greeting in sample(model, lengths[start : start + 1000], start)
    ]
    timing = time_kendon(model, X, 3)
    tracemalloc.start()  # afterwards, as it takes time of its own
    time_kendon(model, X, 1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    print(
        f"{sequences:>10}{sum(lengths):>10}{timing.milliseconds:>12.1f}"
        f"{1e6 * timing.milliseconds / sum(lengths):>12.0f}"
        f"{sum(x.nbytes for x in X) / 1e6:>10.1f}{peak / 1e6:>10.1f}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--sequences", type=int, default=1000, help="side by side (1000)")
    parser.add_argument("--rows", type=int, default=25, help="of each sequence (25)")
    parser.add_argument("--repeats", type=int, default=50, help="of which the fastest counts (50)")
    parser.add_argument("--growth", type=int, default=100_000, help="up to so many (100,000)")
    arguments = parser.parse_args()
    compare(arguments.sequences, arguments.rows, arguments.repeats)
    print("\nGrowth, sequences of 10 to 40 rows; the memory of EM is its peak on top of the data's")
    print(f"{'sequences':>10}{'rows':>10}{'ms':>12}{'ns per row':>12}{'data MB':>10}{'EM MB':>10}")
    size = 100
    while size <= arguments.growth:
        grow(size)
        size *= 10


if __name__ == "__main__":
    main()
