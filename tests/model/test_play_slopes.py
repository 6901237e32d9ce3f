"""The slope bound of weighted plays: no step of the input exceeds it, and one step attains it."""

import numpy as np
import pytest

from hysgen.model.terms import Drive
from hysgen.model.terms.memory import Memory

TS_S = 1e-3
LOW_V, HIGH_V = -20.0, 60.0


def weights_of(plays: Memory, seed: int) -> np.ndarray:
    """Weights as fits have them: the polynomials move the output by about as much as the plays do."""
    scale = np.repeat([1.0, 0.25 * (HIGH_V - LOW_V), 0.1 * (HIGH_V - LOW_V)][: plays.degree], plays.plays)
    return np.random.default_rng(seed).normal(size=plays.size) * scale


def bound_of(plays: Memory, theta: np.ndarray) -> float:
    return float(plays.steepest(theta) @ theta)


def steepest_step(plays: Memory, theta: np.ndarray, u_V: np.ndarray) -> float:
    """Largest change of the output over the change of the input that made it."""
    w, du = np.diff(plays.regressors(Drive(u_V, TS_S)) @ theta)[1:], np.diff(u_V)[:-1]
    return float(np.abs(w[du != 0.0] / du[du != 0.0]).max())


@pytest.mark.parametrize("past_input", [False, True])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_no_step_moves_the_output_by_more_than_the_bound(degree: int, past_input: bool) -> None:
    plays = Memory.polynomial(5, degree, LOW_V, HIGH_V, past_input)
    rng = np.random.default_rng(degree)
    for seed in range(20):
        theta = weights_of(plays, seed)
        for step_V in (0.5, 6.0, 40.0):
            # Walks that reach the ends and turn there, from a start that no past explains.
            walk = np.clip(20.0 + np.cumsum(rng.normal(0.0, step_V, 2000)), LOW_V, HIGH_V)
            assert steepest_step(plays, theta, walk) <= bound_of(plays, theta) * (1 + 1e-9)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_some_step_moves_the_output_by_the_bound(degree: int) -> None:
    plays = Memory.polynomial(4, degree, LOW_V, HIGH_V, past_input=True)
    # Every loop between two of 25 levels, from either end of the range: each set of plays that can move does.
    levels, path = np.linspace(LOW_V, HIGH_V, 25), [LOW_V]
    for low in levels:
        for high in levels[levels > low]:
            path += [HIGH_V, low, high, LOW_V, high, low]
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path)))])
    u_V = np.interp(np.arange(0.0, way[-1], 0.2), way, path)
    for seed in range(6):
        theta = weights_of(plays, seed)
        assert steepest_step(plays, theta, u_V) > 0.9 * bound_of(plays, theta)


def test_a_negative_weight_of_the_past_input_lowers_the_bound_of_the_plays() -> None:
    plays = Memory((0.0, 1.0, 2.0))
    assert bound_of(plays, np.array([0.0, 1.0, 2.0])) == pytest.approx(3.0)
    assert bound_of(plays, np.array([-1.5, 1.0, 2.0])) == pytest.approx(1.5)
    assert bound_of(plays, np.array([-4.0, 1.0, 2.0])) == pytest.approx(4.0)


def test_the_row_bounds_other_weights_from_below_so_the_set_that_it_limits_is_convex() -> None:
    plays = Memory.polynomial(6, 3, LOW_V, HIGH_V, past_input=True)
    rows = [plays.steepest(weights_of(plays, seed)) for seed in range(12)]
    for seed in range(12):
        theta = weights_of(plays, seed)
        assert max(float(row @ theta) for row in rows) <= bound_of(plays, theta) * (1 + 1e-12)
        assert bound_of(plays, theta) <= float(np.abs(theta) @ np.array(plays.gains(TS_S))) * (1 + 1e-12)
