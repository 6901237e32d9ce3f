"""Plays that relax: the fit finds the relaxation of a plant that has it, and keeps it through file and refit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from fixtures.generated_models import relaxing
from hysgen.certify.certificates import certify
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.fitting.operator import SEARCHED
from hysgen.fitting.refit import refit
from hysgen.model.file import dump_model, parse_model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.scores import score
from hysgen.record import Record
from hysgen_lab.stage.families.commands import command

TS_S, TAU_S = 1e-3, 5e-3


def measured(relaxation: float, seed: int, plays_um: tuple[float, ...] = relaxing().plays_um) -> Record:
    """4000 samples of five plays behind a lag, with a noise of 0.1 nm."""
    rng = np.random.default_rng(seed)
    u = command(rng, 4000, -20.0, 120.0, 50.0)
    w = dataclasses.replace(relaxing(), relaxation=relaxation, duhem_um=(), plays_um=plays_um).apply(u, TS_S)
    a, y = np.exp(-TS_S / TAU_S), np.empty_like(w)
    y[0] = w[0]
    for k in range(len(w) - 1):
        y[k + 1] = a * y[k] + (1.0 - a) * w[k]
    return Record.from_arrays(u, y + 1e-4 * rng.standard_normal(len(y)), Ts_s=TS_S)


@pytest.mark.slow
def test_the_fit_finds_the_relaxation_and_refit_keeps_its_search() -> None:
    known, fresh = measured(0.03, 1), measured(0.03, 2)
    sizes = [PathSize(plays=8, states=0, relaxation=relaxation) for relaxation in (SEARCHED, 0.0)]
    found, rigid = (fit(known, FitSettings(method="batch", memory=size)) for size in sizes)
    block = next(block for block in found.blocks if isinstance(block, Hysteresis))
    # Half-widths of the fit are not those of the plant, so the relaxation is not exact.
    assert 0.022 < block.relaxation < 0.04
    assert score(found, fresh).free_run.e_rms_um < 0.5 * score(rigid, fresh).free_run.e_rms_um
    again = parse_model(dump_model(found), "found")
    assert again.blocks == found.blocks
    renewed, _ = refit(again, measured(0.045, 3))
    block = next(block for block in renewed.blocks if isinstance(block, Hysteresis))
    assert 0.034 < block.relaxation < 0.06


def test_no_fitted_density_is_negative_even_where_that_of_the_stage_is() -> None:
    plays_um = np.array(relaxing().plays_um).reshape(5, 3)
    plays_um[2, 0] = -0.3
    record = measured(0.03, 4, tuple(plays_um.ravel().tolist()))
    model = fit(record, FitSettings(method="batch", memory=PathSize(plays=5, states=1, hats=5, relaxation=0.03)))
    block = next(block for block in model.blocks if isinstance(block, Hysteresis))
    for row, end in zip(block.series.plays, block.ends, strict=True):
        z = np.linspace(-end, end, 501)
        slopes = chebyshev.chebval(z, chebyshev.chebder(np.array([0.0, *row])))
        assert slopes.min() > -1e-3 * block.mean_slope
    b, c = block.duhem_um
    assert min(b, b + 2.0 * c) > -1e-3 * block.mean_slope
    slopes = certify(model).path.slopes
    assert slopes is not None
    assert slopes.proved
