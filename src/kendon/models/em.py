"""The E-step of EM for many sequences at once (thesis 2.13, 2.14).

Sequences are sorted by length and packed by time: first the first rows of all of them, then the
second rows of those that have one, and so on. Each time step is then one block of columns, and
the loop runs over time steps only, with no padding however different the lengths are. States
come first, (K, N), so that every operation runs along the sequences.

The recursions run on plain probabilities, with each row's densities scaled by the largest of its
states and nothing else. That is fast, and exact as long as nothing that underflows could have
mattered later. After the scaling no density and no transition exceeds 1, so whatever vanished,
below 1e-300, adds no more than that to the sequence's likelihood: if the likelihood stays above
1e-250, it has lost less than one part in 1e40. A sequence below that (a state that comes back
from 1e-400, or some hundred rows and more) is computed again in logarithms, where nothing is lost.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kendon.models.hmm import log_probabilities
from kendon.person import FloatArray, IntArray

#: Rows of a chunk: its working memory, some 20 MB, is all that EM needs beside the data.
CHUNK_ROWS = 50_000

#: No label: the row may be in any state.
FREE = -1

#: The scaled likelihood above which nothing that mattered has been lost; see above.
_SAFE = 1e-250


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some sequences, packed by time; columns are rows of observations."""

    values: FloatArray  # (2 F, N) less `center`, then their squares; 0 where unknown
    known: FloatArray | None  # (F, N), 1 = known, 0 = not; None: all are known
    labels: IntArray | None  # (N,) state of the row, FREE if any; None: all are free
    sizes: IntArray  # (T,) how many sequences reach each time step, falling
    sequences: IntArray  # (S,) which ones they are, longest first

    def blocks(self) -> list[tuple[int, int]]:
        """The columns of each time step, from (inclusive) and to (exclusive)."""
        ends = np.cumsum(self.sizes)
        return list(zip((ends - self.sizes).tolist(), ends.tolist(), strict=True))

    def without_labels(self) -> Chunk:
        """The same rows, free to be in any state."""
        return self if self.labels is None else replace(self, labels=None)


@dataclass(frozen=True, eq=False)
class Data:
    """Sequences made ready for EM."""

    chunks: list[Chunk]
    center: FloatArray  # (F,) mean of the known values: sums of squares about it stay precise
    count: int  # of sequences
    rows: int


class Posterior(NamedTuple):
    """What the E-step knows of a chunk."""

    states: FloatArray  # (K, N), P(state_t | o_1..o_T), the gamma of (2.13)
    moves: FloatArray  # (K, K), expected number of moves from row to column, summed (2.14)
    log_likelihoods: FloatArray  # (S,), log P(o_1..o_T and the labels), in the chunk's order


def pack(
    sequences: Sequence[FloatArray],
    labels: Sequence[IntArray] | None = None,
    chunk_rows: int = CHUNK_ROWS,
) -> Data:
    """Sort, centre and pack sequences.

    Args:
        sequences: (T, F) each, T at least 1, NaN = unknown.
        labels: (T,) each, the state 0..K-1 or FREE.
        chunk_rows: about how many rows are worked on at a time.
    """
    lengths = np.array([len(sequence) for sequence in sequences])
    order = np.argsort(-lengths, kind="stable")
    center = _known_mean(sequences)
    chunks = []
    for group in _groups(lengths[order], chunk_rows):
        chosen = order[group]
        long = lengths[chosen]
        begins = np.cumsum(long) - long
        sizes = np.searchsorted(-long, -np.arange(long[0]), side="left")
        index = np.concatenate([begins[:size] + t for t, size in enumerate(sizes.tolist())])
        x = np.concatenate([sequences[s] for s in chosen.tolist()])[index].T - center[:, None]
        holes = np.isnan(x)
        marks = None
        if labels is not None:
            marks = np.concatenate([labels[s] for s in chosen.tolist()])[index]
            marks = None if (marks == FREE).all() else marks
        x[holes] = 0.0
        chunks.append(
            Chunk(
                np.concatenate([x, x * x]),
                1.0 - holes if holes.any() else None,
                marks,
                sizes,
                chosen,
            )
        )
    return Data(chunks, center, len(sequences), int(lengths.sum()))


