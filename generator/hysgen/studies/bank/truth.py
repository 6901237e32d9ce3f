"""The error of the extended model with the truth known: a bound for the error after a diagnosis.

The shape parameters of the extensions are those of the plant, and the plant is run without the effects that extensions
only take out of a record. The fit finds the linear parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.coupling import coupling_term
from hysgen.diagnosis.causes.creep import creep_term
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import fit_ladder
from hysgen.diagnosis.memory_shape import usual_memory
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import rms
from hysgen.fitting import FitSettings
from hysgen.model.path.delay import Delay
from hysgen.model.path.saturation import Saturation
from hysgen.model.path.slew import Slew
from hysgen.model.terms.periodic import Periodic
from hysgen.model.terms.resonance import Resonance
from hysgen.record import Record
from hysgen.stage import run as measure
from hysgen.studies.bank.scenario import ACCEPTED, Scenario

Floats = NDArray[np.float64]

UNSEEN = ("drift", "aging", "outliers")
"""Causes whose extension is a treatment of the record: the model is fitted to a record without the effect."""


@dataclass(frozen=True, eq=False)
class TrueSetting:
    """What a true extension is made from: the plant's parameters, "cause.parameter", the record's span and channels.

    low_V, high_V: range of the voltage across the ceramic.
    """

    parameters: Mapping[str, float]
    low_V: float
    high_V: float
    span_s: float
    channels: Mapping[str, Floats]


def _coupling(known: TrueSetting) -> Extension:
    ranges = {name: (float(values.min()), float(values.max())) for name, values in known.channels.items()}
    return Extension(term=coupling_term(ranges))


TRUE: Mapping[str, Callable[[TrueSetting], Extension]] = {
    "saturation": lambda k: Extension(
        block=Saturation(k.parameters["saturation.low_V"], k.parameters["saturation.high_V"])
    ),
    "memory": lambda k: Extension(term=usual_memory(k.low_V, k.high_V)),
    "slew": lambda k: Extension(block=Slew(k.parameters["slew.rate_V_per_s"], k.parameters["slew.rate_V_per_s"])),
    "delay": lambda k: Extension(block=Delay(k.parameters["delay.delay_samples"])),
    "creep": lambda k: Extension(term=creep_term(k.parameters["creep.from_s"], k.span_s)),
    "resonance": lambda k: Extension(
        term=Resonance((k.parameters["resonance.f_Hz"],), (k.parameters["resonance.zeta"],))
    ),
    "periodic": lambda k: Extension(term=Periodic((k.parameters["periodic.f_Hz"],))),
    "coupling": _coupling,
}
"""Extension with the plant's numbers, by cause."""


def error_with_truth_known(hidden: Scenario) -> float:
    """Free-run rms in um on the held-out rows of the model with every planted cause extended by the plant's numbers."""
    stage = hidden.stage.with_effects(**dict.fromkeys(UNSEEN))
    y_um = measure(stage, hidden.u_V, hidden.Ts_s, hidden.seed, hidden.aux).displacement_um
    prepared = prepare(Record.from_arrays(hidden.u_V, y_um, hidden.Ts_s, hidden.aux, accept=ACCEPTED))
    extensions = true_extensions(hidden)
    rung = fit_ladder(prepared, extensions, list(extensions), FitSettings())
    return rms(rung.error_um[prepared.held_rows])


def true_extensions(hidden: Scenario) -> dict[str, Extension]:
    """The extension of every planted cause that acts on the model, with the parameters of the plant."""
    parameters: dict[str, float] = {}
    low_V, high_V = float(hidden.u_V.min()), float(hidden.u_V.max())
    for effect in hidden.stage.effects:
        parameters |= effect.true_parameters()
        low_V, high_V = effect.passes_V(low_V, high_V)
    channels = {name: np.asarray(hidden.aux[name]) for name in hidden.stage.channels}
    known = TrueSetting(parameters, low_V, high_V, hidden.Ts_s * len(hidden.u_V), channels)
    return {name: extension(known) for name, extension in TRUE.items() if name in hidden.planted}
