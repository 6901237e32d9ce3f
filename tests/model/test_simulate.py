"""Simulation: the compiled kernels against plain loops over the equations, segments, clamps, terms, horizons."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fixtures.random_models import TS_S, lag_record, random_drive, random_model
from hysgen.errors import RecordError
from hysgen.model.disturbances import Drive
from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.model import Grid, Model
from hysgen.model.path.limits import Saturation
from hysgen.model.regression import memberships, regression_rows, structure_of
from hysgen.model.simulate import default_horizons, free_run, horizon_curve, one_step, simulate
from hysgen.record import Record, Segment

DISTURBED = (Periodic((50.0,)),)

# Kernel and loop sum the same products in another order, over at most 60 steps from measured values, so they differ
# by some last bits of the largest consequent value; in the free run errors fade because the models contract.
CLOSE = 1e-9


def by_the_equations(model: Model, y: float, u: float, w: float) -> float:
    """Eq. (4) and the terms, for one sample."""
    p = memberships(np.array([y]), model.grid)[0]
    clamped = float(model.grid.clamp(np.array(y)))
    q1, q2, q3 = model.consequents.T
    return float(np.sum(p * (q1 * clamped + q2 * u + q3)) + w)


def disturbance_by_the_definition(model: Model, samples: int) -> Any:
    """theta_1 cos(2 pi f Ts k) + theta_2 sin(2 pi f Ts k) of the model's periodic term."""
    if not model.terms:
        return np.zeros(samples)
    angle = 2 * np.pi * 50.0 * TS_S * np.arange(samples)
    return model.weights @ [np.cos(angle), np.sin(angle)]


def made_by(model: Model, samples: int, seed: int, noise_um: float = 0.0) -> Record:
    """A record that the model itself answers to a random drive, by the loop."""
    u = random_drive(samples, seed)
    w = disturbance_by_the_definition(model, u.size)
    y = np.empty(samples)
    y[0] = model.grid.centres_um[0]
    for k in range(samples - 1):
        y[k + 1] = by_the_equations(model, y[k], u[k], w[k])
    y = y + noise_um * np.random.default_rng(seed).normal(size=samples)
    return Record.from_segments([Segment("0", u, y)], TS_S)


@given(st.integers(0, 10_000), st.integers(2, 40), st.booleans())
@settings(max_examples=25)
def test_free_run_kernel_is_the_loop_over_the_equations(seed: int, rules: int, disturbed: bool) -> None:
    model = random_model(seed, rules, wild=0.05, terms=DISTURBED if disturbed else ())
    record = made_by(model, 300, seed)
    run = free_run(model, record)[0]
    scale = model.grid.y_max_um - model.grid.y_min_um
    np.testing.assert_allclose(run.y_um, record.segments[0].y_um, atol=CLOSE * max(scale, 100.0), rtol=0)


@given(st.integers(0, 10_000), st.integers(2, 40), st.booleans())
@settings(max_examples=25)
def test_one_step_kernel_is_the_loop_over_the_equations(seed: int, rules: int, disturbed: bool) -> None:
    model = random_model(seed, rules, terms=DISTURBED if disturbed else ())
    u = random_drive(200, seed)
    rng = np.random.default_rng(seed)
    span = model.grid.y_max_um - model.grid.y_min_um
    y = rng.uniform(model.grid.y_min_um - 0.2 * span, model.grid.y_max_um + 0.2 * span, 200)
    record = Record.from_segments([Segment("0", u, y)], TS_S)
    w = disturbance_by_the_definition(model, u.size)
    expected = [y[0], *(by_the_equations(model, y[k], u[k], w[k]) for k in range(199))]
    run = one_step(model, record)[0]
    np.testing.assert_allclose(run.y_um, expected, atol=CLOSE * max(span, 100.0), rtol=0)
    assert run.y_clamped == np.count_nonzero((y[:-1] < model.grid.y_min_um) | (y[:-1] > model.grid.y_max_um))


def test_regression_rows_times_parameters_are_the_one_step_predictions() -> None:
    model = random_model(3, terms=DISTURBED)
    record = lag_record(samples=400, segments=2)
    rows = np.vstack([part.regressors for part in regression_rows(record, structure_of(model), chunk=100)])
    predicted = np.concatenate([run.y_um[1:] for run in one_step(model, record)])
    # Two orders of summation of products of up to 100 um.
    np.testing.assert_allclose(rows @ model.parameters, predicted, atol=1e-11 * np.abs(predicted).max(), rtol=0)


def test_segments_are_run_apart_each_from_its_own_first_sample() -> None:
    model = random_model(5, wild=0.05, terms=DISTURBED)
    both = lag_record(samples=300, segments=2)
    runs = free_run(model, both)
    for segment, run in zip(both.segments, runs, strict=True):
        alone = free_run(model, Record.from_segments([segment], TS_S))[0]
        np.testing.assert_array_equal(run.y_um, alone.y_um)
        assert run.y_um[0] == segment.y_um[0]


