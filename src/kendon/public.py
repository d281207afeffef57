"""What `import kendon` offers."""

from kendon._version import __version__
from kendon.errors import (
    DataError,
    KendonError,
    MissingExtraError,
    ModelFileError,
    ParameterError,
    RobotError,
    TreeError,
    UnknownNameError,
)
from kendon.features import Sampler, observe, observe_all
from kendon.greeter import Encounter, Greeter, Moment
from kendon.greetings import load_greetings
from kendon.models import (
    Belief,
    Fit,
    GreetingModel,
    Prior,
    Tracker,
    fit,
    from_hmmlearn,
    load_model,
    model_names,
    name_states,
    save_model,
    to_hmmlearn,
)
from kendon.observations import (
    FEATURES,
    Observation,
    Observations,
    read_observations,
    write_observations,
)
from kendon.person import PersonFrame, Track
from kendon.phases import Phase
from kendon.robots import PointRobot, Robot
from kendon.sources import RecordedSource, SourceOptions, open_source
from kendon.tracks import read_track, write_track
from kendon.trees import GreetingTree

__all__ = [
    "FEATURES",
    "Belief",
    "DataError",
    "Encounter",
    "Fit",
    "Greeter",
    "GreetingModel",
    "GreetingTree",
    "KendonError",
    "MissingExtraError",
    "ModelFileError",
    "Moment",
    "Observation",
    "Observations",
    "ParameterError",
    "PersonFrame",
    "Phase",
    "PointRobot",
    "Prior",
    "RecordedSource",
    "Robot",
    "RobotError",
    "Sampler",
    "SourceOptions",
    "Track",
    "Tracker",
    "TreeError",
    "UnknownNameError",
    "__version__",
    "fit",
    "from_hmmlearn",
    "load_greetings",
    "load_model",
    "model_names",
    "name_states",
    "observe",
    "observe_all",
    "open_source",
    "read_observations",
    "read_track",
    "save_model",
    "to_hmmlearn",
    "write_observations",
    "write_track",
]
