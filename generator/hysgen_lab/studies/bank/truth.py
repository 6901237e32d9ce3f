"""The error of the extended model with the truth known: a bound for the error after a diagnosis.

The shape parameters of the extensions are those of the plant, and the plant is run without the effects that extensions
only take out of a record. The fit finds the linear parameters.
"""

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.causes.creep import PER_DECADE, CreepPart
from hysgen.diagnosis.evaluation import Extension, free_run_error, prepare
from hysgen.diagnosis.probe import rms
from hysgen.fitting import PathSize
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.part import Mode
from hysgen.model.path import InputBlock
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes
from hysgen_lab.studies.bank.scenario import Scenario


def error_with_truth_known(hidden: Scenario) -> float:
    """Free-run rms in um on the held-out rows of the model with every planted cause extended by the plant's numbers."""
    treated = [name for name, extension in _extensions(hidden).items() if extension is None]
    clean = dataclasses.replace(hidden, stage=hidden.stage.with_effects(**dict.fromkeys(treated)))
    prepared = prepare(clean.record(clean.measure()))
    extensions = true_extensions(hidden)
    return rms(free_run_error(prepared, extensions, list(extensions))[prepared.held_rows])


def true_extensions(hidden: Scenario) -> dict[str, Extension]:
    """The extension of every planted cause that acts on the model, with the parameters of the plant."""
    return {name: extension for name, extension in _extensions(hidden).items() if extension is not None}


def _extensions(hidden: Scenario) -> dict[str, Extension | None]:
    """The extension of every planted cause; None where the diagnosis treats the record instead of the model."""
    parameters: dict[str, float] = {}
    for effect in hidden.stage.effects:
        parameters |= effect.true_parameters()
    channels = {name: np.asarray(hidden.aux[name]) for name in hidden.stage.channels}
    ranges = {name: (float(values.min()), float(values.max())) for name, values in channels.items()}
    span_s, lag_s = hidden.Ts_s * len(hidden.u_V), hidden.stage.lag_s
    return {
        name: true_extension(name, parameters, ranges, span_s, lag_s) for name in causes() if name in hidden.planted
    }


def true_extension(
    cause: str, parameters: Mapping[str, float], ranges: Mapping[str, tuple[float, float]], span_s: float, lag_s: float
) -> Extension | None:
    """The extension with the true parameters of a plant, by "cause.parameter"; None if it changes the record alone.

    ranges: of the channels that act. span_s: length of the record. lag_s: of the stage.
    """

    def own(*names: str) -> list[float]:
        return [parameters[f"{cause}.{name}"] for name in names]

    made: dict[str, Callable[[], InputBlock | Term]] = {
        "coupling": lambda: Coupling.of(ranges),
        "periodic": lambda: Periodic(tuple(own("f_Hz"))),
        "resonance": lambda: Modes.of([Mode(*own("f_Hz", "zeta", "share"))], lag_s),
        "creep": lambda: CreepPart(own("per_decade")[0], own("from_s")[0]).slow_states(span_s, PER_DECADE),
        "delay": lambda: Delay(*own("delay_samples")),
        "slew": lambda: Slew(*own("rate_V_per_s", "rate_V_per_s")),
        "saturation": lambda: Saturation(*own("low_V", "high_V")),
    }
    if cause not in made:
        return Extension(size=PathSize(), lag_s=lag_s) if cause == "memory" else None
    part = made[cause]()
    return Extension(term=part) if isinstance(part, Term) else Extension(block=part, lag_s=lag_s)
