"""Slow causes below the misfit of the hysteresis: seen while the stage rests, and named by both descriptions of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import AGING, COMMAND_V, CREEP, DRIFTING, LAG, SPAN_S, T_S, TS_S, named, scene
from hysgen.diagnosis import search
from hysgen.diagnosis.probe import Chain, refine
from hysgen.diagnosis.probe.chain import respond
from hysgen.diagnosis.score import LEAST_EVIDENCE, Scored
from hysgen.diagnosis.slow_evidence import Whitenings, adds_first_slow_cause

Floats = NDArray[np.float64]

CURVED_UM = 0.2 * respond(np.sin(0.4 * np.pi * COMMAND_V), LAG, TS_S)
"""Displacement in um that the curve of the linear operator cannot follow: the misfit."""

DRIFT_UM = 0.05 * T_S / SPAN_S
"""A ramp whose standard deviation is a quarter of the misfit that a fit leaves, (SAMPLES,)."""


def fitted(more_um: Floats, *chains: Chain) -> list[Scored]:
    seen = scene(LAG, CURVED_UM + more_um)
    return [Scored.of(seen, refine(seen, chain)) for chain in chains]


@pytest.mark.parametrize("size", [0.0, 1.0])
def test_a_drift_below_the_misfit_is_evident_while_the_stage_rests(size: float) -> None:
    none, drift = fitted(size * DRIFT_UM, LAG, DRIFTING)
    assert none.fit.rms_um > 3.0 * np.std(DRIFT_UM)
    assert drift.fall_from(none) < LEAST_EVIDENCE
    assert (Whitenings(none.scene).pooled_fall(drift, none, LEAST_EVIDENCE) > LEAST_EVIDENCE) == (size > 0.0)


@pytest.mark.slow
def test_the_search_names_a_drift_below_the_misfit() -> None:
    seen = scene(LAG, CURVED_UM + DRIFT_UM)
    found = search.search(seen)
    assert named(found) == ["drift"]
    assert found.confidence["drift"] > 0.99
    assert named(search.search(scene(LAG, CURVED_UM))) == []


@pytest.mark.slow
def test_one_description_alone_names_no_slow_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """The score finds the drift of a stage without misfit; if the whitened residuals contradict it, it is not named."""
    seen = scene(LAG, 0.05 * T_S / SPAN_S)
    monkeypatch.setattr(Whitenings, "pooled_fall", lambda *chains: 0.0)
    assert named(search.search(seen)) == []


def test_the_lower_bound_of_a_pooled_fall_needs_no_whitening(monkeypatch: pytest.MonkeyPatch) -> None:
    none, drift = fitted(1.0 * T_S / SPAN_S, LAG, DRIFTING)
    exact = Whitenings(none.scene).pooled_fall(drift, none, math.inf)
    monkeypatch.setattr(Whitenings, "whitened_fall", None)
    assert LEAST_EVIDENCE < Whitenings(none.scene).pooled_fall(drift, none, LEAST_EVIDENCE) < exact


def test_whitened_scores_tell_drift_creep_and_aging_apart_below_the_misfit() -> None:
    chains = {"drift": DRIFTING, "creep": CREEP, "aging": AGING}
    aged_um = 0.1 * 0.005 * T_S * respond(COMMAND_V, LAG, TS_S)
    crept_um = 0.1 * (respond(COMMAND_V, CREEP, TS_S) - respond(COMMAND_V, LAG, TS_S))
    for planted, more_um in (("drift", DRIFT_UM), ("aging", aged_um), ("creep", crept_um)):
        none, *candidates = fitted(more_um, LAG, *chains.values())
        whitenings = Whitenings(none.scene)
        scores = dict(zip(chains, whitenings.scores(candidates, none.fit), strict=True))
        assert min(scores, key=lambda name: scores[name]) == planted
        current = candidates[list(chains).index(planted)]
        assert whitenings.confidence(current, none, 20.0, [none, *candidates]) > 0.99
        assert whitenings.confidence(current, none, 0.0, [none, *candidates]) < 0.6


def test_only_the_first_slow_cause_has_this_evidence() -> None:
    none, drift, both = fitted(DRIFT_UM, LAG, DRIFTING, DRIFTING.having(AGING.parts[0]))
    assert adds_first_slow_cause(drift, none)
    assert not adds_first_slow_cause(both, drift)
    assert not adds_first_slow_cause(both, none)
    assert not adds_first_slow_cause(none, none)
