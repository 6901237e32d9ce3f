"""The virtual bench on which the paper's experiments are repeated: its stage, its records, and the models fitted there.

The stage is the nominal one (10 um over 120 V, one pole of 1 ms as Appendix A shows it, memory, sensor and converters).
Its constants were set before any experiment was run and are not bent until the paper's figures come out.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting import FitSettings, fit
from hysgen.model.model import Model
from hysgen.model.terms.memory import Memory
from hysgen.record import Record
from hysgen.stage import Stage, run

Floats = NDArray[np.float64]
Variant = Literal["paper", "refined", "memory"]

TS_S = 20e-6
PLAYS = 10

SENSOR_ZERO_V = 23.0
"""Appendix A, run to rest, reads 0 um here: its static line passes 0.66 um at 31 V with 0.083 um/V."""

IDENTIFICATION_SEED, VALIDATION_SEED, TRACKING_SEED = 41, 42, 43


def bench_stage() -> Stage:
    """The stage of section 4, as far as the paper describes it."""
    return replace(Stage.nominal(), zero_V=SENSOR_ZERO_V)


def measure(u_V: Floats, seed: int, source: str, before_V: Floats | None = None) -> Record:
    """Drive the bench's stage and log what its controller sees; `before_V` is driven first and not logged.

    What a stage answers depends on where it was driven before. The experiments of section 4 were made one after the
    other on one stage, so validation and tracking follow the identification.
    """
    lead = np.zeros(0) if before_V is None else before_V
    measured = run(bench_stage(), np.concatenate([lead, u_V]), TS_S, seed)
    return Record.from_arrays(u_V, measured.displacement_um[lead.size :], TS_S, source=source)


def identify(record: Record, name: str, variant: Variant) -> Model:
    """A model of the record.

    "paper": L = 6, lambda = 1, alpha = 1e6, epsilon = 0, Eq. (10), as section 4 sets them.
    "refined": the same structure, its free-run error minimised. "memory": refined, with play operators.
    """
    if variant == "paper":
        return fit(record, FitSettings(name=name, method="rls"))
    if variant == "refined":
        return fit(record, FitSettings(name=name))
    low_V, high_V = record.u_range_V
    memory = Memory.uniform(PLAYS, 0.5 * (high_V - low_V))
    return fit(record, FitSettings(name=name, terms=(memory,)))
