"""The error of the extended model with the truth known: a bound for the error after a diagnosis.

The shape parameters of the extensions are those of the plant, and the plant is run without the effects that extensions
only take out of a record. The fit finds the linear parameters.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.evaluation import Extension, free_run_error, prepare
from hysgen.diagnosis.known_plant import true_extension
from hysgen.diagnosis.probe import rms
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