def test_inputs_outside_the_range_are_clamped_and_counted_and_blocks_come_after() -> None:
    model = dataclasses.replace(random_model(5, wild=0.05), u_min_V=20.0, u_max_V=80.0)
    u = random_drive(500, 1)
    record = Record.from_segments([Segment("0", u, np.full(500, model.grid.centres_um[2]))], TS_S)
    clipped = Record.from_segments([Segment("0", np.clip(u, 20, 80), record.segments[0].y_um)], TS_S)
    for runs in (free_run, one_step):
        run = runs(model, record)[0]
        np.testing.assert_array_equal(run.y_um, runs(model, clipped)[0].y_um)
        assert run.u_clamped == np.count_nonzero((u < 20) | (u > 80))
    saturated = dataclasses.replace(model, blocks=(Saturation(30.0, 60.0),))
    tighter = Record.from_segments([Segment("0", np.clip(u, 30, 60), record.segments[0].y_um)], TS_S)
    run = free_run(saturated, record)[0]
    np.testing.assert_array_equal(run.y_um, free_run(model, tighter)[0].y_um)
    assert run.u_clamped == np.count_nonzero((u < 20) | (u > 80))
    same = simulate(saturated, Drive(u, TS_S), float(record.segments[0].y_um[0]))
    np.testing.assert_array_equal(same.y_um, run.y_um)
    assert same.u_clamped == run.u_clamped


def test_what_was_clamped_before_the_first_row_is_not_counted() -> None:
    model = random_model(5, wild=0.05)
    y = np.full(500, model.grid.centres_um[2])
    y[100:120], y[300:303] = model.grid.y_max_um + 1.0, model.grid.y_min_um - 1.0
    record = Record.from_segments([Segment("0", random_drive(500, 1), y)], TS_S)
    assert [one_step(model, part)[0].y_clamped for part in (record, *record.split(0.5))] == [23, 20, 3]
    scored = dataclasses.replace(model, scores={"a": {}}, certificates={"b": {}})
    assert scored.behind_path.scores == scored.behind_path.certificates == {}, "they are those of the whole model"


def test_horizon_curve_is_the_error_of_short_free_runs() -> None:
    model = random_model(7, wild=0.05, terms=DISTURBED)
    record = lag_record(samples=120)
    y, u = record.segments[0].y_um, record.segments[0].u_V
    w = disturbance_by_the_definition(model, u.size)
    curve = horizon_curve(model, record, [1, 3, 20])
    for place, horizon in enumerate((1, 3, 20)):
        longest = 20 if horizon == 20 else 3
        errors = []
        for start in range(120 - longest):
            state = y[start]
            for k in range(start, start + horizon):
                state = by_the_equations(model, state, u[k], w[k])
            errors.append(state - y[start + horizon])
        assert curve.starts[place] == len(errors)
        assert abs(curve.rms_um[place] - np.sqrt(np.mean(np.square(errors)))) < CLOSE * 100
        assert abs(curve.largest_um[place] - np.abs(errors).max()) < CLOSE * 100


@pytest.mark.slow
def test_long_records_are_sampled_for_the_horizon_within_its_budget() -> None:
    model = random_model(7, wild=0.05)
    u = random_drive(40_000, 0)
    record = Record.from_segments([Segment("0", u, np.full(u.size, model.grid.centres_um[1]))], TS_S)
    curve = horizon_curve(model, record)
    assert curve.steps == tuple(default_horizons(40_000))
    assert curve.steps[-1] == 10_000
    # 2e6 steps for the decade that ends at 10 000 leave 200 starts; those of decade 1..5 all fit.
    assert 100 <= curve.starts[-1] <= 200
    assert curve.starts[0] == 40_000 - 5


def test_a_drift_term_follows_measured_samples_one_step_ahead_and_is_held_in_a_free_run() -> None:
    # One rule for all y: an offset of the record is then the same one-step error everywhere.
    base = dataclasses.replace(
        random_model(9), grid=Grid(-5.0, 15.0, 6), consequents=np.tile([0.95, 0.004, 0.0], (6, 1)), name="lag"
    )
    model = dataclasses.replace(base, terms=(Drift(200 * TS_S, 1.0),), weights=np.ones(1))
    made = made_by(base, 3000, 4)
    moved = Record.from_segments([Segment("0", made.segments[0].u_V, made.segments[0].y_um + 0.5)], TS_S)
    plain, followed = (one_step(m, moved)[0].y_um - moved.segments[0].y_um for m in (base, model))
    assert np.abs(followed[-500:]).mean() < 0.1 * np.abs(plain[-500:]).mean()
    np.testing.assert_array_equal(free_run(model, moved)[0].y_um, free_run(base, moved)[0].y_um)
    held = horizon_curve(model, moved, [1, 50]).rms_um
    assert held[1] < horizon_curve(base, moved, [1, 50]).rms_um[1]
    knowing = free_run(model, moved, follow_drift=True)[0].y_um - moved.segments[0].y_um
    blind = free_run(base, moved)[0].y_um - moved.segments[0].y_um
    assert np.abs(knowing[-500:]).mean() < np.abs(blind[-500:]).mean()


def test_a_record_at_another_rate_or_too_short_is_refused() -> None:
    model = random_model(0)
    slow = Record.from_segments([Segment("0", np.arange(9.0), np.arange(9.0))], 2 * TS_S)
    with pytest.raises(RecordError, match=r"sampled every 4e-05 s, but model random steps every 2e-05 s"):
        free_run(model, slow)
    short = Record.from_segments([Segment("0", np.arange(9.0), np.arange(9.0))], TS_S)
    with pytest.raises(RecordError, match="a horizon of 9 samples needs longer segments than 9"):
        horizon_curve(model, short, [1, 9])
    broken = Record.from_segments([Segment("0", np.arange(9.0), np.full(9, np.nan))], TS_S)
    with pytest.raises(RecordError, match="not finite"):
        free_run(model, broken)
