"""Whatever reads phases from observations, so that all of it can be compared."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

from kendon.errors import ParameterError
from kendon.estimate import Decoder, estimate
from kendon.models import Family, GreetingModel, load_model
from kendon.observations import Observations
from kendon.person import IntArray

#: The models of the thesis, which every other is compared with.
PUBLISHED: tuple[str, ...] = ("kendon", "data-driven")


class Reader(Protocol):
    """Reads the phase of each observation."""

    @property
    def name(self) -> str:
        """How it is called in tables."""

    @property
    def causal(self) -> bool:
        """Whether the phase of a row depends on no later row, as on a robot."""

    def read(self, observations: Observations) -> IntArray:
        """The phases 1-6, shape (T,)."""


@dataclass(frozen=True)
class ModelReader:
    """A greeting model with one of its decoders."""

    model: GreetingModel
    decoder: Decoder

    @property
    def name(self) -> str:
        """The model's name and the decoder's."""
        return f"{self.model.name} ({self.decoder.value})"

    @property
    def causal(self) -> bool:
        """Whether the decoder is the filter."""
        return self.decoder is Decoder.FILTER

    def read(self, observations: Observations) -> IntArray:
        """The phases 1-6, shape (T,)."""
        return estimate(observations, self.model, self.decoder).phases


def model_readers(
    models: Iterable[str | GreetingModel], decoders: Sequence[Decoder] = tuple(Decoder)
) -> list[Reader]:
    """A reader for every model and decoder; the published models join at the end.

    Args:
        models: names, files or models, each read once however often it is named.
        decoders: in the order of the readers.

    Raises:
        UnknownNameError: a model's name does not exist.
        DataError: a model's file cannot be read.
        ParameterError: two models have the same name, so that no table could tell them apart.
    """
    wanted: dict[str | GreetingModel, None] = dict.fromkeys((*models, *PUBLISHED))
    loaded: dict[str, GreetingModel] = {}
    for item in wanted:
        model = item if isinstance(item, GreetingModel) else load_model(item)
        if model.name in loaded:
            raise ParameterError(
                f"two of the models are called {model.name!r}; rename one of the files"
            )
        loaded[model.name] = model
    return [ModelReader(model, decoder) for model in loaded.values() for decoder in decoders]


class Way(NamedTuple):
    """A way to learn a model."""

    name: str
    family: Family
    labels: bool  # whether the true phases are told


#: How models are learned for comparison; the last is the thesis's way (3.5.3).
WAYS: tuple[Way, ...] = (
    Way("learned robust", Family.ROBUST, True),
    Way("learned gaussian", Family.GAUSSIAN, True),
    Way("learned unlabelled", Family.GAUSSIAN, False),
)


def learned_readers(
    greetings: Sequence[Observations],
    seed: int,
    decoders: Sequence[Decoder] = tuple(Decoder),
    ways: Sequence[Way] = WAYS,
) -> list[Reader]:
    """A reader for each way to learn from greetings and each decoder.

    Args:
        greetings: to learn from.
        seed: of the random starts, where the true phases are not told.
        decoders: in the order of the readers.
        ways: of learning.

    Raises:
        ParameterError: there is nothing to learn from.
    """
    # Whoever learns nothing need not load what learns.
    from kendon.models.learning import fit

    models = []
    for way in ways:
        model = fit(greetings, family=way.family, labels=way.labels, seed=seed).model
        models.append(replace(model, name=way.name))
    return [ModelReader(model, decoder) for model in models for decoder in decoders]