def _known_mean(sequences: Sequence[FloatArray]) -> FloatArray:
    total = np.zeros(sequences[0].shape[1])
    count = np.zeros_like(total)
    for start in range(0, len(sequences), 1000):  # a thousand at a time: no second copy of all
        X = np.concatenate(sequences[start : start + 1000])
        total += np.nansum(X, axis=0)
        count += (~np.isnan(X)).sum(axis=0)
    return np.asarray(total / np.maximum(count, 1))


def _groups(lengths: IntArray, chunk_rows: int) -> Iterator[slice]:
    """Neighbours in the order of length that have about `chunk_rows` rows together."""
    group = (np.cumsum(lengths) - lengths) // chunk_rows
    bounds = [0, *(np.flatnonzero(np.diff(group)) + 1).tolist(), len(lengths)]
    for begin, end in pairwise(bounds):
        yield slice(begin, end)


class Workspace:
    """Arrays that are used again and again.

    Asking the operating system for memory anew in each pass takes longer than the arithmetic.
    """

    def __init__(self) -> None:
        self._memory: dict[str, FloatArray] = {}

    def array(self, name: str, *shape: int) -> FloatArray:
        """An array with anything in it; the memory is that of the last one of this name."""
        size = math.prod(shape)
        if name not in self._memory or self._memory[name].size < size:
            self._memory[name] = np.empty(size)
        return self._memory[name][:size].reshape(shape)


def posterior(
    startprob: FloatArray,
    transmat: FloatArray,
    log_emission: FloatArray,
    chunk: Chunk,
    workspace: Workspace | None = None,
) -> Posterior:
    """Posterior probabilities of the states of every row, and the expected moves.

    Args:
        startprob: (K,).
        transmat: (K, K), from row to column.
        log_emission: (K, N), log P(row | state). Labelled rows are restricted here.
        chunk: how the N rows are packed.
        workspace: whose memory is used, for the result as well: valid until the next call.
    """
    workspace = workspace or Workspace()
    if chunk.labels is not None:
        other = (chunk.labels != FREE) & (chunk.labels != np.arange(len(startprob))[:, None])
        log_emission = np.where(other, -np.inf, log_emission)
    states = workspace.array("states", *log_emission.shape)
    blocks = chunk.blocks()
    peak = log_emission.max(axis=0)
    emission = _steps(workspace.array("emission", log_emission.size), blocks)
    forward = _steps(workspace.array("forward", log_emission.size), blocks)
    for (a, b), here in zip(blocks, emission, strict=True):
        np.subtract(log_emission[:, a:b], peak[a:b], out=here)
        np.exp(here, out=here)
    likelihood = _forward(startprob, transmat, emission, forward)
    lost = np.flatnonzero(likelihood < _SAFE)
    safe = likelihood
    if len(lost):
        for here in forward:  # out of the way: they are done again below
            here[:, lost[lost < here.shape[1]]] = 0.0
        safe = np.maximum(likelihood, _SAFE)
    moves = _backward(transmat, emission, forward, 1 / safe)
    for (a, b), here in zip(blocks, forward, strict=True):
        states[:, a:b] = here
    log_likelihoods = np.log(safe)
    for a, b in blocks:
        log_likelihoods[: b - a] += peak[a:b]
    if len(lost):
        log_likelihoods[lost] = _in_logarithms(
            startprob, transmat, log_emission, blocks, lost, states, moves
        )
    return Posterior(states, moves, log_likelihoods)


def _steps(memory: FloatArray, blocks: list[tuple[int, int]]) -> list[FloatArray]:
    """Memory as an array (K, n) for each time step, one after the other: each in one piece."""
    states = len(memory) // blocks[-1][1]
    return [memory[states * a : states * b].reshape(states, b - a) for a, b in blocks]


