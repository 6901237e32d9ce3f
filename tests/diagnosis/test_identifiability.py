"""What a record can tell: the least effect holds its promise, hidden and missing effects are told apart."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fixtures.linear_stage import AXIS2_V, LAG, SPAN_S, T_S, scene
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.identifiability import Ability, abilities
from hysgen.diagnosis.probe import Scene, refine
from hysgen.diagnosis.search import search


def told(seen: Scene, chain: object = LAG) -> dict[str, Ability]:
    residual = Residual(seen, refine(seen, chain))  # type: ignore[arg-type]
    return {one.name: one for one in abilities(residual, residual, {"memory": None})}


@pytest.mark.parametrize(("times", "holds"), [(2.0, True), (0.3, False)])
@pytest.mark.slow
def test_a_drift_shows_from_the_least_size_on(times: float, holds: bool) -> None:
    least = told(scene(LAG))["drift"].least
    assert least is not None
    found = search(scene(LAG, times * least * T_S))
    assert causes()["drift"].present(found.fit.chain) == holds


def test_a_drift_beside_a_gain_about_an_unknown_zero_is_less_certain() -> None:
    alone, beside = told(scene(LAG))["drift"], told(scene(LAG), LAG.having(AgingPart(1e-3 / SPAN_S)))["drift"]
    assert alone.least is not None
    assert beside.least is not None
    assert beside.least > 1.2 * alone.least


def test_a_record_without_channels_cannot_show_coupling() -> None:
    assert told(scene(LAG))["coupling"].verdict == "not excited"
    assert told(scene(LAG, aux={"axis2_V": AXIS2_V}))["coupling"].verdict == "above"


def test_a_cause_that_copies_a_part_of_the_chain_is_hidden_by_it() -> None:
    """A channel that is a straight line in time, beside a drift."""
    seen = scene(LAG, 0.1 * T_S, aux={"clock": T_S.copy()})
    coupling = told(seen, LAG.having(DriftPart()))["coupling"]
    assert (coupling.verdict, coupling.hidden_by) in {("hidden", "drift"), ("not excited", "")}


def test_a_command_that_stands_still_excites_no_delay() -> None:
    moving = scene(LAG)
    run = dataclasses.replace(moving.runs[0], u_V=np.full_like(moving.runs[0].u_V, 5.0))
    still = dataclasses.replace(moving.bare(), runs=(run,))
    assert told(still)["delay"].verdict == "not excited"


def test_every_ability_says_what_to_record() -> None:
    for ability in told(scene(LAG)).values():
        assert ability.verdict == "named" or ability.experiment
        assert ability.text()
