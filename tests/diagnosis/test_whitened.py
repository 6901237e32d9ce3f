"""Misfit that moves with the stage: its innovations, the creep they tell, and which slow cause they find likelier."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fixtures.linear_stage import (
    CREEP,
    scene,
)
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, refine, whitened_fit
from hysgen.machine.kernels.run import innovation_gains, innovations
from hysgen.record import Record
from hysgen_lab.stage import Density, NoiseEffect, Relays, Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.studies.bank.excitation import good

Floats = NDArray[np.float64]


@given(seed=st.integers(0, 2**32 - 1), misfit=st.floats(0.01, 10.0), noise=st.floats(0.01, 10.0))
def test_innovations_have_the_likelihood_of_the_dense_covariance(seed: int, misfit: float, noise: float) -> None:
    rng = np.random.default_rng(seed)
    n = 30
    keep, heard, z = rng.random(n) ** 0.3, (rng.random(n) < 0.8).astype(float), rng.normal(size=n)
    heard[0] = 1.0
    gain, variance = innovation_gains(keep, heard, misfit, noise)
    rows = np.flatnonzero(heard)
    news = innovations(z[None], keep, gain, variance)[0, rows]
    # What two samples share of the misfit is what every step between them keeps of it.
    kept = np.exp(np.add.outer(-np.cumsum(np.log(keep)), np.cumsum(np.log(keep))))
    covariance = misfit * np.minimum(kept, kept.T)[np.ix_(rows, rows)] + noise * np.eye(len(rows))
    assert news @ news == pytest.approx(z[rows] @ np.linalg.solve(covariance, z[rows]), rel=1e-9)
    assert np.log(variance[rows]).sum() == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-9, abs=1e-9)


@pytest.mark.slow
def test_creep_is_identified_from_plateaus_beside_a_coarse_hysteresis() -> None:
    """150 relays jump where no smooth density does; what that leaves takes the place of creep, unless it rests too."""
    plain, result = [], []
    for seed in range(6):
        hysteresis = Relays(Density(40.0, 55.0, 15.0, 65.0), 0.4, count=150)
        stage = Stage(stroke_um=15.0, lag_s=8e-3, memory=hysteresis, noise=NoiseEffect(5e-4))
        u_V = good(np.random.default_rng([seed, 77]), 7000, 0.0, 100.0)
        y_um = measure(stage.with_effects(creep=(0.006, 0.015, 7000.0)), u_V, 1e-3, seed).displacement_um
        seen = prepare(Record.from_arrays(u_V, y_um, 1e-3)).scene()
        fit = refine(seen, Chain(8e-3, (CreepPart(0.003, 0.05),)), rounds=30)
        signature = causes()["creep"].signature(Residual(seen, fit), fit)
        if signature.z > 4.0:
            plain.append(abs((fit.chain.parts[0].values[0]) / 0.006 - 1.0))
            result.append(abs(signature.parameters["per_decade"].value / 0.006 - 1.0))
    assert len(result) >= 4
    assert max(result) < 0.15
    assert max(plain) > 0.5


def test_unused_samples_do_not_change_the_innovations() -> None:
    seen = scene(CREEP)
    rows = seen.rows[seen.rows % 100 != 0]
    spiked_um = seen.y_um.copy()
    spiked_um[::100] += 50.0
    spiked = dataclasses.replace(seen, runs=(dataclasses.replace(seen.runs[0], y_um=spiked_um),))
    chains = [whitened_fit(one.using(rows), refine(one.using(rows), CREEP))[1].chain for one in (seen, spiked)]
    assert chains[0] == chains[1]
