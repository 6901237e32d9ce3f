"""Misfit that moves with the stage: its innovations, the creep they tell, and which slow cause they find likelier."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGED_UM,
    AGING,
    CREEP,
    DRIFTING,
    LAG,
    SPAN_S,
    T_S,
    scene,
)
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, refine, whitened_fit
from hysgen.diagnosis.search import present
from hysgen.diagnosis.swaps import compare_likelihood, likeliest_slow_causes
from hysgen.machine.kernels import innovation_gains, innovations
from hysgen.record import Record
from hysgen.stage import Density, NoiseEffect, Relays, Stage
from hysgen.stage import run as measure
from hysgen.studies.bank.excitation import good

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
        if signature.holds:
            plain.append(abs((fit.chain.parts[0].values[0]) / 0.006 - 1.0))
            result.append(abs(signature.parameters["per_decade"].value / 0.006 - 1.0))
    assert len(result) >= 4
    assert max(result) < 0.15
    assert max(plain) > 0.5


@pytest.mark.parametrize(
    ("hidden", "more_um", "wrong", "right"),
    [
        (LAG, 0.01 * T_S / SPAN_S, AGING, "drift"),
        (LAG, AGED_UM, DRIFTING, "aging"),
        (CREEP, 0.0, DRIFTING, "creep"),
        (LAG, 0.002 * T_S / SPAN_S, CREEP, "drift"),
        (LAG, 0.01 * T_S / SPAN_S, DRIFTING, "drift"),
        (LAG, AGED_UM, AGING, "aging"),
    ],
)
def test_a_slow_cause_is_swapped_for_one_with_a_much_larger_likelihood(
    hidden: Chain, more_um: Floats | float, wrong: Chain, right: str
) -> None:
    seen = scene(hidden, more_um)
    assert present(likeliest_slow_causes(seen, refine(seen, wrong))) == [right]


def test_slow_causes_whose_signatures_all_hold_are_kept() -> None:
    seen = scene(CREEP, 0.01 * T_S / SPAN_S)
    both = refine(seen, CREEP.having(DriftPart()))
    assert likeliest_slow_causes(seen, both) == both.chain


@pytest.mark.parametrize("right", [["drift"], ["creep"], ["aging", "drift"]])
def test_slow_causes_are_swapped_if_one_signature_does_not_hold(right: list[str]) -> None:
    more_um = (0.1 * T_S / SPAN_S if "drift" in right else 0.0) + (AGED_UM if "aging" in right else 0.0)
    seen = scene(CREEP if "creep" in right else LAG, more_um)
    wrong = LAG.having(CreepPart(0.001, 0.05)).having(AgingPart(1e-5))
    chain = likeliest_slow_causes(seen, refine(seen, wrong))
    assert sorted(present(chain)) == right


def test_a_drift_beside_creep_is_needed_by_the_likelihood() -> None:
    for more_um, needed in ((0.004 * T_S / SPAN_S, ["creep", "drift"]), (0.0, ["creep"])):
        seen = scene(CREEP, more_um)
        both = refine(seen, CREEP.having(DriftPart()))
        rivals = {name: refine(seen, causes()[name].without(both.chain)) for name in ("creep", "drift")}
        assert compare_likelihood(seen, both, rivals) == needed
        assert compare_likelihood(seen, rivals["drift"], {}) == []


def test_unused_samples_do_not_change_the_innovations() -> None:
    seen = scene(CREEP)
    rows = seen.rows[seen.rows % 100 != 0]
    spiked_um = seen.y_um.copy()
    spiked_um[::100] += 50.0
    spiked = dataclasses.replace(seen, runs=(dataclasses.replace(seen.runs[0], y_um=spiked_um),))
    chains = [whitened_fit(one.using(rows), refine(one.using(rows), CREEP))[1].chain for one in (seen, spiked)]
    assert chains[0] == chains[1]