def _forward(
    startprob: FloatArray,
    transmat: FloatArray,
    emission: list[FloatArray],
    forward: list[FloatArray],
) -> FloatArray:
    """Fill in P(o_1..o_t, state_t) and return P(o_1..o_T), (S,), of scaled densities."""
    into = np.ascontiguousarray(transmat.T)
    np.multiply(startprob[:, None], emission[0], out=forward[0])
    for before, here, density in zip(forward, forward[1:], emission[1:], strict=False):
        np.matmul(into, before[:, : here.shape[1]], out=here)
        here *= density
    likelihood = np.empty(forward[0].shape[1])
    reach = 0
    for here in reversed(forward):  # the sequences that end here
        likelihood[reach : here.shape[1]] = here[:, reach:].sum(axis=0)
        reach = here.shape[1]
    return likelihood


def _backward(
    transmat: FloatArray,
    emission: list[FloatArray],
    forward: list[FloatArray],
    last: FloatArray,
) -> FloatArray:
    """The expected moves, (K, K); `forward` becomes P(state_t | o_1..o_T), `emission` is lost.

    The recursion starts from 1 / P(o_1..o_T), `last`, (S,), so that all comes out normalised.
    """
    moves = np.zeros_like(transmat)
    ahead = np.empty((len(transmat), 0))  # P(o_t..o_T | state_t) / P(o_1..o_T)
    memory = np.empty(emission[0].size)
    for here, density in zip(reversed(forward), reversed(emission), strict=True):
        reach = ahead.shape[1]
        backward = memory[: here.size].reshape(here.shape)
        if reach:
            moves += here[:, :reach] @ ahead.T
            np.matmul(transmat, ahead, out=backward[:, :reach])
        backward[:, reach:] = last[reach : here.shape[1]]
        here *= backward
        density *= backward
        ahead = density
    return moves * transmat


def _in_logarithms(
    startprob: FloatArray,
    transmat: FloatArray,
    log_emission: FloatArray,
    blocks: list[tuple[int, int]],
    chosen: IntArray,
    states: FloatArray,
    moves: FloatArray,
) -> FloatArray:
    """The posterior of some sequences without any underflow, written into states and moves.

    Args:
        startprob: (K,).
        transmat: (K, K).
        log_emission: (K, N).
        blocks: of the time steps.
        chosen: which sequences of the chunk, rising.
        states: (K, N), where their columns are to be written.
        moves: (K, K), to which their moves are to be added.

    Returns:
        Their log-likelihoods; -inf for one that cannot be.
    """
    log_moves = log_probabilities(transmat)[:, :, None]
    columns = [a + chosen[chosen < b - a] for a, b in blocks]
    columns = [c for c in columns if len(c)]
    forward = [log_probabilities(startprob)[:, None] + log_emission[:, columns[0]]]
    for here in columns[1:]:
        before = forward[-1][:, None, : len(here)]
        forward.append(_log_sum(before + log_moves, axis=0) + log_emission[:, here])
    total = np.empty(len(chosen))
    for step in forward:  # the last step that a sequence has is the one that stays
        total[: step.shape[1]] = _log_sum(step, axis=0)
    possible = np.where(np.isfinite(total), total, 0.0)
    backward = np.zeros((len(startprob), 0))
    for t in range(len(columns) - 1, -1, -1):
        reach, size = backward.shape[1], len(columns[t])
        now = np.zeros((len(startprob), size))
        if reach:
            ahead = log_emission[:, columns[t + 1]] + backward
            now[:, :reach] = _log_sum(log_moves + ahead, axis=1)
            joint = forward[t][:, None, :reach] + log_moves + ahead - possible[:reach]
            moves += np.exp(joint).sum(axis=2)
        states[:, columns[t]] = np.exp(forward[t] + now - possible[:size])
        backward = now
    return total


def _log_sum(logs: FloatArray, axis: int) -> FloatArray:
    largest = logs.max(axis=axis, keepdims=True)
    largest[largest == -np.inf] = 0.0
    with np.errstate(divide="ignore"):
        total = np.log(np.exp(logs - largest).sum(axis=axis))
    return np.asarray(total + largest.squeeze(axis))
