"""Evidence by two hysteresis operators: what only the form of one of them makes likely is not named."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import COMMAND_V, DRIFTING, LAG, SPAN_S, T_S, TS_S, named, scene
from hysgen.diagnosis import search, search_steps
from hysgen.diagnosis.causes.unknown import CAUSE, SuddenPart
from hysgen.diagnosis.probe import Chain, refine
from hysgen.diagnosis.probe.chain import respond
from hysgen.diagnosis.score import LEAST_EVIDENCE, Scored
from hysgen.diagnosis.slow_evidence import SecondOperator

Floats = NDArray[np.float64]
PLAIN = dataclasses.replace(LAG, memory=True)
DRIFT = PLAIN.having(DRIFTING.parts[0])
WAVES_UM = 0.2 * respond(np.sin(0.12 * np.pi * COMMAND_V), LAG, TS_S)
"""Displacement in um that neither operator follows: the misfit."""


def states(drift_um: float) -> tuple[search_steps.State, Scored, Scored]:
    """The state of a search with a linear operator, the chain with a drift, and the one without."""
    seen = scene(LAG, WAVES_UM + drift_um * T_S / SPAN_S)
    none, drift = (Scored.of(seen, refine(seen, chain)) for chain in (PLAIN, DRIFT))
    return search._begin(seen, none.fit), drift, none


def test_small_evidence_is_the_mean_of_both_operators() -> None:
    state, drift, none = states(0.04)
    by_first = search_steps._rise_by_one_operator(state.whitenings, drift, none)
    other = SecondOperator(state.scene)
    by_second = search_steps._rise_by_one_operator(other.whitenings, other.scored(DRIFT), other.scored(PLAIN))
    assert 0.0 < by_first < 3.0 * LEAST_EVIDENCE
    assert abs(by_first - by_second) > 0.1
    assert search_steps.rise_without(state, drift, none) == pytest.approx(0.5 * (by_first + by_second), rel=1e-4)


def test_a_cause_of_both_chains_that_is_observed_takes_no_part() -> None:
    """The evidence of a jump differs a little with the drift beside it."""
    jump_um = 0.4 * (T_S >= 2.0)
    seen = scene(LAG, WAVES_UM + 0.04 * T_S / SPAN_S + jump_um)
    none, drift = (Scored.of(seen, refine(seen, one.having(SuddenPart((2.0,))))) for one in (PLAIN, DRIFT))
    state = search._begin(seen, none.fit)
    assert none.evidence > 0.0
    assert none.evidence != drift.evidence
    by_first = search_steps._rise_by_one_operator(state.whitenings, drift, none)
    by_second = search_steps._rise_by_one_operator(
        state.second.whitenings, *(state.second.scored(one.chain) for one in (drift, none))
    )
    assert by_first > 0.0
    assert search_steps.rise_without(state, drift, none) == pytest.approx(0.5 * (by_first + by_second), rel=1e-4)


def test_the_second_operator_is_not_asked_where_it_could_not_change_the_decision(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def asked(self: SecondOperator, chain: Chain) -> Scored:
        raise AssertionError(chain)

    monkeypatch.setattr(SecondOperator, "scored", asked)
    state, drift, none = states(0.1)
    assert search_steps.rise_without(state, drift, none) > LEAST_EVIDENCE
    state, drift, none = states(0.0)
    assert search_steps.rise_without(state, drift, none) <= 0.0


@pytest.mark.slow
def test_jumps_below_the_misfit_are_evident_between_two_samples() -> None:
    """Up, up and down, on a misfit twice as large."""
    planted_s = (0.9, 2.0, 3.1)
    stairs_um = 0.06 * sum(sign * (t_s <= T_S) for sign, t_s in zip((1.0, 1.0, -1.0), planted_s, strict=True))
    bent_um = 0.2 * respond(np.sin(0.06 * np.pi * COMMAND_V), LAG, TS_S)

    def evidence(more_um: Floats, *times_s: float) -> float:
        seen = scene(LAG, more_um)
        return CAUSE.evidence(seen, refine(seen, LAG.having(SuddenPart(times_s))))

    assert evidence(bent_um + stairs_um, *planted_s) > 3.0 * LEAST_EVIDENCE
    assert evidence(bent_um + stairs_um, 1.4) == 0.0
    assert evidence(bent_um, *planted_s) == 0.0
    found = search.search(scene(LAG, bent_um + stairs_um))
    assert named(found) == ["unknown"]
    for at_s in found.fit.chain.of(SuddenPart).times_s:
        assert min(abs(at_s - true_s) for true_s in planted_s) < 2.0 * TS_S
    assert named(search.search(scene(LAG, bent_um))) == []
