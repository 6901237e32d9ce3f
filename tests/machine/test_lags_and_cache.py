"""The kernels of first-order lags agree with each other, and the cache keeps its limits."""

from __future__ import annotations

import numpy as np
import pytest

from hysgen.machine.cache import LruCache
from hysgen.machine.kernels import lag_of_signals, lag_states, lag_sums

RATES = np.array([0.3, 0.02, 1e-4])


@pytest.mark.parametrize("signals", [1, 8, 11])
def test_lag_of_several_signals_has_the_bits_of_each_lag_alone(signals: int) -> None:
    u = np.random.default_rng(3).normal(size=(signals, 500))
    rows = np.array([0, 1, 7, 8, 300, 499])
    alone = np.stack([lag_states(one, RATES[:1], one[:1].copy())[rows, 0] for one in u])
    assert np.array_equal(lag_of_signals(u, float(RATES[0]), rows), alone)
    with pytest.raises(ValueError, match="rows must rise"):
        lag_of_signals(u, 0.3, np.array([2, 2]))
    with pytest.raises(ValueError, match="rows must rise"):
        lag_of_signals(u, 0.3, np.array([500]))


def test_sum_of_lags_is_the_sum_of_the_states() -> None:
    u, start = np.random.default_rng(4).normal(size=500), np.array([0.1, -0.2, 0.3])
    # Sums of three numbers in another order differ by 2 units of the last place of their magnitudes, at most 1.
    assert np.allclose(lag_sums(u, RATES, start), lag_states(u, RATES, start).sum(axis=1), rtol=0.0, atol=1e-15)


def test_cache_holds_more_than_its_capacity_only_within_its_bytes() -> None:
    computed: list[int] = []

    def asked(cache: LruCache[list[np.ndarray]], key: int) -> None:
        def compute() -> list[np.ndarray]:
            computed.append(key)
            return [np.zeros(10), np.zeros(10)]

        cache.get(key, compute)

    roomy: LruCache[list[np.ndarray]] = LruCache(2, 3 * 160)
    for key in (0, 1, 2, 0, 1, 2, 3, 0):
        asked(roomy, key)
    assert computed == [0, 1, 2, 3, 0]
    computed.clear()
    tight: LruCache[list[np.ndarray]] = LruCache(2, 100)
    for key in (0, 1, 0, 2, 1):
        asked(tight, key)
    assert computed == [0, 1, 2, 1]
