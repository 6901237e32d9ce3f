"""The virtual bench of the paper's experiments: its stage, its records, and the models identified from them.

The stage is the nominal one: 10 um over 120 V, one pole of 1 ms as in Appendix A, hysteresis, sensor, converters. Its
constants were fixed before the experiments were run and are not tuned to the paper's figures.
"""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.model import Model
from hysgen.record import Record
from hysgen_lab.stage import Stage, run

Floats = NDArray[np.float64]
Variant = Literal["paper", "refined", "memory"]

TS_S = 20e-6

SENSOR_ZERO_V = 23.0
"""Voltage at which the stage reads 0 um: the zero of Appendix A's static line, 0.66 um at 31 V and 0.083 um/V."""

IDENTIFICATION_SEED, VALIDATION_SEED, TRACKING_SEED = 41, 42, 43


def bench_stage() -> Stage:
    """The nominal stage with the zero of Appendix A."""
    return replace(Stage.nominal(), zero_V=SENSOR_ZERO_V)


def measure(u_V: Floats, seed: int, source: str, before_V: Floats | None = None) -> Record:
    """The record of one run of the bench's stage under u_V, (n,). `before_V` is applied first and not recorded.

    The response of a stage with hysteresis depends on its past input. The experiments of section 4 were run one after
    the other on one stage, so validation and tracking start where the identification ends.
    """
    lead = np.zeros(0) if before_V is None else before_V
    measured = run(bench_stage(), np.concatenate([lead, u_V]), TS_S, seed)
    return Record.from_arrays(u_V, measured.displacement_um[lead.size :], TS_S, source=source)


def identify(record: Record, variant: Variant) -> Model:
    """A model of the record.

    "paper": L = 6, lambda = 1, alpha = 1e6, epsilon = 0, Eq. (10), as in section 4.
    "refined": the same structure with minimised free-run error. "memory": "refined" behind a hysteresis.
    """
    if variant == "paper":
        return fit(record, FitSettings(name="bench", method="rls"))
    if variant == "refined":
        return fit(record, FitSettings(name="bench"))
    return fit(record, FitSettings(name="bench", memory=PathSize()))
