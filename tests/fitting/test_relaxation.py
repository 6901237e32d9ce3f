"""Plays that relax: the fit finds the relaxation of a plant that has it, and keeps it through file and refit."""

from __future__ import annotations

import dataclasses

import numpy as np

from fixtures.generated_models import relaxing
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.fitting.operator import SEARCHED
from hysgen.fitting.refit import refit
from hysgen.model.file import dump_model, parse_model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.scores import score
from hysgen.record import Record
from hysgen.stage.families.commands import command

TS_S, TAU_S = 1e-3, 5e-3


def measured(relaxation: float, seed: int) -> Record:
    """4000 samples of five plays behind a lag, with a noise of 0.1 nm."""
    rng = np.random.default_rng(seed)
    u = command(rng, 4000, -20.0, 120.0, 50.0)
    w = dataclasses.replace(relaxing(), relaxation=relaxation, duhem_um=()).apply(u, TS_S)
    a, y = np.exp(-TS_S / TAU_S), np.empty_like(w)
    y[0] = w[0]
    for k in range(len(w) - 1):
        y[k + 1] = a * y[k] + (1.0 - a) * w[k]
    return Record.from_arrays(u, y + 1e-4 * rng.standard_normal(len(y)), Ts_s=TS_S)


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
