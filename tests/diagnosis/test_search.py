"""The search on a linear stage: every cause, no cause, and a start with the wrong cause."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGED_UM,
    AGING,
    AXIS2_V,
    COMMAND_V,
    CREEP,
    LAG,
    LATE,
    LINEAR,
    NOISE_UM,
    PLANTED,
    RINGING,
    SAMPLES,
    SPAN_S,
    T_S,
    TS_S,
    named,
    respond,
    scene,
)
from hysgen.diagnosis import search
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.causes.modes import identified
from hysgen.diagnosis.causes.unknown import SuddenPart
from hysgen.diagnosis.probe import Chain, Mode, Scene, Trace, linear_fit, refine
from hysgen.diagnosis.score import Scored, admissible
from hysgen.diagnosis.search_steps import best_of_causes
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes
from hysgen.model.remaining import LEAST_EVIDENCE


@pytest.mark.parametrize("name", PLANTED)
@pytest.mark.slow
def test_search_finds_the_planted_cause_and_no_other(name: str) -> None:
    stage, more_um = PLANTED[name]
    found = search.search(scene(stage, more_um, {"axis2_V": AXIS2_V}))
    assert named(found) == [name]
    assert found.bayes[name] > LEAST_EVIDENCE
    assert found.confidence[name] > 0.99


def test_of_two_forms_of_a_cause_that_count_differently_the_better_and_smaller_one_is_taken() -> None:
    """Modes, along which a misfit repeats, and a structure with another drive, which differs from pass to pass."""
    seen = scene(RINGING, 0.05 * np.sin(COMMAND_V / 5.0), {"axis2_V": AXIS2_V})
    bare, modes = (Scored.of(seen, refine(seen, chain)) for chain in (LAG, RINGING))
    part = identified(seen.runs, ("axis2_V",), TS_S)
    assert part is not None
    fit = linear_fit(seen, LAG.having(part))
    worse, better = (
        Scored.of(seen, replace(fit, error=size * modes.fit.error, rms_um=size * modes.fit.rms_um))
        for size in (1.5, 0.5)
    )
    assert worse.fall_from(bare) > modes.fall_from(bare)
    for structure, taken in ((worse, modes), (better, better)):
        found = best_of_causes([("resonance", structure), ("resonance", modes)], bare)
        assert found == {"resonance": taken}


@pytest.mark.slow
def test_search_names_nothing_when_the_residual_is_noise() -> None:
    found = search.search(scene(LAG, 0.0, {"axis2_V": AXIS2_V}))
    assert named(found) == []
    assert max(found.confidence[name] for name in PLANTED) < 0.5


@pytest.mark.slow
def test_search_adds_a_cause_whose_effect_is_below_the_noise() -> None:
    found = search.search(scene(LAG, 2e-3 * T_S / SPAN_S))
    assert named(found) == ["drift"]


@pytest.mark.slow
def test_sudden_changes_are_located_and_no_slow_cause_is_named_for_them() -> None:
    """Three jumps upwards resemble a drift, a gain that grows once resembles aging."""
    stairs_um = 0.02 * sum((t_s <= T_S).astype(float) for t_s in (0.9, 2.0, 3.1))
    grown_um = 0.1 * 0.004 * respond(COMMAND_V, LAG, TS_S) * (T_S >= 2.2)
    for more_um, at_s in ((stairs_um, [0.9, 2.0, 3.1]), (grown_um, [2.2])):
        found = search.search(scene(LAG, more_um))
        assert named(found) == ["unknown"]
        times_s = found.fit.chain.of(SuddenPart).times_s
        np.testing.assert_allclose(sorted(times_s), at_s, atol=0.02)


@pytest.mark.slow
def test_a_gain_that_changes_before_a_slow_lag_changes_at_once() -> None:
    slow = Chain(0.02, memory=False)
    u_V = np.where(T_S >= 2.2, 1.05, 1.0) * COMMAND_V
    more_um = 0.1 * (respond(u_V, slow, TS_S) - respond(COMMAND_V, slow, TS_S))
    found = search.search(scene(slow, more_um))
    assert named(found) == ["unknown"]
    assert found.fit.chain.of(SuddenPart).gains[0][1] == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize(("beyond", "clips"), [(0.0, True), (0.3, False), (1.0, False)])
def test_a_level_is_evident_if_the_output_is_flat_beyond_it_whatever_the_misfit(beyond: float, clips: bool) -> None:
    """The misfit: 0.2 um of a sine of the voltage, which the curve of the operator cannot follow.

    beyond: slope beyond 80 V over that below.
    """
    v_V = np.where(COMMAND_V > 80.0, 80.0 + beyond * (COMMAND_V - 80.0), COMMAND_V)
    bent_um = respond(0.1 * v_V + 0.2 * np.sin(0.05 * np.pi * v_V), LAG, TS_S)
    seen = scene(LAG, bent_um - 0.1 * respond(COMMAND_V, LAG, TS_S))
    clipped = refine(seen, LAG.having(Saturation(high_V=80.0)))
    assert (causes()["saturation"].evidence(seen, clipped) > LEAST_EVIDENCE) == clips


@pytest.mark.parametrize("rests", [True, False])
def test_a_level_beyond_which_the_command_only_rests_is_no_evidence(rests: bool) -> None:
    """The curve bends above 80 V. One step leads there; at rest, any level below it fits as well."""
    u_V = np.minimum(COMMAND_V, 80.0)
    u_V[2000:2400] = 95.0 if rests else 87.5 + 7.5 * np.sin(0.05 * np.arange(400))
    y_um = 0.1 * respond(np.minimum(u_V, 82.0), LAG, TS_S) + NOISE_UM * np.random.default_rng(6).normal(size=SAMPLES)
    seen = Scene((Trace(u_V, y_um, {}),), TS_S, np.arange(50, SAMPLES), LINEAR)
    clipped = refine(seen, LAG.having(Saturation(high_V=82.0)))
    assert (causes()["saturation"].evidence(seen, clipped) > LEAST_EVIDENCE) == (not rests)


def test_of_two_modes_at_once_the_lower_one_comes_first() -> None:
    """The upper one is the stronger and is found first."""
    both = LAG.having(Modes.of((Mode(23.0, 0.03, 0.1), Mode(60.0, 0.03, 0.4)), 1.0))
    starts = causes()["resonance"].proposals(Residual(scene(both), refine(scene(both), LAG)))
    pair = next(start for start in starts if len(start.modes) == 2)
    np.testing.assert_allclose([mode.f_Hz for mode in pair.modes], [23.0, 60.0], rtol=0.1)


LIMITED, CLIPPED_AT_60 = LAG.having(Slew(800.0, 800.0)), LAG.having(Saturation(high_V=60.0))


@pytest.mark.parametrize(
    ("stage", "more_um", "wrong", "right"),
    [
        (LATE, 0.0, LAG.having(Modes.of((Mode(120.0, 0.3, 0.5),), 1.0)), "delay"),
        (LAG, AGED_UM, CREEP, "aging"),
        pytest.param(CLIPPED_AT_60, 0.0, LIMITED, "saturation", marks=pytest.mark.proof),
        pytest.param(LAG, 0.01 * T_S / SPAN_S, CREEP.having(DriftPart()), "drift", marks=pytest.mark.proof),
    ],
)
@pytest.mark.slow
def test_search_replaces_a_cause_that_was_taken_for_the_planted_one(
    monkeypatch: pytest.MonkeyPatch, stage: Chain, more_um: NDArray[np.float64] | float, wrong: Chain, right: str
) -> None:
    monkeypatch.setattr(search, "start", lambda seen: refine(seen, wrong))
    assert named(search.search(scene(stage, more_um))) == [right]


@pytest.mark.slow
def test_a_drift_is_named_beside_creep_and_creep_of_a_move_before_the_record_is_none() -> None:
    """The move: down by 10 um, 1 s before the record, of which 0.02 per decade goes on, 0.14 um in the record."""
    gone_um = -0.2 * np.log10(1.0 + T_S / 1.0)
    ramp_um, both = 0.02 * T_S / SPAN_S, ["creep", "drift"]
    for more_um, causes_named in ((gone_um, ["creep"]), (gone_um + ramp_um, both)):
        found = search.search(scene(CREEP, more_um))
        assert named(found) == causes_named


@pytest.mark.parametrize(
    "chain",
    [
        LAG.having(Slew(4.5e4, 4.5e4)),  # faster than the command, but for its few steps
        LAG.having(Saturation(high_V=99.5)),  # within 1 % of the end of the range
        LAG.having(Modes.of((Mode(60.0, 5e-4, 0.4),), 1.0)),  # at the bound of the damping ratio
        LAG.having(CreepPart(0.0, 0.05)),
        LAG.having(CreepPart(0.02, 0.1 * SPAN_S)),  # creep for less than a decade of the record
        LAG.having(Delay(0.05)),
        LAG.having(AgingPart(-0.6 / SPAN_S)),  # a gain that halves within a record does not age
        CREEP.having(DriftPart(1.0)),  # creep of a move before the record has the course of a drift that slows down
    ],
)
def test_a_chain_outside_the_physical_bounds_of_a_cause_is_not_admissible(chain: Chain) -> None:
    seen = scene(LAG)
    assert not admissible(seen, linear_fit(seen, chain))
    assert admissible(seen, linear_fit(seen, CREEP.having(Delay(1.0))))


@pytest.mark.parametrize(("zero_um", "holds"), [(2.0, False), (4.0, True)])
def test_a_ramp_within_the_uncertainty_of_the_zero_of_aging_is_no_drift(zero_um: float, holds: bool) -> None:
    """y (1 + a t) - zero a t: a gain that changes about `zero`, with a span of 10 um."""
    seen = scene(LAG, 0.02 * T_S * (0.1 * respond(COMMAND_V, LAG, TS_S) - zero_um))
    assert admissible(seen, refine(seen, AGING.having(DriftPart()))) == holds


CURVED_UM = 0.2 * respond(np.sin(0.4 * np.pi * COMMAND_V), LAG, TS_S)
"""Displacement in um that the curve of the linear operator cannot follow: the misfit, four times the drift below."""


@pytest.mark.slow
def test_the_search_names_a_drift_below_the_misfit() -> None:
    found = search.search(scene(LAG, CURVED_UM + 0.05 * T_S / SPAN_S))
    assert named(found) == ["drift"]
    assert found.confidence["drift"] > 0.99
    assert named(search.search(scene(LAG, CURVED_UM))) == []
