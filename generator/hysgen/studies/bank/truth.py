"""The best that a model family can do on a scenario: the same models, fitted with the truth about the stage known.

Shape parameters are those of the plant; drift, aging and corrupted samples are not in the record that the model is
fitted to, because the plant is run without them. What remains to the fit are the linear parameters.
"""

from __future__ import annotations

import numpy as np

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
from hysgen.studies.bank.scenario import JUDGED_TOO, Scenario

UNSEEN = ("drift", "aging", "outliers")


def error_with_truth_known(hidden: Scenario) -> float:
    """Free-run rms in um on the held-out rows of the model with every planted cause extended by the plant's numbers."""
    stage = hidden.stage.with_effects(**dict.fromkeys(UNSEEN))
    y_um = measure(stage, hidden.u_V, hidden.Ts_s, hidden.seed, hidden.aux).displacement_um
    prepared = prepare(Record.from_arrays(hidden.u_V, y_um, hidden.Ts_s, hidden.aux, accept=JUDGED_TOO))
    extensions = true_extensions(hidden)
    rung = fit_ladder(prepared, extensions, list(extensions), FitSettings())
    return rms(rung.error_um[prepared.held_rows])


def true_extensions(hidden: Scenario) -> dict[str, Extension]:
    """The extension of every planted cause that acts on the model, with the numbers of the plant."""
    stage, found = hidden.stage, {}
    low_V, high_V = float(hidden.u_V.min()), float(hidden.u_V.max())
    if stage.saturation:
        level = stage.saturation
        found["saturation"] = Extension(block=Saturation(level.low_V, level.high_V))
        low_V, high_V = max(low_V, level.low_V), min(high_V, level.high_V)
    if "memory" in hidden.planted:
        found["memory"] = Extension(term=usual_memory(low_V, high_V))
    if stage.slew:
        found["slew"] = Extension(block=Slew(stage.slew.V_per_s, stage.slew.V_per_s))
    if stage.delay:
        found["delay"] = Extension(block=Delay(stage.delay.samples))
    if stage.creep:
        span_s = hidden.Ts_s * len(hidden.u_V)
        found["creep"] = Extension(term=creep_term(stage.creep.tau_min_s, span_s))
    if stage.resonance:
        modes = sorted((mode.f_Hz, mode.zeta) for mode in stage.resonance)
        found["resonance"] = Extension(term=Resonance(tuple(f for f, _ in modes), tuple(zeta for _, zeta in modes)))
    if stage.periodic:
        found["periodic"] = Extension(term=Periodic(tuple(sorted(line.f_Hz for line in stage.periodic))))
    if stage.coupling:
        channels = {name: np.asarray(hidden.aux[name]) for name in stage.coupling.um_per_unit}
        ranges = {name: (float(values.min()), float(values.max())) for name, values in channels.items()}
        found["coupling"] = Extension(term=coupling_term(ranges))
    return found
