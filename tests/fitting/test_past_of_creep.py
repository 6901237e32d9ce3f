"""What creep goes on adding from a level before the record is known of that record, and is no part of the model."""

from __future__ import annotations

import numpy as np
import pytest

from hysgen.fitting import FitSettings, PathSize, known_past, path_columns, path_model
from hysgen.fitting.identify import path_task
from hysgen.model.path.creep import Creep
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.studies.bank.excitation import good

TS_S, CREEP = 1e-3, (0.02, 0.05, 1e4)


@pytest.mark.parametrize("past_V", [100.0, 60.0])
def test_what_creep_adds_from_an_earlier_level_is_that_of_the_stage_and_not_in_the_model(past_V: float) -> None:
    u_V = good(np.random.default_rng(2), 20_000, 0.0, 100.0)
    stage = Stage.nominal().with_effects(creep=CREEP)
    before_V = np.full(500, past_V)
    moved = run(stage, np.concatenate([before_V, u_V]), TS_S, seed=2).displacement_um[before_V.size :]
    rested = run(stage, u_V, TS_S, seed=3).displacement_um
    record = Record.from_arrays(u_V, moved, TS_S)
    weights = known_past(record)
    rows = np.flatnonzero(weights[0])
    true_um = (moved - rested)[rows]
    creep = Creep.logarithmic(CREEP[0], CREEP[1], 10.0 * TS_S * u_V.size)
    settings = FitSettings(memory=PathSize(plays=4, hats=4, states=2), blocks=(creep,), past=(past_V, TS_S))
    model, crept_um = path_model(path_columns(path_task(record, settings), weights), weights)
    # The level is the mean of both branches of the loop; the stage rested on one of them.
    assert np.std(crept_um[0][rows] - true_um) < 0.2 * np.std(true_um)
    assert crept_um[0][-1] == 0.0  # what is left at the end is the level of the model
    left_um = model.simulate(u_V)[rows] - moved[rows]
    assert np.std(left_um + crept_um[0][rows]) < 0.5 * np.std(left_um)
