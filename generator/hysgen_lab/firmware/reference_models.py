"""The two models of firmware/models: the paper's Appendix A, and `extended` with hysteresis, creep and delay.

`python -m hysgen_lab.firmware.reference_models FILE` identifies `extended` again on the virtual laboratory stage;
the result ships with the package.
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

import hysgen
from hysgen.firmware import with_learner
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.machine.files import write_whole
from hysgen.model.feedback import Feedback
from hysgen.model.file import dump_model, load_model
from hysgen.model.model import Model
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.record import Record
from hysgen_lab.stage import Stage, StageState
from hysgen_lab.stage.signals import nested_amplitudes, plateaus

Floats = NDArray[np.float64]

TS_S: Final = 20e-6
SENSOR_ZERO_V: Final = 23.0
"""Voltage at which the stage reads 0 um, the zero of Appendix A, as in hysgen_lab.studies.paper.experiments."""

IDENTIFICATION_SEED: Final = 41
LOW_V, HIGH_V = 22.0, 56.0
CAUTIOUS: Final = Feedback(0.004, 0.25)
"""Neither model knows the stage's mode at 780 Hz, where |L| is a fifth with this integral; the one that `hysgen loop`
designs of such a model is thirty times as large, and the stage would not bear it."""
TRAINS: Final = ((100.0, 10), (50.0, 7), (25.0, 4), (10.0, 3))
HOLD_S, TRAVEL_S = 0.5, 0.006
CHIRP_V, CHIRP_HZ, CHIRP_S = 1.5, (300.0, 1500.0), 0.5
"""A chirp small enough for the amplifier, past the mode of the stage, in the record that is diagnosed."""


def laboratory() -> Stage:
    """The laboratory stage with the sensor's zero at SENSOR_ZERO_V: section 4.3's references lie in mid-range."""
    return replace(Stage.laboratory(), zero_V=SENSOR_ZERO_V)


def firmware_models() -> tuple[Model, ...]:
    """The models of firmware/models, each with a learner of the rules' consequents and a feedback."""
    return tuple(replace(with_learner(load_model(name)), feedback=CAUTIOUS) for name in ("appendix_a", "extended"))


def extended() -> Model:
    """The shipped extended model with learner and feedback."""
    return firmware_models()[1]


def extended_drive() -> Floats:
    """Identification input of `extended`, (n,) in V: the whole range, nested loops at four frequencies, levels."""
    middle_V = 0.5 * (LOW_V + HIGH_V)
    levels_V = (middle_V, LOW_V + 6, HIGH_V - 6, middle_V + 5, middle_V - 6, middle_V)
    loops = [nested_amplitudes(TS_S, (f_Hz,), middle_V, 0.5 * (HIGH_V - LOW_V), periods) for f_Hz, periods in TRAINS]
    return np.concatenate(
        [
            _transition(LOW_V, HIGH_V, 0.05),
            _transition(HIGH_V, middle_V, 0.03),
            *loops,
            plateaus(TS_S, levels_V, HOLD_S, TRAVEL_S),
            _transition(middle_V, LOW_V, 0.02),
        ]
    )


def diagnosed_drive() -> Floats:
    """Input of the record that is diagnosed, (n,) in V: a chirp in the middle of the range, then that of `extended`."""
    middle_V, samples = 0.5 * (LOW_V + HIGH_V), round(CHIRP_S / TS_S)
    time_s = np.arange(samples) * TS_S
    turns = CHIRP_HZ[0] * time_s + 0.5 * (CHIRP_HZ[1] - CHIRP_HZ[0]) / CHIRP_S * time_s**2
    chirp_V = middle_V + CHIRP_V * np.hanning(samples) ** 0.25 * np.sin(2.0 * np.pi * turns)
    covered = [_transition(LOW_V, HIGH_V, 0.05), _transition(HIGH_V, middle_V, 0.03)]
    return np.concatenate([*covered, chirp_V, _transition(middle_V, LOW_V, 0.03), extended_drive()])


def diagnosed() -> Model:
    """What `diagnose` delivers of that record, with a learner and the feedback that `hysgen loop` designs around it."""
    model = with_learner(hysgen.diagnose(measured(diagnosed_drive())).model)
    return hysgen.design_loop(model).around(model)


def driven(drive_V: Floats, seed: int) -> tuple[StageState, Floats]:
    """The state of the laboratory stage after a drive (n,) in V, and its readings (n,) in um.

    The stage starts at rest at 0 V and moves smoothly to the first voltage of the drive.
    """
    state = StageState(laboratory(), TS_S, seed)
    lead_V = np.concatenate([_transition(0.0, float(drive_V[0]), 0.05), np.full(2500, drive_V[0])])
    state.advance(lead_V, np.zeros((lead_V.size, 0)))
    trace = state.advance(drive_V, np.zeros((drive_V.size, 0)))
    return state, trace.reading_um


def measured(drive_V: Floats) -> Record:
    """The record of the laboratory stage under a drive, (n,) in V."""
    _, reading_um = driven(drive_V, IDENTIFICATION_SEED)
    return Record.from_arrays(drive_V, reading_um, TS_S, source="identification")


def identified(drive_V: Floats, settings: FitSettings) -> Model:
    """A model of the laboratory stage, fitted to its record under a drive, (n,) in V."""
    return fit(measured(drive_V), settings)


def extended_settings() -> FitSettings:
    """Settings of `extended`: hysteresis, creep, and a delay; the rules are one lag.

    The delay approximates the amplifier, and the mode far below its frequency. The creep per decade is the stage's.
    Polynomials of their own for 12 plays cost no cycles over four hats, and 225 000 rows determine them.
    """
    return FitSettings(
        name="extended",
        method="batch",
        memory=PathSize(plays=12, hats=12),
        blocks=(Delay(1.8), Creep(0.012, (0.03, 0.3, 3.0, 30.0))),
    )


def _transition(from_V: float, to_V: float, seconds: float) -> Floats:
    """A raised cosine from one voltage to another."""
    share = 0.5 * (1.0 - np.cos(np.pi * np.arange(round(seconds / TS_S), dtype=np.float64) * TS_S / seconds))
    voltage_V: Floats = from_V + (to_V - from_V) * share
    return voltage_V


if __name__ == "__main__":
    write_whole(Path(sys.argv[1]), dump_model(identified(extended_drive(), extended_settings())))
