"""The model's own figure: what no model can know of a record is taken out of its error, and nothing else."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.model.path.creep import Creep
from hysgen.model.path.modes import Modes
from hysgen.model.remaining import Named, Remaining, ramp, take_out

Floats = NDArray[np.float64]

N, TS_S = 4000, 1e-3
T_S = TS_S * np.arange(N)
NAMED = Named(
    (Creep(0.02, (0.1, 1.0, 10.0)), Modes((87.0,), (0.02,), (0.3,), 1e-3)), (50.0, 29.1619), (("drift", ramp),), True
)


def motion_um(rng: np.random.Generator) -> Floats:
    """A command of a few sines with rests, as the displacement of a stage."""
    f_Hz, turn = rng.uniform(0.5, 20.0, 4), rng.uniform(0.0, 2.0 * np.pi, 4)
    sines = np.sin(2.0 * np.pi * f_Hz[:, None] * T_S + turn[:, None]).sum(axis=0)
    return np.asarray(sines * (np.sin(2.0 * np.pi * 0.7 * T_S) > -0.5))


def left_of(disturbance_um: Floats, predicted_um: Floats, noise_um: Floats, named: Named = NAMED) -> Remaining:
    """What is left where the measured displacement is prediction, disturbance and noise."""
    measured = predicted_um + disturbance_um + noise_um
    return take_out([predicted_um - measured], [measured], [np.arange(N) >= 1], TS_S, named)


DISTURBANCES = {
    "past": 0.3 * np.exp(-T_S / 0.1) + 0.05,
    "periodic": 0.08 * np.sin(2.0 * np.pi * 29.1619 * T_S + 0.7),
    "drift": 0.1 * T_S,
    "jump": 0.2 * (T_S > 1.234) - 0.3 * (T_S > 2.5),
}


@pytest.mark.parametrize("cause", DISTURBANCES)
def test_a_planted_disturbance_is_taken_out_down_to_the_noise(cause: str) -> None:
    rng = np.random.default_rng(5)
    left = left_of(DISTURBANCES[cause], motion_um(rng), noise := rng.normal(scale=0.01, size=N))
    assert {taken.cause for taken in left.taken} - {"past"} <= {cause}
    assert cause in {taken.cause for taken in left.taken}
    # Ten parameters of 4000 rows lower the noise by 0.1 %.
    assert left.rms_um == pytest.approx(float(np.std(noise)), rel=0.01)


def test_a_step_of_the_gain_is_taken_out_with_its_size() -> None:
    rng = np.random.default_rng(6)
    moved = motion_um(rng)
    left = left_of(-0.05 * moved * (T_S > 1.5), moved, noise := rng.normal(scale=0.01, size=N))
    (step,) = [taken for taken in left.taken if taken.cause == "gain step"]
    assert step.text.startswith("the gain changes at 1.501 s by -")
    # The noise over the root of 2500 rows and the motion: 0.02 %.
    assert float(step.text.rpartition(" ")[2].rstrip("%")) == pytest.approx(-5.0, abs=0.08)
    assert left.rms_um == pytest.approx(float(np.std(noise)), rel=0.01)


def test_wrong_readings_are_not_counted_and_are_listed() -> None:
    rng = np.random.default_rng(7)
    wrong = np.zeros(N)
    wrong[[700, 1900, 3100]] = 1.0, -2.0, 0.5
    left = left_of(wrong, motion_um(rng), rng.normal(scale=0.01, size=N))
    (taken,) = left.taken
    assert (taken.cause, taken.rows) == ("outliers", (700, 1900, 3100))
    assert not left.counted[0][[700, 1900, 3100]].any()
    assert left.rms_um == pytest.approx(0.01, rel=0.05)


def taken_over_noise(seed: int, misfit: float) -> float:
    """Rms of what is taken out of a record without any disturbance, over the noise."""
    rng = np.random.default_rng(seed)
    moved = motion_um(rng)
    # A misfit that follows the motion and its rate, as that of a hysteresis does.
    wrong = misfit * (np.sin(3.0 * moved) + 0.5 * np.tanh(np.gradient(moved, TS_S) / 20.0))
    noise = rng.normal(scale=0.01, size=N)
    left = left_of(0.01 * wrong, moved, noise)
    error = -(0.01 * wrong + noise)
    return float(np.sqrt(np.mean((left.error_um[0] - error)[1:] ** 2))) / 0.01


@pytest.mark.slow
def test_nothing_is_taken_out_of_200_records_without_a_disturbance() -> None:
    assert max(taken_over_noise(seed, 0.0) for seed in range(200)) <= 0.05


@pytest.mark.slow
def test_the_misfit_of_a_model_is_not_taken_out() -> None:
    found = [taken_over_noise(seed, 3.0) for seed in range(200, 260)]
    # The misfit is three times the noise; a tenth of it may resemble a drift or the level of the sensor.
    assert sum(share > 0.3 for share in found) <= 3, sorted(found)[-5:]


def test_a_coarser_model_has_nothing_more_taken_out_than_a_finer_one_of_the_same_record() -> None:
    assert NAMED.only({"jump", "outliers"}) == Named()
    assert NAMED.only({"periodic"}) == Named(lines_Hz=NAMED.lines_Hz)
    assert NAMED.only({"past", "drift"}) == dataclasses.replace(NAMED, lines_Hz=())
    rng = np.random.default_rng(9)
    moved, noise = motion_um(rng), rng.normal(scale=0.01, size=N)
    best = left_of(DISTURBANCES["jump"], moved, noise)
    measured = moved + DISTURBANCES["jump"] + noise
    coarse_um = moved + 0.1 * np.sin(3.0 * moved)
    left = take_out([coarse_um - measured], [measured], [np.arange(N) >= 1], TS_S, Named(), best)
    np.testing.assert_allclose(left.error_um[0], coarse_um - measured + best.sudden_um[0])
    assert left.rms_um == pytest.approx(float(np.std(coarse_um - moved - noise)), rel=0.01)
