"""Whatever reads phases from observations, so that all of it can be compared."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from kendon.errors import ParameterError
from kendon.estimate import Decoder, estimate
from kendon.models import GreetingModel, load_model
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
