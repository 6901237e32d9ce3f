"""Each additive term against the physics of its effect."""

import numpy as np
import pytest

from hysgen.errors import ModelError
from hysgen.model.disturbances import Drive
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.drift import Drift

TS_S = 2e-5


def test_coupling_holds_the_last_finite_sample() -> None:
    mirror = Coupling(("t",), (20.0,), (24.0,)).mirror(1, TS_S)
    seen = []
    for value in (21.0, np.nan, np.inf, -np.inf, 23.0):
        mirror.listen({"t": np.array([value], dtype=np.float32)})
        seen.append(float(mirror.regressors()[0][0]))
        mirror.advance()
    assert seen == [-1.0, -1.0, -1.0, -1.0, 1.0]


def test_coupling_names_the_channel_that_a_record_lacks() -> None:
    with pytest.raises(ModelError, match="channel 't' is not in the record; it has x"):
        Coupling(("t",), (0.0,), (1.0,)).regressors(Drive(np.zeros(4), TS_S, {"x": np.zeros(4)}))


def test_drift_follows_a_step_of_the_error_with_its_time_constant_and_is_held_without_measurements() -> None:
    term, n = Drift(0.01, 0.5), 3000
    errors = np.where(np.arange(n) >= 100, 0.2, 0.0)
    bias = term.regressors(Drive(np.zeros(n), TS_S, innovation_um=errors))[:, 0]
    k = np.arange(n)
    assert np.abs(bias - np.where(k >= 100, 0.2 * -np.expm1(-(k - 99) * TS_S / 0.01), 0.0)).max() < 1e-12
    held = term.regressors(Drive(np.zeros(10), TS_S, start={"drift": bias[-1:]}))
    assert np.array_equal(held, np.full((10, 1), bias[-1]))


def test_drift_stays_within_its_limit_in_float32() -> None:
    mirror = Drift(1e-4, 0.25).mirror(2, TS_S)
    for _ in range(200):
        mirror.correct(np.array([1e3, -1e3], dtype=np.float32))
    assert [float(bias) for bias in mirror.regressors()[0]] == [0.25, -0.25]
    mirror.correct(np.array([-0.1, 0.1], dtype=np.float32))
    assert abs(float(mirror.regressors()[0][0])) < 0.25
