"""The probe: a physical model of the stage that is fitted to the free run to find causes; no C is generated from it.

The probe shares no code with the Takagi-Sugeno model. It is a hysteresis operator behind the limits of the amplifier,
followed by a linear chain. If the residual is only noise, every needed part of the chain is a cause.
"""

from hysgen.diagnosis.probe.chain import NO_HISTORY, Chain, History, Trace
from hysgen.diagnosis.probe.scene import Scene
from hysgen.diagnosis.probe.solve import (
    Fit,
    Projector,
    StandardErrors,
    TrainingFit,
    WhitenedScene,
    functional_error,
    linear_fit,
    projector_off,
    refine,
    rms,
    sensitivities,
    single_fit,
    standard_errors,
    training_fit,
    whitened_fit,
)
from hysgen.fitting.operator import Operator
from hysgen.model.part import Extent, Mode, Part, RunSignals, ShapeParameter, octaves

__all__ = [
    "NO_HISTORY",
    "Chain",
    "Extent",
    "Fit",
    "History",
    "Mode",
    "Operator",
    "Part",
    "Projector",
    "RunSignals",
    "Scene",
    "ShapeParameter",
    "StandardErrors",
    "Trace",
    "TrainingFit",
    "WhitenedScene",
    "functional_error",
    "linear_fit",
    "octaves",
    "projector_off",
    "refine",
    "rms",
    "sensitivities",
    "single_fit",
    "standard_errors",
    "training_fit",
    "whitened_fit",
]
