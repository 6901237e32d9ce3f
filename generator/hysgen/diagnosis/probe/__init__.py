"""The probe: a physical model that is fitted only to look.

It stands beside the Takagi-Sugeno model and shares nothing with it: a Preisach operator between the amplifier's limits
and a linear chain, fitted to the free run. Where it leaves only noise, every part of it that matters is a cause.
"""

from hysgen.diagnosis.probe.chain import Chain, Mode
from hysgen.diagnosis.probe.operator import Operator
from hysgen.diagnosis.probe.scene import Run, Scene
from hysgen.diagnosis.probe.solve import Fit, Projector, linear_fit, refine, rms
from hysgen.diagnosis.probe.uncertainty import Errors, standard_errors
from hysgen.diagnosis.probe.whitened import WhitenedScene, schwarz, whitened_fit

__all__ = [
    "Chain",
    "Errors",
    "Fit",
    "Mode",
    "Operator",
    "Projector",
    "Run",
    "Scene",
    "WhitenedScene",
    "linear_fit",
    "refine",
    "rms",
    "schwarz",
    "standard_errors",
    "whitened_fit",
]
