"""The two models whose firmware is kept in firmware/models: the paper's Appendix A, and one with memory and creep.

`python -m hysgen.firmware.reference_models FILE` identifies the extended one again on the virtual laboratory stage;
the result is shipped as the model `extended`.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting import FitSettings, fit
from hysgen.machine.files import write_whole
from hysgen.model.file import dump_model, load_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path.delay import Delay
from hysgen.model.terms.creep import Creep
from hysgen.model.terms.memory import Memory
from hysgen.record import Record
from hysgen.stage import Stage, StageState
from hysgen.stage.signals import nested_amplitudes, plateaus

Floats = NDArray[np.float64]

TS_S: Final = 20e-6
SENSOR_ZERO_V: Final = 23.0
"""Appendix A, run to rest, reads 0 um here, as on the bench of hysgen.studies.paper."""

IDENTIFICATION_SEED: Final = 41
LOW_V, HIGH_V = 22.0, 56.0
TRAINS: Final = ((100.0, 10), (50.0, 7), (25.0, 4), (10.0, 3))
HOLD_S, TRAVEL_S = 0.5, 0.006

CALLS_PER_UPDATE: Final = 8
LEARNER_ALPHA: Final = 1e-6


def laboratory() -> Stage:
    """The laboratory stage, its sensor zeroed so that section 4.3's references lie in mid-range."""
    return replace(Stage.laboratory(), zero_V=SENSOR_ZERO_V)


def firmware_models() -> tuple[Model, ...]:
    """The models of firmware/models, each with a learner."""
    return (with_learner(load_model("appendix_a")), extended())


def with_learner(model: Model) -> Model:
    """The model with a learner of all its parameters, one update spread over several samples.

    The prior trusts the identification (alpha), and nothing is forgotten until the window is full: one sine does not
    excite all parameters, and those that it does not excite must not wander off to where commit refuses them.
    """
    return replace(
        model, learner=LearnerSettings(forgetting=1.0, alpha=LEARNER_ALPHA, calls_per_update=CALLS_PER_UPDATE)
    )


def extended() -> Model:
    """The shipped extended model."""
    return with_learner(load_model("extended"))


def extended_drive() -> Floats:
    """What identifies it, (n,) in V: once through the range, nested loops at four frequencies, levels."""
    middle_V = 0.5 * (LOW_V + HIGH_V)
    levels_V = (middle_V, LOW_V + 6, HIGH_V - 6, middle_V + 5, middle_V - 6, middle_V)
    loops = [nested_amplitudes(TS_S, (f_Hz,), middle_V, 0.5 * (HIGH_V - LOW_V), periods) for f_Hz, periods in TRAINS]
    return np.concatenate(
        [
            _way(LOW_V, HIGH_V, 0.05),
            _way(HIGH_V, middle_V, 0.03),
            *loops,
            plateaus(TS_S, levels_V, HOLD_S, TRAVEL_S),
            _way(middle_V, LOW_V, 0.02),
        ]
    )


def driven(drive_V: Floats, seed: int) -> tuple[StageState, Floats]:
    """The laboratory stage after rest at 0 V, a way to the drive's first voltage, and the drive (n,); readings (n,)."""
    state = StageState(laboratory(), TS_S, seed)
    lead_V = np.concatenate([_way(0.0, float(drive_V[0]), 0.05), np.full(2500, drive_V[0])])
    state.advance(lead_V, np.zeros((lead_V.size, 0)))
    trace = state.advance(drive_V, np.zeros((drive_V.size, 0)))
    return state, trace.reading_um


def measured(drive_V: Floats) -> Record:
    """What the laboratory stage answers to a drive."""
    _, reading_um = driven(drive_V, IDENTIFICATION_SEED)
    return Record.from_arrays(drive_V, reading_um, TS_S, source="identification")


def identified(drive_V: Floats, settings: FitSettings) -> Model:
    """A model of the laboratory stage from its answer to a drive."""
    return fit(measured(drive_V), settings)


def extended_settings() -> FitSettings:
    """Memory, creep with one weight, and a delay, which stands for the amplifier and, far below it, for the mode.

    The loop gain of the plays stays below 0.8, because the learner's commit needs room there.
    """
    return FitSettings(
        name="extended",
        terms=(Memory.polynomial(6, 1, LOW_V, HIGH_V), Creep((0.03, 0.3, 3.0, 30.0), shared=True)),
        blocks=(Delay(1.8),),
        loop_limit=0.8,
    )


def _way(from_V: float, to_V: float, seconds: float) -> Floats:
    share = 0.5 * (1.0 - np.cos(np.pi * np.arange(round(seconds / TS_S), dtype=np.float64) * TS_S / seconds))
    way_V: Floats = from_V + (to_V - from_V) * share
    return way_V


if __name__ == "__main__":
    write_whole(Path(sys.argv[1]), dump_model(identified(extended_drive(), extended_settings())))
