"""How well phases are read: metrics, baselines, comparisons, figures and a report."""

from kendon.evaluation.baselines import BASELINES, EngagementZones, ProxemicStateMachine
from kendon.evaluation.comparison import (
    Interval,
    Split,
    Spread,
    Tally,
    bootstrap,
    random_splits,
    repeated_splits,
    tally,
)
from kendon.evaluation.readers import (
    PUBLISHED,
    ModelReader,
    Reader,
    learned_readers,
    model_readers,
)
from kendon.evaluation.results import Evaluation, Material, Result, evaluate, sort_material

__all__ = [
    "BASELINES",
    "PUBLISHED",
    "EngagementZones",
    "Evaluation",
    "Interval",
    "Material",
    "ModelReader",
    "ProxemicStateMachine",
    "Reader",
    "Result",
    "Split",
    "Spread",
    "Tally",
    "bootstrap",
    "evaluate",
    "learned_readers",
    "model_readers",
    "random_splits",
    "repeated_splits",
    "sort_material",
    "tally",
]
