"""Slow causes result apart, what pays, and how far a command leads: the decisions of the diagnosis, each seen alone."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.bank_records import built, measured, prepared_of, record_of
from fixtures.linear_stage import respond
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import AgingPart, GainChange
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart, Trend
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import blockwise_confidence, combined_confidence, fit_ladder, gain
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, Operator, Scene, Trace, linear_fit, refine
from hysgen.diagnosis.procedure import name_causes
from hysgen.diagnosis.search import search
from hysgen.errors import RecordError
from hysgen.fitting import FitSettings
from hysgen.machine.kernels.operators import lag_states
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.studies.bank.scenario import good, scenario

Floats = NDArray[np.float64]
TS_S = 1e-3
SAMPLES = 4000
SPAN_S = TS_S * SAMPLES


def drifting(course_um: Floats, seed: int = 5) -> Scene:
    """A linear stage with a lag of 4 ms and 1 nm of noise that drifts along course_um, (SAMPLES,)."""
    rng = np.random.default_rng(seed)
    u_V = good(rng, SAMPLES, 0.0, 100.0)
    y_um = 0.1 * respond(u_V, Chain(4e-3), TS_S) + course_um + 1e-3 * rng.normal(size=SAMPLES)
    operator = Operator(0.0, 100.0, hats=0, curve=1, reaches=())
    return Scene((Trace(u_V, y_um, {}),), TS_S, np.arange(50, SAMPLES), operator)


@pytest.mark.slow
def test_drift_that_slows_down_is_found_with_its_parameters() -> None:
    t_s = TS_S * np.arange(SAMPLES)
    scene = drifting(0.1 * np.log10(1.0 + t_s / 0.2))
    found = search(scene)
    cause = causes()["drift"]
    assert cause.present(found.fit.chain)
    signature = cause.signature(Residual(scene, found.fit), found.rivals["drift"])
    # Size and beginning are correlated: over 1.3 decades 1 nm of noise leaves some per cent of either.
    assert signature.parameters["um_per_decade"].value == pytest.approx(0.1, rel=0.1)
    assert signature.parameters["since_s"].value == pytest.approx(0.2, rel=0.3)
    drift = cause.extension(Residual(scene, found.fit)).correction
    assert isinstance(drift, Trend)
    course = drift.at(2.0 * t_s)  # twice as long as what was looked at
    assert np.abs(course - 0.1 * np.log10(1.0 + 2.0 * t_s / 0.2)).max() < 0.01


def test_drift_and_aging_are_fitted_jointly() -> None:
    """Each takes what the other leaves: the aging of one fit beside the ramp of another adds up to neither."""
    hidden = built(drift=(0.05, 0.0), aging=(-0.03, 6.0))
    prepared = prepare(measured(hidden))
    scene = prepared.scene()
    fit = refine(scene, Chain(5e-3, (DriftPart(), AgingPart(-0.03 / 6.0))))
    drift = causes()["drift"].extension(Residual(scene, fit)).correction
    aging = causes()["aging"].extension(Residual(scene, fit)).correction
    assert isinstance(drift, Trend)
    assert isinstance(aging, GainChange)
    middle_um = float(prepared.y_um.mean())
    found_um = float(drift.at(6.0)) + aging.per_s * 6.0 * (middle_um - aging.zero_um)
    # Of a sum of 0.3 um and -0.03 of the middle; 0.1 % of the stroke is what the probe's hysteresis leaves.
    assert found_um == pytest.approx(0.3 - 0.03 * middle_um, abs=0.01)


@pytest.mark.slow
def test_drift_at_one_rate_stays_a_ramp() -> None:
    scene = drifting(0.1 * np.arange(SAMPLES) / SAMPLES)
    assert search(scene).fit.chain.parts == (DriftPart(),)


@pytest.mark.slow
def test_a_drift_that_comes_and_goes_is_no_line() -> None:
    """Warmth that fades in from a third of the record on, and out from two thirds on."""
    t_s = TS_S * np.arange(SAMPLES)
    warm = [1.0 - np.exp(-np.maximum(t_s - share * SPAN_S, 0.0) / 0.4) for share in (1.0 / 3.0, 2.0 / 3.0)]
    scene = drifting(0.05 * (warm[0] - 1.4 * warm[1]))
    found = search(scene)
    residual, cause = Residual(scene, found.fit), causes()["drift"]
    assert "no line describes it" in cause.signature(residual, found.rivals["drift"]).text
    drift = cause.extension(residual).correction
    assert isinstance(drift, Trend)
    moved = drift.at(t_s) - 0.05 * (warm[0] - 1.4 * warm[1])
    # The best of all courses of eight straight pieces is 2.78 nm off, where they round the corners.
    assert np.std(moved[50:]) < 0.003
    assert drift.at(2.0 * t_s[-1:]) == pytest.approx(drift.level_um)


STOOD_V = 15.0


def started(first_V: float) -> Record:
    """Bouc-Wen's hysteresis with slow states behind it that stood at STOOD_V until the record starts at first_V."""
    Ts_s, rng = 2e-4, np.random.default_rng(7)
    u_V = good(rng, 6000, 0.0, 100.0)
    u_V[:200] = first_V
    before_V = np.concatenate([np.full(3000, STOOD_V), u_V])
    z, w_um = 0.0, np.empty(len(before_V))
    for k, step_V in enumerate(np.diff(before_V, prepend=before_V[0])):
        pieces = int(abs(step_V) / 0.5) + 1
        for _ in range(pieces):
            z += step_V / pieces * (1.0 - np.abs(z / 18.0) ** 1.5 * np.sign(z * step_V))
        w_um[k] = 0.055 * before_V[k] + 0.02 * z
    slow = -np.expm1(-Ts_s / (4e-3 * 4.0 ** np.arange(7)))
    states = lag_states(w_um, slow, np.full(7, w_um[0]))
    x_um = w_um + 0.004 * states.sum(axis=1)
    y_um = lag_states(x_um, np.array([0.2]), x_um[:1])[3000:, 0] + 2e-3 * rng.standard_normal(6000)
    return Record.from_arrays(u_V, y_um, Ts_s)


