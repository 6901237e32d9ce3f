"""The probe: its linear part is exact, its estimates land on the truth, its standard errors mean what they say."""

import math
import tracemalloc

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import StateSpace, lfilter, lsim

from fixtures.linear_stage import respond
from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.causes.hysteresis import RelaxationPart
from hysgen.diagnosis.causes.unknown import SuddenPart
from hysgen.diagnosis.probe import (
    NO_HISTORY,
    Chain,
    History,
    Mode,
    Operator,
    Part,
    Projector,
    Scene,
    Trace,
    functional_error,
    linear_fit,
    refine,
    single_fit,
    standard_errors,
)
from hysgen.diagnosis.probe.solve import BLOCKS, block_left_out_error
from hysgen.machine.kernels.operators import Branch, LinearPart, linear_response, linear_response_rows
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes
from hysgen.model.residual import outlier_flags

Floats = NDArray[np.float64]
TS_S = 1e-3


def staircase(rng: np.random.Generator, samples: int) -> Floats:
    """Levels held for 20 samples each."""
    return np.repeat(rng.uniform(0.0, 10.0, samples // 20 + 1), 20)[:samples]


@pytest.mark.parametrize(("delay", "early_s"), [(0.0, 0.0), (0.3, 4e-4), (2.6, 0.0)])
def test_lag_mode_and_fractional_delay_equal_the_differential_equation(delay: float, early_s: float) -> None:
    h = staircase(np.random.default_rng(1), 400)
    mode = Mode(40.0, 0.05, 0.4, early_s)
    w = 2 * math.pi * mode.f_Hz
    # States: lag, mode, its rate. The mode carries 0.4 of what drives the lag of 4 ms.
    A = np.array([[-250.0, 250.0 * 0.4, 100.0 * early_s], [0.0, 0.0, 1.0], [0.0, -w * w, -2 * 0.05 * w]])
    B = np.array([[250.0 * 0.6], [0.0], [w * w]])
    fine = 100  # divides every delay above into whole steps of 10 us
    held = np.repeat(h - h[0], fine)
    _, y, _ = lsim(
        StateSpace(A, B, np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 1))),
        held,
        np.arange(held.size) * TS_S / fine,
        interp=False,
    )
    late = round(delay * fine)
    expected = h[0] + np.concatenate([np.zeros(late), np.ravel(y)])[::fine][: h.size]
    got = respond(h, Chain(4e-3, (Delay(delay), Modes.of((mode,), 1.0))), TS_S)
    # Both are exact for held inputs; what remains is rounding over 400 steps.
    np.testing.assert_allclose(got, expected, atol=1e-9)


