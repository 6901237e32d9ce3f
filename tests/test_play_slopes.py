"""The bound on weighted play operators: above everything that two inputs can do, and not far above."""

import numpy as np
import pytest

from hysgen.terms import Drive
from hysgen.terms.memory import Memory

TS_S = 1e-3
LOW_V, HIGH_V = -20.0, 60.0


def weights_of(plays: Memory, seed: int) -> np.ndarray:
    """Weights as fits have them: the polynomials move the output by about as much as the plays do."""
    scale = np.repeat([1.0, 0.25 * (HIGH_V - LOW_V), 0.1 * (HIGH_V - LOW_V)][: plays.degree], plays.plays)
    return np.random.default_rng(seed).normal(size=plays.size) * scale


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_two_runs_are_never_further_apart_than_the_bound(degree: int) -> None:
    plays = Memory.polynomial(5, degree, LOW_V, HIGH_V)
    rng = np.random.default_rng(degree)
    for seed in range(20):
        theta = weights_of(plays, seed)
        bound = float(plays.steepest(theta) @ theta)
        for apart_V in (0.01, 1.0, 30.0):
            # Walks that reach the ends and turn there, and others that differ from them as much as they may.
            walk = np.clip(20.0 + np.cumsum(rng.normal(0.0, 6.0, 600)), LOW_V, HIGH_V)
            other = np.clip(walk + apart_V * rng.choice([-1.0, 1.0], 600), LOW_V, HIGH_V)
            w = [plays.regressors(Drive(u, TS_S)) @ theta for u in (walk, other)]
            assert np.abs(w[0] - w[1]).max() <= bound * np.abs(walk - other).max() * (1 + 1e-9)


def test_a_sweep_between_the_ends_comes_near_the_bound_of_positive_slopes() -> None:
    """Weights of a Preisach operator that likes the middle: on a sweep up all its plays move at once."""
    plays = Memory.polynomial(4, 3, LOW_V, HIGH_V)
    theta = np.concatenate([np.ones(4), np.zeros(4), -2.0 * np.ones(4)])
    u = np.concatenate([np.linspace(LOW_V, HIGH_V, 4001), np.linspace(HIGH_V, LOW_V, 4001)])
    w = plays.regressors(Drive(u, TS_S)) @ theta
    reached = np.abs(np.diff(w)).max() / np.abs(np.diff(u)).max()
    bound = float(plays.steepest(theta) @ theta)
    assert 0.9 * bound < reached <= bound
    # Two plays that are steep at opposite ends of the range cannot both stand there.
    apart = np.concatenate([10.0 * np.ones(4), [0.0, 100.0, -100.0, 0.0], np.zeros(4)])
    assert float(plays.steepest(apart) @ apart) < 0.9 * float(np.abs(apart) @ np.array(plays.gains(TS_S)))


def test_the_row_bounds_other_weights_from_below_so_the_set_that_it_limits_is_convex() -> None:
    plays = Memory.polynomial(6, 3, LOW_V, HIGH_V)
    rows = [plays.steepest(weights_of(plays, seed)) for seed in range(12)]
    for seed in range(12):
        theta = weights_of(plays, seed)
        own = float(plays.steepest(theta) @ theta)
        assert max(float(row @ theta) for row in rows) <= own * (1 + 1e-12)
        apart = float(plays.steepest_apart(theta) @ theta)
        assert own <= apart * (1 + 1e-12)
        assert apart <= float(np.abs(theta) @ np.array(plays.gains(TS_S))) * (1 + 1e-12)