@pytest.mark.slow
@pytest.mark.parametrize(("first_V", "stood_V"), [(80.0, pytest.approx(STOOD_V, abs=5.0)), (STOOD_V, None)])
def test_a_record_that_starts_with_a_jump_has_the_creep_of_the_level_of_its_first_reading(
    first_V: float, stood_V: float | None
) -> None:
    """Two free parameters of an unknown past make creep less likely than a drift, and are not needed here."""
    named = name_causes(started(first_V))
    assert named.names == ("memory", "creep")
    part = named.found.fit.chain.of(CreepPart)
    assert (part.first_V, part.past_V) == (stood_V, None)


@pytest.mark.slow
def test_aging_of_a_stage_with_hysteresis_is_named() -> None:
    naming = name_causes(record_of("aging", 0))
    assert naming.names == ("memory", "aging")
    assert naming.confidence["aging"] > 0.99
    refuted = {name: dataclasses.replace(one, z=0.2) for name, one in naming.signatures.items()}
    unsure = dataclasses.replace(naming, signatures=refuted).confidence
    assert unsure == {"memory": naming.confidence["memory"], "aging": pytest.approx(0.505, abs=0.001)}


def test_aging_has_starting_values_of_both_signs() -> None:
    """The fit with the wrong sign is a local minimum, because the hysteresis has absorbed part of the aging."""
    hidden = scenario("aging", 5)
    scene = prepared_of("aging", 5).scene()
    part = scene.using(scene.rows[np.arange(len(scene.rows)) * 24 // len(scene.rows) % 3 != 1])
    aging = causes()["aging"]
    proposals = aging.proposals(Residual(part, refine(part, Chain(hidden.stage.lag_s))))
    assert {np.sign(chain.of(AgingPart).per_s) for chain in proposals[1:]} == {-1.0, 1.0}
    trials = sorted((linear_fit(part, chain) for chain in proposals), key=lambda fit: fit.rms_um)
    rates = [refine(part, trial.chain).chain.of(AgingPart).per_s for trial in aging.select_starts(trials)]
    assert sorted(np.sign(rates)) == [-1.0, 1.0]


@pytest.mark.parametrize(("lag_s", "lag"), [(1e-5, 0.3), (0.012, 12.0), (0.05, 50.0)])
def test_training_rows_begin_after_the_burn_in_and_end_before_the_last_readings(lag_s: float, lag: float) -> None:
    u_V = 50.0 - 50.0 * np.cos(2.0 * np.pi * np.arange(6000) / 1000.0)
    prepared = prepare(Record.from_arrays(u_V, 0.1 * respond(u_V, Chain(lag_s), TS_S), TS_S), identify=0.5)
    # A cosine covers 0.98 of its range after 455 samples; the burn-in of the lag adds at most 0.03 * 6000 samples.
    for rows, lags in ((prepared.training_rows, 3.0), (prepared.scene().rows, 8.0)):
        assert 0.8 * min(lags * lag, 180.0) <= rows[0] - 455 <= min(1.3 * lags * lag + 1.0, 180.0)
        assert rows[-1] == 3000 - 3
    assert prepared.held_rows[[0, -1]].tolist() == [3000, 5999]


def test_a_cut_before_the_input_has_run_through_its_range_is_refused() -> None:
    u_V = np.linspace(0.0, 16.0, 6000) % 4.0
    with pytest.raises(RecordError, match="of the 500 samples to identify from come after the input has run through"):
        prepare(Record.from_arrays(u_V, 0.1 * u_V, TS_S), identify=500 / 6000)


def test_one_block_with_a_large_error_does_not_determine_the_confidence() -> None:
    rng = np.random.default_rng(1)
    before, after = rng.normal(size=2400), 0.5 * rng.normal(size=2400)
    after[600:700] *= 40.0  # a stroke wider than all fitted strokes
    assert gain(before, after).fall_um < 0.0
    assert blockwise_confidence(before, after) > 0.99
    assert blockwise_confidence(after, before) < 0.01
    assert blockwise_confidence(before, before) == 0.0
    assert blockwise_confidence(before, 0.99 * before) == 1.0
    assert blockwise_confidence(before, 0.99 * before, 0.02) == 0.0


def test_one_block_with_a_negligible_error_does_not_determine_the_confidence() -> None:
    rng = np.random.default_rng(2)
    before = rng.normal(size=2400)
    before[1200:1600] *= 0.01  # nothing moves here
    after = 0.8 * before
    after[1200:1600] *= 2.6
    assert 0.7 < blockwise_confidence(before, after, 0.02) < 0.95
    assert combined_confidence(before, after, 0.02) > 0.95
    after[1200:1600] *= 8.0  # now the mean over blocks is sure of the opposite
    assert combined_confidence(before, after, 0.02) < 0.7
    assert gain(before, after, 0.02).confidence > 0.95
    assert gain(before, after, 0.3).confidence == 0.0


def test_the_grid_covers_a_plateau_that_the_identification_part_only_reaches() -> None:
    u_V = np.concatenate([50.0 + 30.0 * np.sin(np.arange(4000) / 150.0), np.full(1500, 100.0), np.full(500, 0.0)])
    u_V[700:706] = 100.0  # a pulse too short for the lag
    u_V[900:906] = 0.0
    y_um = 0.1 * respond(u_V, Chain(0.04), TS_S)
    prepared = prepare(Record.from_arrays(u_V, y_um, TS_S), identify=4000 / 6000)
    seen = prepared.identification().y_range_um
    low_um, high_um = prepared.predicted_range_um
    assert seen[1] < 9.0 < high_um
    assert high_um == pytest.approx(10.0, rel=0.03)
    assert low_um < seen[0]


def test_refinement_keeps_the_start_of_a_drift_within_its_bounds() -> None:
    scene = drifting(0.1 * np.arange(SAMPLES) / SAMPLES)
    fit = refine(scene, Chain(4e-3, (DriftPart(0.1),), memory=False))
    (drift,) = fit.chain.parts
    assert isinstance(drift, DriftPart)
    assert 0.0 < (drift.since_s or 0.0) <= SPAN_S


def test_a_model_beside_a_drift_has_the_level_of_the_end_of_the_identified_rows() -> None:
    (run,) = drifting(0.1 * np.arange(SAMPLES) / SAMPLES).runs
    record = Record.from_arrays(run.u_V, run.y_um, TS_S)
    prepared = prepare(record)
    extensions = {"drift": Extension(correction=Trend(0.1 / SPAN_S, None, prepared.cut * TS_S))}
    model = fit_ladder(prepared, extensions, ["drift"], FitSettings()).model
    late_um = (free_run(model, record)[0].y_um - run.y_um)[prepared.cut - 200 : prepared.cut]
    assert abs(late_um.mean()) < 0.005  # of 0.065 um of drift until there
