"""The bank: records with hidden effects, and the causes that a diagnosis must name in them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hysgen_lab.stage.families import FAMILIES
from hysgen_lab.studies.bank import BankResult, run, scenario
from hysgen_lab.studies.bank.family_scenario import family_scenario
from hysgen_lab.studies.bank.limits import PARAMETERS
from hysgen_lab.studies.bank.result import Judgement
from hysgen_lab.studies.bank.scenario import CATEGORIES, EFFECTS

SWEEP = (("pair", 1), ("creep", 0), ("none", 3))
"""Category and seed of the records of the sweep. The pair plants saturation and resonance.

The tests of tests/diagnosis diagnose the other categories, and `python -m hysgen_lab bank` hundreds of records of each.
"""


@pytest.fixture(scope="module")
def sweep(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> BankResult:
    judged = once_per_run("bank_sweep", lambda: [run([seed], [category]) for category, seed in SWEEP])
    return BankResult(tuple(record for result in judged for record in result.judgements), (0, 1, 3), len(SWEEP))


@pytest.mark.slow
def test_records_are_answered_with_the_planted_causes_and_no_other(sweep: BankResult) -> None:
    assert {each.category: (each.required, each.named) for each in sweep.judged() if not each.exact} == {}
    assert sweep.false_alarm_rate == 0.0


@pytest.mark.slow
def test_parameters_of_named_causes_lie_within_their_tolerances(sweep: BankResult) -> None:
    seen = sweep.parameter_errors()
    assert {key: error for key, (_, error, _) in seen.items() if error > PARAMETERS.get(key, np.inf)} == {}
    assert len(seen) >= 3


@pytest.mark.slow
def test_the_extended_model_comes_near_the_one_that_knows_the_planted_causes(sweep: BankResult) -> None:
    """Its held-out error is at most twice that of the model with the true extensions, the limit of the bank."""
    assert all(not each.over_truth > 2.0 for each in sweep.judged())


def test_same_seed_makes_the_same_scenario() -> None:
    for category in CATEGORIES:
        first, second = scenario(category, 7), scenario(category, 7)
        assert first.stage == second.stage
        np.testing.assert_array_equal(first.u_V, second.u_V)


def test_category_plants_the_effect_that_it_is_named_after() -> None:
    for effect in EFFECTS:
        assert effect in scenario(effect, 11).planted
    assert scenario("none", 11).planted == ()
    assert scenario("memory", 11).planted == ("memory",)
    assert "unknown" in scenario("unknown", 11).planted


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.slow
def test_stage_of_another_family_has_its_hysteresis_and_the_planted_effect(family: str) -> None:
    for category in ("aging", "coupling", "resonance", "unknown"):
        first, second = family_scenario(family, category, 11), family_scenario(family, category, 11)
        assert first.stage == second.stage
        assert isinstance(first.stage.memory, FAMILIES[family])
        assert category in first.planted
        np.testing.assert_array_equal(first.u_V, second.u_V)
    assert family_scenario(family, "none", 11).planted == ()


def test_record_of_another_family_lacks_its_past_and_has_the_steps_of_its_converter() -> None:
    hidden = family_scenario("bouc-wen", "creep", 5)
    measured = hidden.measure()
    record = hidden.record(measured)
    assert record.samples == len(hidden.u_V) - hidden.past
    codes = (
        np.diff(np.unique(record.segments[0].y_um)) / (2.0 * np.ptp(measured.displacement_um)) * 2**hidden.sensor.bits
    )
    assert np.median(codes) == pytest.approx(np.round(np.median(codes)), abs=1e-3)
    assert codes.min() > 0.99


def test_thermal_hysterons_may_be_named_creep_and_no_other_family() -> None:
    shown = {family: family_scenario(family, "memory", 1).allowed for family in FAMILIES}
    assert {family for family, names in shown.items() if names} == {"thermal"}
    made = judgement(("memory",), ("memory", "creep"), ("memory",), "memory")
    assert not made.exact
    assert dataclasses.replace(made, allowed=shown["thermal"]).exact


def judgement(required: tuple[str, ...], named: tuple[str, ...], planted: tuple[str, ...], category: str) -> Judgement:
    return Judgement(category, 0, 1e3, "good", planted, required, named, dict.fromkeys(planted, 2.0), {}, 0.1, "")
