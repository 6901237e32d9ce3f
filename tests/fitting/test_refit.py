"""Re-identification: same structure, new numbers; only parameter file, self-test and manifest change."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hysgen.api.code import _as_before
from hysgen.codegen import generate, write
from hysgen.errors import ModelError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.fitting.refit import refit
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes

TS_S = 1e-4


def record_of(stage: Stage, seed: int) -> Record:
    u_V = nested_amplitudes(TS_S, (50.0, 20.0), 40.0, 25.0, 4)
    return Record.from_arrays(u_V, run(stage, u_V, TS_S, seed).displacement_um, TS_S, source=f"seed {seed}")


@pytest.fixture(scope="module")
def records() -> tuple[Record, Record]:
    """The stage, and the stage with an actuator that moves a tenth further."""
    stage = Stage.nominal()
    return record_of(stage, 1), record_of(dataclasses.replace(stage, stroke_um=1.1 * stage.stroke_um), 2)


@pytest.mark.slow
def test_refit_fits_the_whole_record_and_keeps_the_ranges_of_a_restricted_model_and_of_a_folder(
    records: tuple[Record, Record], tmp_path: Path
) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    whole, _ = refit(old, records[1])
    part = old.within((old.grid.y_min_um + 0.3, old.grid.y_max_um - 0.3), (0.5 * old.u_max_V, 0.75 * old.u_max_V))
    code = generate(part)
    write(code, tmp_path)
    for again in (refit(part, records[1])[0], _as_before(whole, tmp_path)[0]):
        assert (again.grid.y_min_um, again.grid.y_max_um) == (part.grid.y_min_um, part.grid.y_max_um)
        assert (again.u_min_V, again.u_max_V, again.grid.ends_um) == (part.u_min_V, part.u_max_V, whole.grid.ends_um)
        np.testing.assert_array_equal(again.parameters, whole.parameters)
        assert generate(again)["axis.c"] == code["axis.c"]


def test_a_record_at_another_rate_is_refused(records: tuple[Record, Record]) -> None:
    old = fit(records[0], FitSettings(method="batch"))
    half = Record.from_arrays(records[1].segments[0].u_V[::2], records[1].segments[0].y_um[::2], 2 * TS_S)
    with pytest.raises(ModelError, match="record at the model's rate"):
        refit(old, half)
    assert np.isfinite(old.parameters).all()
