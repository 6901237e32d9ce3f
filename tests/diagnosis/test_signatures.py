"""Each cause's own evidence: it holds where the cause is, and not where something else only looks like it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGING,
    AXIS2_V,
    COUPLED,
    CREEP,
    DRIFTING,
    HUMMING,
    KNOCKED,
    LAG,
    PLANTED,
    SAMPLES,
    SPAN_S,
    T_S,
    TS_S,
    evidence,
    lines_Hz,
    scene,
)
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.creep import crept_step
from hysgen.diagnosis.probe import linear_fit, refine

Floats = NDArray[np.float64]

BESIDE = {"drift": DRIFTING, "aging": AGING, "periodic": HUMMING, "coupling": COUPLED, "unknown": KNOCKED}
"""Chains that hold the causes of which `PLANTED` only has the displacement."""

PRESENT = {name: (BESIDE.get(name, stage), more_um) for name, (stage, more_um) in PLANTED.items()}


@pytest.mark.parametrize("name", PRESENT)
def test_evidence_of_a_planted_cause_is_many_standard_errors(name: str) -> None:
    chain, more_um = PRESENT[name]
    assert evidence(name, scene(chain, more_um, {"axis2_V": AXIS2_V}), chain).z > 5.0


def test_creep_of_a_move_before_the_record_does_not_change_the_estimate() -> None:
    """Creep of an unknown move by half the range before the first sample."""
    before_um = -0.02 * 5.0 * crept_step(T_S, SAMPLES * TS_S, 0.05)
    result = evidence("creep", scene(CREEP, before_um), CREEP).parameters["per_decade"]
    assert result.value == pytest.approx(0.02, rel=0.02)


def test_a_line_with_a_changing_phase_is_not_periodic() -> None:
    turned = np.where(T_S < 0.2 * SPAN_S, -1.0, 1.0) * 0.01 * np.sin(2 * math.pi * 50.3 * T_S)
    fit = linear_fit(scene(LAG, turned), HUMMING)
    result = causes()["periodic"].signature(Residual(scene(LAG, turned), fit), fit)
    assert "phase not kept" in result.text


@pytest.mark.parametrize(("periods", "proposed"), [(8.3, False), (20.3, True)])
def test_a_proposed_line_has_at_least_three_periods_in_each_quarter(periods: float, proposed: bool) -> None:
    seen = scene(LAG, 0.01 * np.sin(2.0 * np.pi * periods * T_S / SPAN_S))
    chains = causes()["periodic"].proposals(Residual(seen, refine(seen, LAG)))
    assert any(abs(line_Hz * SPAN_S - periods) < 1.0 for chain in chains for line_Hz in lines_Hz(chain)) == proposed