@pytest.mark.parametrize(("columns", "late"), [(1, 0), (2, 3), (5, -4), (8, 1), (9, 250), (3, -250)])
def test_the_response_of_many_columns_equals_that_of_each_column(columns: int, late: int) -> None:
    """Whatever their number and the delay, every column is what SciPy's filters make of it, in its own place."""
    rng = np.random.default_rng(columns)
    h = np.cumsum(rng.normal(size=(columns, 200)), axis=1) + 5.0
    keep = np.exp(-1.0 / np.array([2.0, 7.0, 50.0]))
    lag = Branch(0.7, np.array([0.0, 0.2, 0.1]), np.array([1.0, -0.7, 0.0]))
    mode = Branch(0.3, np.array([0.0, 0.1, 0.2, 0.1, 0.05]), np.array([1.0, -1.5, 1.0, -0.3, 0.0]))
    moved = h - h[:, :1]
    slow = sum(0.5 * lfilter([0.0, 1.0 - a], [1.0, -a], moved, axis=1) for a in keep)
    total = sum(b.share * lfilter(b.numerator, b.denominator, moved + 0.1 * slow, axis=1) for b in (lag, mode))
    shifted = np.concatenate([np.zeros((columns, max(late, 0))), total, np.repeat(total[:, -1:], 400, axis=1)], axis=1)
    expected = h[:, :1] + shifted[:, max(-late, 0) :][:, :200]
    seen = linear_response(h, LinearPart(0.1, keep, [lag, mode], late))
    np.testing.assert_allclose(seen, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("late", [0, 3, -2])
def test_some_rows_of_a_response_are_those_of_the_whole_response_bit_for_bit(late: int) -> None:
    rng = np.random.default_rng(2)
    h = np.cumsum(rng.normal(size=(7, 200)), axis=1)
    linear = LinearPart(
        0.1, np.array([0.9, 0.99]), [Branch(0.7, np.array([0.0, 0.3, 0.1]), np.array([1.0, -0.7, 0.1]))], late
    )
    whole = linear_response(h, linear)
    for rows in ([0, 1, 2, 77, 199], [5], list(range(200)), []):
        chosen = np.array(rows, dtype=np.int64)
        assert linear_response_rows(h, linear, chosen).tobytes() == whole[:, chosen].tobytes()
    with pytest.raises(ValueError, match="rise"):
        linear_response_rows(h, linear, np.array([3, 3]))
    with pytest.raises(ValueError, match="rise"):
        linear_response_rows(h, linear, np.array([200]))


@pytest.mark.parametrize("aging", [0.0, 0.3])
def test_training_columns_are_rows_of_all_columns_bit_for_bit(aging: float) -> None:
    rng = np.random.default_rng(3)
    u_V = staircase(rng, 200)
    runs = tuple(Trace(u, u, {"T": np.cumsum(rng.normal(size=len(u)))}) for u in (staircase(rng, 300), u_V))
    rows = np.flatnonzero(rng.random(500) < 0.3)
    parts = (
        CreepPart(0.02, 0.01),
        Modes.of((Mode(80.0, 0.05, 0.1),), 1.0),
        Delay(1.4),
        Coupling.of({"T": (-1e3, 1e3)}, 2),
        Periodic((33.0,)),
        DriftPart(),
        SuddenPart(jumps_s=(0.1,)),
        *((AgingPart(aging),) if aging else ()),
    )
    scene, chain = Scene(runs, TS_S, rows, Operator(0.0, 10.0)), Chain(0.004, parts)
    for part in (scene, scene.using(rows[::2])):
        assert part.training_columns(chain).tobytes() == scene.columns(chain)[:, part.rows].tobytes()
    weights = rng.normal(size=len(scene.columns(chain)))
    paths = scene.paths(chain, weights)
    seen = scene.seen(paths, chain, weights)
    # A product with all columns and one with some of them round differently.
    np.testing.assert_allclose(
        scene.seen_on_rows(paths, chain, weights), seen[rows], rtol=0.0, atol=1e-13 * np.abs(seen).max()
    )


@pytest.mark.parametrize("history", [False, True])
@pytest.mark.parametrize("part", [Saturation(high_V=7.0), Slew(300.0, 300.0), RelaxationPart(0.02), Delay(1.4)])
def test_moved_paths_are_the_weighted_columns_of_the_hysteresis(part: Part, history: bool) -> None:
    rng = np.random.default_rng(5)
    u_V = staircase(rng, 300)
    ages = np.array([0, 1, 2, 40])
    past = History(u_V[:3], np.array([10, 20, 10]), ages, np.array([2, 1, 0])) if history else NO_HISTORY
    scene = Scene((Trace(u_V, u_V, {}, start=-1.0, history=past),), TS_S, np.arange(300), Operator(0.0, 10.0))
    chain, weights = Chain(0.004).having(part), rng.normal(size=60)
    (moved,), (path,) = scene.moved_paths(chain, weights), scene.paths(chain, weights)
    # The same products, added in another order.
    np.testing.assert_allclose(moved, path, rtol=0.0, atol=1e-13 * np.abs(path).max())


def test_columns_of_the_curve_follow_lag_delay_and_level() -> None:
    """Each chain gets its own columns although the scene keeps them: L(v)^2 - L(v^2), L(v) L(v^2) - L(v^3)."""
    u_V = staircase(np.random.default_rng(4), 300)
    scene = Scene((Trace(u_V, u_V, {}),), TS_S, np.arange(300), Operator(0.0, 10.0))
    plain = Chain(0.004)
    chains = [plain, Chain(0.006), plain.having(Delay(1.4)), plain.having(Saturation(high_V=7.0)), plain]
    for chain in chains:
        v = np.minimum(u_V, 7.0 if chain.amplifier else np.inf) / 5.0 - 1.0
        first, second, third = (respond(v**power, Chain(chain.lag_s, chain.parts), TS_S) for power in (1, 2, 3))
        expected = [first * first - second, first * second - third]
        np.testing.assert_allclose(scene.added_columns(chain)[1:3], expected, rtol=0.0, atol=1e-14)


def test_creep_of_a_past_step_is_that_of_a_step_in_the_record() -> None:
    """A record whose first samples are cut off: at 9 V, where it rested, and 149 at the first level that is kept."""
    kept_V = np.concatenate([[2.0], staircase(np.random.default_rng(6), 400)])
    whole_V = np.concatenate([[9.0], np.full(149, 2.0), kept_V])
    creep = CreepPart(0.1, 5 * TS_S)
    past = CreepPart(0.1, 5 * TS_S, 9.0, 149 * TS_S)

    def columns(u_V: Floats, part: CreepPart) -> Floats:
        run = Trace(u_V, u_V, {}, segment=len(whole_V))
        seen = Scene((run,), TS_S, np.arange(len(u_V)), Operator(0.0, 10.0))
        return seen.columns(Chain(1e-3, (part,), memory=False))[:-3, 5 - len(kept_V) :]

    # The constant of the weights is free; the lag has forgotten the cut after five samples.
    whole = columns(whole_V, creep)
    assert np.ptp(columns(kept_V, creep) - whole, axis=1).max() > 0.05
    assert np.ptp(columns(kept_V, past) - whole, axis=1).max() < 1e-3


def test_chain_and_its_coordinates_are_inverse_to_each_other() -> None:
    parts = (
        Saturation(-3.0, 80.0),
        Slew(5e3, 5e3),
        Delay(1.4),
        RelaxationPart(0.02),
        CreepPart(0.02, 0.1),
        Modes.of((Mode(100.0, 0.03, 0.5),), 1.0),
        AgingPart(-0.01),
        DriftPart(0.7),
        Periodic((50.0, 120.0)),
        Coupling.of({"a": (-1e3, 1e3)}),
        SuddenPart((1.0, 2.0), ((1.5, 0.02),)),
    )
    assert {part.cause for part in parts} == {name for name, cause in causes().items() if cause.part is not None}
    chain = Chain(2e-3, parts)
    assert len(chain.names()) == len(chain.coordinates())
    again = chain.at(chain.coordinates())
    np.testing.assert_allclose(again.coordinates(), chain.coordinates(), rtol=1e-14)
    assert [type(part) for part in again.parts] == [type(part) for part in parts]
    np.testing.assert_allclose(again.at(chain.coordinates()).coordinates(), chain.coordinates(), rtol=1e-14)


def test_delay_and_its_standard_error_agree_with_repeated_noise() -> None:
    rng = np.random.default_rng(2)
    u_V = np.cumsum(rng.normal(size=3000)) * 0.3
    clean = 0.1 * respond(u_V, Chain(6e-3, (Delay(1.7),)), TS_S)
    found, errors = [], []
    for _ in range(20):
        y_um = clean + 0.05 * rng.normal(size=3000)
        operator = Operator(float(u_V.min()), float(u_V.max()), hats=0, curve=1, reaches=())
        scene = Scene((Trace(u_V, y_um, {}),), TS_S, np.arange(50, 3000), operator)
        fit = refine(scene, Chain(3e-3, (Delay(0.5),)))
        found.append(fit.chain.delay)
        errors.append(standard_errors(scene, fit).coordinates["delay.samples"])
    # The mean of 20 lies within 4 standard errors of the mean; the spread of 20 is known to 1/sqrt(38) = 16 %,
    # and 3 of those either way is a factor of 2.
    assert abs(np.mean(found) - 1.7) < 4 * np.std(found) / math.sqrt(20)
    assert 0.5 < np.mean(errors) / np.std(found, ddof=1) < 2.0


def test_the_loop_and_its_standard_error_agree_with_repeated_noise_where_the_lag_is_fitted_too() -> None:
    """Sweeps of one rate: a lag opens the loop as memory does, so that the error of the lag is in that of the loop."""
    rng = np.random.default_rng(5)
    swings = np.repeat(rng.uniform(0.3, 1.0, 60), 2) * np.tile([1.0, -1.0], 60)
    u_V = np.interp(np.arange(3000) / 25.0, np.arange(120), 5.0 * swings)
    # Bouc and Wen's hysteresis, which no column of the operator is.
    z, clean = 0.0, np.zeros(3000)
    for k, step in enumerate(np.diff(u_V, prepend=u_V[0])):
        z += 0.3 * step - 0.2 * abs(step) * z - 0.1 * step * abs(z)
        clean[k] = 0.1 * u_V[k] + z
    clean = respond(clean, Chain(6e-3), TS_S)
    operator = Operator(-5.0, 5.0, plays=6, degree=2, reaches=(0.2, 0.6))
    sine = 4.5 * np.sin(2.0 * np.pi * np.arange(401) / 200)
    found, errors = [], []
    for _ in range(20):
        scene = Scene((Trace(u_V, clean + 0.05 * rng.normal(size=3000), {}),), TS_S, np.arange(50, 3000), operator)
        fit = refine(scene, Chain(3e-3, memory=True))
        opening = np.trapezoid(operator.columns(sine)[:, 200:], sine[200:], axis=1) / 9.0
        found.append(opening @ fit.weights[: len(opening)])
        errors.append(functional_error(scene, fit, opening))
    # As above; without the column of the lag, the error is less than half of the spread.
    assert 0.5 < np.mean(errors) / np.std(found, ddof=1) < 2.0


def test_the_residual_of_a_standard_error_is_that_of_a_fit_without_the_block() -> None:
    rng = np.random.default_rng(4)
    columns, y_um = rng.normal(size=(30, 800)), rng.normal(size=800)
    fitted = y_um - np.linalg.lstsq(columns.T, y_um)[0] @ columns
    expected = np.empty(800)
    for block in np.split(np.arange(800), BLOCKS):
        weights = np.linalg.lstsq(np.delete(columns, block, axis=1).T, np.delete(y_um, block))[0]
        expected[block] = y_um[block] - weights @ columns[:, block]
    # The projector's ridge moves its columns by 1e-9 of their size.
    np.testing.assert_allclose(block_left_out_error(Projector.of(columns), fitted), expected, atol=1e-7)


def test_isolated_finds_single_and_paired_corrupted_samples_and_no_steps() -> None:
    rng = np.random.default_rng(3)
    error_um = 0.01 * rng.normal(size=2000)
    error_um[1000:] += 1.0
    error_um[1200:1204] += 0.5  # four samples are no reading gone wrong
    wrong = [300, 302, 700, 1500, 1700, 1701, 1800, 1801]
    error_um[wrong] += [0.5, 0.4, -0.4, 0.6, 0.5, 0.7, 0.4, -0.5]
    # What fades in from an unknown past, or out, has neighbours on one side only.
    fading_um = 2.0 * 0.9 ** np.arange(60)
    error_um[:60] += fading_um
    error_um[-60:] -= fading_um[::-1]
    assert np.flatnonzero(outlier_flags(error_um, 0.0, 0.0 * error_um)).tolist() == wrong


def test_jitter_of_the_sampling_instant_corrupts_no_sample() -> None:
    """0.05 samples of jitter: an error in proportion to the speed, 40 times the noise where the stage is fast."""
    rng = np.random.default_rng(4)
    moved_um = np.where(np.arange(4000) % 1000 < 200, np.sin(np.arange(4000) / 8.0), 0.0)
    error_um = 1e-4 * rng.normal(size=4000) + 0.05 * rng.normal(size=4000) * np.gradient(moved_um)
    assert outlier_flags(error_um, 0.0, 0.0 * error_um).sum() > 100, "the error shows no difference"
    assert outlier_flags(error_um, 0.0, moved_um).sum() <= 2
    error_um[[500, 1100]] += 0.1
    assert outlier_flags(error_um, 0.0, moved_um)[[500, 1100]].all()


def test_readings_a_code_apart_are_not_corrupted() -> None:
    """Half of the readings repeat the code before them, so the median deviation is no measure of the scatter."""
    rng = np.random.default_rng(5)
    error_um = np.where(rng.random(3000) < 0.02, 0.01, 0.0)
    assert outlier_flags(error_um, 0.0, 0.0 * error_um).any(), "the error shows no difference"
    assert not outlier_flags(error_um, 0.01, 0.0 * error_um).any()
    error_um[1500] = 0.1
    assert np.flatnonzero(outlier_flags(error_um, 0.01, 0.0 * error_um)).tolist() == [1500]


@pytest.mark.parametrize(
    "operator",
    [
        Operator(0.0, 10.0),
        Operator(0.0, 10.0, hats=0, reaches=()),
        Operator(0.0, 10.0, plays=2, hats=2, degree=3, reaches=(1.0,)),
        Operator(0.0, 10.0, hats=12, degree=7, relaxation=0.02),
    ],
)
def test_columns_a_few_at_a_time_have_the_bits_of_all(operator: Operator) -> None:
    u_V = staircase(np.random.default_rng(8), 1000)
    found = np.full((operator.size, 1000), np.nan)
    for rows, formed in operator.groups():
        found[rows] = formed(u_V, start=1.0)
    assert np.array_equal(found, operator.columns(u_V, 1.0))


def test_a_fit_that_nobody_repeats_is_that_of_all_columns_in_a_third_of_the_memory() -> None:
    rng, samples = np.random.default_rng(9), 60_000
    u_V = staircase(rng, samples)
    y_um = np.tanh(u_V - 5.0) + 1e-3 * rng.normal(size=samples)
    rows = np.arange(100, samples, 20)
    peaks, fits = [], []
    for fitted in (linear_fit, single_fit):
        scene = Scene((Trace(u_V, y_um, {}),), TS_S, rows, Operator(0.0, 10.0))
        tracemalloc.start()
        fits.append(fitted(scene, Chain(0.004, (DriftPart(),))))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert np.allclose(fits[0].error, fits[1].error, rtol=0.0, atol=1e-9)
    assert peaks[1] < peaks[0] / 3.0


@pytest.mark.parametrize("u_V", [-10.0, 3.0, 40.0, 85.0])
def test_the_mean_of_the_branches_is_that_of_the_major_loop(u_V: float) -> None:
    operator = Operator(-10.0, 90.0)
    weights = np.random.default_rng(3).normal(size=operator.size)
    weights[-2 * len(operator.reaches) :] = 0.0
    rise_V = np.linspace(-10.0, 90.0, 2001)
    cycles = np.concatenate([rise_V, rise_V[::-1], rise_V])
    h_um = weights @ operator.columns(cycles, 0.0)
    down, up = h_um[2001:4002][::-1], h_um[4002:]
    assert weights @ operator.at(u_V) == pytest.approx(0.5 * np.interp(u_V, rise_V, down + up), abs=1e-6)


def test_outside_the_range_the_operator_extrapolates_along_the_ends_of_the_major_loop() -> None:
    operator = Operator(20.0, 100.0)
    weights = np.random.default_rng(4).normal(size=operator.size)
    low, high, outside = (weights @ operator.at(u_V) for u_V in (20.0, 100.0, 0.0))
    assert outside == pytest.approx(low - 0.25 * (high - low))


def test_a_reading_that_may_be_of_another_instant_is_not_corrupted() -> None:
    """A step of the command, of which the sensor takes one sample a tenth of a period late."""
    rng = np.random.default_rng(7)
    moved_um = np.convolve(np.arange(1000) % 250 >= 125, 0.3 * 0.7 ** np.arange(40))[:1000]
    error_um = 1e-4 * rng.normal(size=1000)
    stepped = 1 + np.flatnonzero(np.diff(moved_um) > 0.2)
    error_um[stepped] += 0.03
    assert outlier_flags(error_um, 0.0, 0.0 * error_um)[stepped].all()
    assert not outlier_flags(error_um, 0.0, moved_um).any()
    error_um[[60, 700]] += 0.03
    assert np.flatnonzero(outlier_flags(error_um, 0.0, moved_um)).tolist() == [60, 700]
