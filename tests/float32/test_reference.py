"""The float32 reference: close to the float64 model everywhere, safe against any input, exact about its state."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.drawn_models import RULES, random_model
from fixtures.generated_models import everything, path
from hysgen.float32.coefficients import coefficients
from hysgen.float32.reference.accuracy import accuracy
from hysgen.float32.reference.instance import Instance, rule_sums, strengths, window
from hysgen.model.file import load_model
from hysgen.model.model import Grid, Model
from hysgen.model.path.base import TOLERANCE
from hysgen.model.path.modes import Modes
from hysgen.model.regression import memberships, rule_regressors
from hysgen.model.structs import COUNTERS, Status

F32 = NDArray[np.float32]


def lanes(*values: float) -> F32:
    return np.array(values, dtype=np.float32)


def instance(model: Model, y_um: float = 2.0, u_V: float = 30.0, count: int = 1) -> Instance:
    return Instance(model, np.full(count, y_um, np.float32), np.full(count, u_V, np.float32))


@pytest.mark.slow
def test_terms_and_blocks_keep_the_accuracy() -> None:
    assert accuracy(everything(), 20_000).predict_um < 5e-6


@pytest.mark.parametrize("seed", range(len(RULES)))
def test_rule_sums_are_those_of_the_memberships(seed: int) -> None:
    """S/W, O/W, G/W against float64, and the strengths against p; 2e-6 of the largest consequent: 20 roundings."""
    model = random_model(seed)
    numbers = coefficients(model)
    y = np.linspace(numbers.y_min_um, numbers.y_max_um, 997, dtype=np.float32)
    p = memberships(y.astype(np.float64), model.grid)
    sums = rule_sums(numbers, numbers.bank, y)
    for column, found in enumerate((sums.slope, sums.gain, sums.offset)):
        expected = p @ model.consequents[:, column]
        largest = np.abs(model.consequents[:, column]).max()
        np.testing.assert_allclose(found / sums.weight.astype(np.float64), expected, atol=2e-6 * largest, rtol=0)
    if numbers.windowed:
        first, v = window(numbers, y)
        assert first.max() < numbers.rules
        assert len(v) == 11
    else:
        v = strengths(numbers, y)
        np.testing.assert_allclose((np.array(v) / sums.weight).T, p, atol=2e-6)


@pytest.mark.slow
def test_free_run_follows_float64_as_closely_as_contraction_promises() -> None:
    """e(k+1) <= s e(k) + e_predict, so e < e_predict / (1 - s): Appendix A 2.8e-6 um / (1 - 0.99634) = 7.7e-4 um."""
    model = load_model("appendix_a")
    proved = accuracy(model, 100).proved
    assert proved is not None
    bound = proved.predict_um / (1.0 - 0.9963415)
    rng = np.random.default_rng(3)
    u = (50.0 + 60.0 * np.sin(np.arange(4000) / 80.0) * rng.uniform(0.9, 1.0, 4000)).astype(np.float32)
    run, truth, worst = instance(model), np.array([2.0]), 0.0
    for k in range(u.size):
        inputs = u[k : k + 1]
        truth = rule_regressors(truth, inputs.astype(np.float64), model.grid) @ model.consequents.ravel()
        worst = max(worst, float(np.abs(run.simulate(inputs) - truth)[0]))
    assert 0.0 < worst < bound


def test_inverse_leaves_the_state_that_the_prediction_under_its_input_leaves() -> None:
    """Also where the input is limited: anti-windup. Bit for bit, the path included, but for what limits leave."""
    model = dataclasses.replace(path(), blocks=path().blocks[-3:])
    rng = np.random.default_rng(5)
    y, y_next = (rng.uniform(0.7, 3.7, 4000).astype(np.float32) for _ in range(2))
    backward, forward = instance(model, count=4000), instance(model, count=4000)
    u = backward.inverse(y, y_next)
    assert (u == 120.0).any()
    assert (u == -20.0).any()
    assert ((u > -20.0) & (u < 120.0)).any()
    forward.predict(y, u)
    limited = [f"inputs[{i}]" for i in range(1, 5)]
    assert (backward.words()[limited[0]] != 0).any()
    names = [name for name in forward.words() if name.startswith("inputs") and name not in limited]
    for name in ("y_um", "u_V", *names):
        np.testing.assert_array_equal(backward.words()[name], forward.words()[name])


def test_the_inverse_follows_from_its_own_displacement_though_it_omits_a_mode() -> None:
    """Eq. (11) behind a mode without a stable inverse; fed back with its ringing, the voltage ran from end to end."""
    keep = float(np.exp(-0.2))
    mode = Modes((800.0,), (0.01,), (1.06,), 1e-4)
    model = Model(
        "ringing", 2e-5, Grid(-40.0, 140.0, 4), np.tile([keep, 1.0 - keep, 0.0], (4, 1)), -20.0, 120.0, blocks=(mode,)
    )
    assert not mode.solves(model.Ts_s)
    asked_um = (50.0 - 30.0 * np.cos(2.0 * np.pi * 20.0 * 2e-5 * np.arange(5000.0))).astype(np.float32)
    run = instance(model, 20.0, 20.0)
    u_V = np.array([run.inverse(run.y_um, asked_um[k : k + 1])[0] for k in range(5000)], dtype=np.float64)
    assert run.status[0] == 0
    # A mode lags by (20/800)^2 of 30 um, and rings by as much again.
    assert np.abs(model.simulate(u_V)[1:] - asked_um[:-1]).max() < 3.0 * 30.0 * (20.0 / 800.0) ** 2


def test_unreachable_reference_is_flagged_and_reachable_one_is_not() -> None:
    model = load_model("appendix_a")
    run = instance(model, count=2)
    y = lanes(2.0, 2.0)
    near = instance(model, count=2).predict(y, lanes(50.0, 50.0))
    run.inverse(y, lanes(float(near[0]), 3.0))
    assert run.status.tolist() == [0, Status.UNREACHABLE | Status.U_CLAMPED]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_sample_that_is_not_finite_is_replaced_flagged_and_counted(bad: float) -> None:
    model = load_model("appendix_a")
    run, twin = instance(model), instance(model)
    run.predict(lanes(1.5), lanes(40.0))
    held = float(twin.predict(lanes(1.5), lanes(40.0))[0])
    assert run.predict(lanes(bad), lanes(bad)) == twin.predict(lanes(held), lanes(40.0))
    assert run.status[0] == Status.Y_REJECTED | Status.U_REJECTED
    assert {name: int(count[0]) for name, count in run.counters.items()} == {
        "y_clamped": 0,
        "u_clamped": 0,
        "y_rejected": 1,
        "u_rejected": 1,
    }
    assert np.isfinite(run.y_um).all()
    assert run.u_V == 40.0


def test_no_input_whatever_makes_a_result_that_is_not_finite_or_denormal() -> None:
    model = everything()
    rng = np.random.default_rng(7)
    run = instance(model, count=5000)
    smallest = np.float32(2.0**-40)
    with np.errstate(all="ignore"):
        for step in range(60):
            a, b, c = (rng.integers(0, 1 << 32, 5000, dtype=np.uint32).view(np.float32) for _ in range(3))
            run.aux([c])
            result = [run.predict, lambda y, u: run.simulate(u), run.inverse][step % 3](a, b)
            assert np.isfinite(result).all()
            assert ((result == 0.0) | (np.abs(result) >= smallest)).all()
            assert np.isfinite(run.y_um).all()


def test_counters_stop_at_their_largest_value() -> None:
    run = instance(load_model("appendix_a"))
    for name in COUNTERS:
        run.counters[name] = np.full(1, 0xFFFFFFFE, dtype=np.uint32)
    for _ in range(3):
        run.predict(lanes(99.0), lanes(np.nan))
    assert run.counters["y_clamped"][0] == 0xFFFFFFFF
    assert run.counters["u_rejected"][0] == 0xFFFFFFFF
    assert run.counters["u_clamped"][0] == 0xFFFFFFFE


@pytest.mark.parametrize("seed", range(8))
def test_a_restored_state_goes_on_as_the_one_it_was_taken_from(seed: int) -> None:
    """What verification by induction rests on: words() tells everything that matters, and restore() takes it over."""
    model = everything() if seed == 0 else random_model(seed)
    rng = np.random.default_rng(seed)
    copy = instance(model)
    low, high = model.grid.y_min_um, model.grid.y_max_um
    for lanes in (50, 20):  # nothing of the former lanes stays
        run = instance(model, count=lanes)

        def samples(lanes: int = lanes, aux: int = len(run.channels)) -> tuple[F32, F32, list[F32]]:
            y, u = rng.uniform(low, high, lanes), rng.uniform(model.u_min_V, model.u_max_V, lanes)
            return y.astype(np.float32), u.astype(np.float32), [rng.uniform(0, 30, lanes).astype(np.float32)] * aux

        for _ in range(30):
            y, u, aux = samples()
            run.aux(aux)
            run.predict(y, u)
        copy.restore([word.copy() for word in run.words().values()])
        for _ in range(5):
            y, u, aux = samples()
            for one in (run, copy):
                one.aux(aux)
            np.testing.assert_array_equal(run.inverse(y, y[::-1]), copy.inverse(y, y[::-1]))
            np.testing.assert_array_equal(run.predict(y, u), copy.predict(y, u))
        for name, word in run.words().items():
            np.testing.assert_array_equal(word, copy.words()[name], err_msg=name)


def test_a_start_that_is_no_number_is_mid_range_at_rest_and_references_reach_a_span_beyond() -> None:
    model = path()
    run = instance(model, np.nan, np.inf)
    assert (run.y_um[0], run.u_V[0]) == (np.float32((model.grid.y_min_um + model.grid.y_max_um) / 2), 0.0)
    assert coefficients(dataclasses.replace(model, u_min_V=5.0)).rest_V == 5.0
    assert coefficients(dataclasses.replace(model, u_max_V=-5.0)).rest_V == -5.0
    numbers, span = coefficients(model), model.grid.y_max_um - model.grid.y_min_um
    found = (numbers.reference_min_um, numbers.reference_max_um, numbers.u_step_max_V, numbers.w_tolerance)
    w = model.w_range
    expected = (model.grid.y_min_um - span, model.grid.y_max_um + span, 2 * 140.0, TOLERANCE * (w.high - w.low))
    assert found == pytest.approx(expected, rel=1e-6)
