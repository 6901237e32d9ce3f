"""Each cause's own evidence: it holds where the cause is, and not where something else only looks like it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGED_UM,
    AGING,
    AXIS2_V,
    CLIPPED,
    COMMAND_V,
    COUPLED,
    CREEP,
    DRIFTING,
    HUMMING,
    LAG,
    LATE,
    LINEAR,
    NOISE_UM,
    RINGING,
    SAMPLES,
    SLOW_AMPLIFIER,
    SPAN_S,
    T_S,
    TS_S,
    evidence,
    lines_Hz,
    scene,
)
from hysgen.diagnosis.causes import Residual, causes, slew
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.creep import CreepPart, crept_step
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.causes.periodic import PeriodicPart
from hysgen.diagnosis.causes.resonance import ResonancePart, mode_evidence
from hysgen.diagnosis.causes.slew import SlewPart
from hysgen.diagnosis.comparison import levels, ratio_above_noise
from hysgen.diagnosis.probe import Chain, Fit, Mode, Operator, Scene, StandardErrors, Trace, linear_fit, refine
from hysgen.diagnosis.probe.dynamics import respond
from hysgen.diagnosis.search import drop_unsupported_parts, eliminate_backward, present, search

Floats = NDArray[np.float64]

PRESENT: dict[str, tuple[Chain, Floats | float]] = {
    "creep": (CREEP, 0.0),
    "resonance": (RINGING, 0.0),
    "delay": (LATE, 0.0),
    "saturation": (CLIPPED, 0.0),
    "slew": (SLOW_AMPLIFIER, 0.0),
    "drift": (DRIFTING, 0.05 * T_S / SPAN_S),
    "aging": (AGING, AGED_UM),
    "periodic": (HUMMING, 0.01 * np.sin(2 * math.pi * 50.3 * T_S)),
    "coupling": (COUPLED, 0.001 * respond(AXIS2_V, LAG, TS_S)),
}


@pytest.mark.parametrize("name", PRESENT)
def test_evidence_holds_for_a_planted_cause(name: str) -> None:
    chain, more_um = PRESENT[name]
    assert evidence(name, scene(chain, more_um, {"axis2_V": AXIS2_V}), chain).holds


@pytest.mark.parametrize("name", PRESENT)
def test_evidence_does_not_hold_for_a_stage_with_a_lag_alone(name: str) -> None:
    chain, _ = PRESENT[name]
    if name == "slew":
        chain = chain.having(SlewPart(3e5))  # faster than the command, but for its few steps
    result = evidence(name, scene(LAG, 0.0, {"axis2_V": AXIS2_V}), chain)
    assert not result.holds, result.text


def test_negative_creep_is_no_evidence_of_creep() -> None:
    back = CREEP.having(CreepPart(-0.02, 0.05))
    assert evidence("creep", scene(back), back).z < -4.0
    assert not evidence("creep", scene(back), back).holds


@pytest.mark.parametrize(
    ("rate_V_per_s", "error", "holds"), [(800.0, 0.05, True), (800.0, 0.2, False), (4.5e4, 0.01, False)]
)
def test_slew_requires_a_known_rate_and_at_least_ten_delayed_samples(
    monkeypatch: pytest.MonkeyPatch, rate_V_per_s: float, error: float, holds: bool
) -> None:
    limited = LAG.having(SlewPart(rate_V_per_s))
    seen = scene(limited)
    residual = Residual(seen, linear_fit(seen, limited))
    errors = StandardErrors({"slew.rate_V_per_s": error}, np.zeros(1))  # of the logarithm
    monkeypatch.setattr(slew, "standard_errors", lambda at, fit: errors)
    assert causes()["slew"].signature(residual, residual.fit).holds == holds


def test_creep_of_a_move_before_the_record_does_not_change_the_estimate() -> None:
    """Creep of an unknown move by half the range before the first sample."""
    before_um = -0.02 * 5.0 * crept_step(T_S, SAMPLES * TS_S, 0.05)
    result = evidence("creep", scene(CREEP, before_um), CREEP).parameters["per_decade"]
    assert result.value == pytest.approx(0.02, rel=0.02)


def test_creep_that_starts_near_the_end_of_the_record_is_no_evidence() -> None:
    late = CREEP.having(CreepPart(0.3, 0.15 * SPAN_S))
    result = evidence("creep", scene(late), late)
    assert result.z > 4.0
    assert not result.holds


def test_a_smaller_slope_beyond_a_level_is_no_saturation() -> None:
    bent_V = np.minimum(COMMAND_V, 80.0) + 0.6 * np.maximum(COMMAND_V - 80.0, 0.0)
    bent = Scene((Trace(COMMAND_V, 0.1 * respond(bent_V, LAG, TS_S), {}),), TS_S, np.arange(50, SAMPLES), LINEAR)
    # Fitted to the rows with the command below the level, so that the fitted gain is that of the stage.
    found = linear_fit(bent.using(bent.rows[np.convolve(COMMAND_V > 80.0, np.ones(40))[bent.rows] == 0]), CLIPPED)
    result = causes()["saturation"].signature(Residual(bent, found), found)
    assert not result.holds, result.text


def test_drift_on_rising_input_alone_is_no_drift() -> None:
    rising = np.gradient(COMMAND_V) > 0
    result = evidence("drift", scene(LAG, np.where(rising, 0.004, 0.0012) * T_S / SPAN_S), DRIFTING)
    assert result.z > 5.0
    assert not result.holds


def test_a_slow_wave_is_no_drift() -> None:
    result = evidence("drift", scene(LAG, 0.05 * np.sin(1.8 * math.pi * T_S / SPAN_S + 2.0)), DRIFTING)
    assert not result.holds, result.text


@pytest.mark.parametrize(("zero_um", "holds"), [(2.0, False), (4.0, True)])
def test_a_ramp_within_the_uncertainty_of_the_zero_of_aging_is_no_drift(zero_um: float, holds: bool) -> None:
    """y (1 + a t) - zero a t: a gain that changes about `zero`, with a span of 10 um."""
    aged_um = 0.02 * T_S * (0.1 * respond(COMMAND_V, LAG, TS_S) - zero_um)
    result = evidence("drift", scene(LAG, aged_um), AGING.having(DriftPart()))
    assert result.holds == holds, result.text


def test_a_line_with_a_changing_phase_is_not_periodic() -> None:
    turned = np.where(T_S < 0.2 * SPAN_S, -1.0, 1.0) * 0.01 * np.sin(2 * math.pi * 50.3 * T_S)
    fit = linear_fit(scene(LAG, turned), HUMMING)
    result = causes()["periodic"].signature(Residual(scene(LAG, turned), fit), fit)
    assert result.z**2 > 30.0
    assert not result.holds


def test_a_line_near_its_background_is_not_periodic() -> None:
    weak = scene(LAG, 0.95e-4 * np.sin(2 * math.pi * 50.3 * T_S))
    result = evidence("periodic", weak, HUMMING)
    assert "phase kept throughout" in result.text
    assert not result.holds, result.text


@pytest.mark.parametrize(("count", "size_um", "holds"), [(6, 0.5, True), (2, 0.5, False), (6, 0.011, False)])
def test_outliers_are_several_and_have_most_of_the_error_power(count: int, size_um: float, holds: bool) -> None:
    spikes = np.zeros(SAMPLES)
    spikes[np.linspace(300, 3700, count).astype(int)] = size_um
    found = search(scene(LAG, spikes))
    result = causes()["outliers"].signature(Residual(found.scene, found.fit, found.corrupted), found.fit)
    assert result.holds == holds


@pytest.mark.parametrize("play_V", [0.0, 10.0])
def test_memory_holds_for_a_play_and_not_for_a_curve(play_V: float) -> None:
    path_V = COMMAND_V.copy()
    for k in range(1, SAMPLES):
        path_V[k] = min(max(path_V[k - 1], COMMAND_V[k] - play_V), COMMAND_V[k] + play_V)
    y_um = 0.1 * respond(path_V, LAG, TS_S) + NOISE_UM * np.random.default_rng(8).normal(size=SAMPLES)
    rows = np.arange(400, SAMPLES)
    seen = Scene((Trace(COMMAND_V, y_um, {}),), TS_S, rows[rows // 300 % 2 == 0], Operator(0.0, 100.0))
    found, rival = linear_fit(seen, Chain(4e-3)), linear_fit(seen, LAG)
    result = causes()["memory"].signature(Residual(seen.using(rows[rows // 300 % 2 == 1]), found), rival)
    assert result.holds == (play_V > 0.0), result.text


def test_backward_elimination_removes_unneeded_and_keeps_needed_causes() -> None:
    """The stage has a delay and a ramp of 1 nm rms; the chain also has a mode and aging."""
    seen = scene(LATE, 4e-3 * T_S / SPAN_S)
    more = LATE.having(DriftPart()).having(ResonancePart((Mode(90.0, 0.1, 1e-4),))).having(AgingPart(1e-6))
    pruned = eliminate_backward(seen, refine(seen, more), np.arange(60, SAMPLES, 3)).chain
    assert present(pruned) == ["delay", "drift"]


@pytest.mark.parametrize(
    ("mode", "worse", "holds"),
    [
        (Mode(60.0, 0.03, 0.4), {}, True),
        (Mode(60.0, 0.03, 0.4), {"resonance.0.share": 0.09}, False),
        (Mode(60.0, 0.03, 0.4), {"resonance.0.f_Hz": 0.06}, False),
        (Mode(60.0, 0.03, 0.4), {"resonance.0.zeta": 0.6}, False),
        (Mode(60.0, 9e-4, 0.4), {}, False),
        (Mode(460.0, 0.03, 0.4), {}, False),
    ],
)
def test_a_mode_requires_known_share_frequency_and_damping(mode: Mode, worse: dict[str, float], holds: bool) -> None:
    chain = LAG.having(ResonancePart((mode,)))
    residual = Residual(scene(RINGING), linear_fit(scene(RINGING), chain))
    errors = {"resonance.0.share": 0.07, "resonance.0.f_Hz": 0.04, "resonance.0.zeta": 0.4}
    result = mode_evidence(residual, errors | worse)
    assert [supported for _, supported, _ in result] == [holds]
    assert causes()["resonance"].admissible(residual.scene, chain) == (mode.zeta > 1e-3)


def test_a_mode_without_evidence_is_dropped_and_the_other_kept() -> None:
    seen = scene(RINGING)
    both = linear_fit(seen, RINGING.having(ResonancePart((*RINGING.modes, Mode(3.0, 5e-4, 1e-4)))))
    supported = drop_unsupported_parts(seen, both, seen.rows).chain
    assert [round(mode.f_Hz) for mode in supported.modes] == [60]


def test_an_effect_below_the_noise_changes_the_ratio_above_the_noise() -> None:
    """0.5 nm rms under 1 nm of noise raises the rms by 12 % only."""
    noise_um = NOISE_UM * np.random.default_rng(9).normal(size=SAMPLES)
    effect_um = 0.5e-3 * math.sqrt(2.0) * np.sin(2 * math.pi * T_S / SPAN_S)
    with_it, without = (Fit(LAG, np.zeros(1), error, 0.0) for error in (noise_um, noise_um + effect_um))
    rows = np.arange(SAMPLES)
    assert ratio_above_noise(with_it, without, rows) < 0.6
    assert ratio_above_noise(without, with_it, rows) > 1.0
    assert ratio_above_noise(with_it, with_it, rows) == 1.0


def test_an_effect_of_a_tenth_of_the_noise_does_not_change_the_ratio() -> None:
    noise_um = NOISE_UM * np.random.default_rng(9).normal(size=SAMPLES)
    effect_um = 0.1e-3 * math.sqrt(2.0) * np.sin(2 * math.pi * T_S / SPAN_S)
    with_it, without = (Fit(LAG, np.zeros(1), error, 0.0) for error in (noise_um, noise_um + effect_um))
    rows = np.arange(SAMPLES)
    assert ratio_above_noise(with_it, without, rows) == ratio_above_noise(without, with_it, rows) == 1.0


def test_the_block_with_the_largest_error_of_the_richer_chain_is_omitted() -> None:
    richer, poorer = np.ones(800), np.full(800, 2.0)
    richer[300:400] = 50.0
    assert levels(richer, poorer) == (1.0, 2.0)


def test_a_block_that_the_richer_chain_fits_far_better_is_not_omitted() -> None:
    richer, poorer = np.ones(800), np.ones(800)
    richer[300:400], poorer[300:400] = 10.0, 200.0
    left, right = levels(richer, poorer)
    assert left < 0.1 * right
    assert levels(np.ones(800), np.full(800, 5.0)) == (1.0, 5.0)


@pytest.mark.parametrize(("periods", "proposed"), [(8.3, False), (20.3, True)])
def test_a_proposed_line_has_at_least_three_periods_in_each_quarter(periods: float, proposed: bool) -> None:
    seen = scene(LAG, 0.01 * np.sin(2.0 * np.pi * periods * T_S / SPAN_S))
    chains = causes()["periodic"].proposals(Residual(seen, refine(seen, LAG)))
    assert any(abs(line_Hz * SPAN_S - periods) < 1.0 for chain in chains for line_Hz in lines_Hz(chain)) == proposed


def test_a_line_near_its_background_is_dropped_beside_a_strong_line() -> None:
    seen = scene(HUMMING, 0.01 * np.sin(2.0 * np.pi * 50.3 * T_S))
    both = refine(seen, LAG.having(PeriodicPart((50.3, 97.1))))
    assert [round(line_Hz, 1) for line_Hz in lines_Hz(causes()["periodic"].supported(Residual(seen, both)))] == [50.3]
    alone = refine(seen, LAG.having(PeriodicPart((97.1,))))
    assert causes()["periodic"].supported(Residual(seen, alone)) == alone.chain
