"""Modes that follow an amplitude: exact slopes, a foreign stage whose springs yield, a linear one, bounds."""

import functools

import numpy as np
import pytest

from fixtures.soft_springs import F_HZ, TS_S, Floats, record
from hysgen.fitting.softening import Numbers, identify_softening
from hysgen.fitting.structure import ModalForm, identify_structure
from hysgen.machine.kernels.operators import softening_slopes, softening_states
from hysgen.model.path.softening import ENDS, MOST
from hysgen.record import Record


def signals(known: Record) -> tuple[list[Floats], list[Floats]]:
    return [np.stack([s.u_V, s.aux["other"]]) for s in known.segments], [s.y_um for s in known.segments]


@functools.cache
def identified(yields_um: float) -> tuple[ModalForm, ModalForm | None]:
    inputs, y_um = signals(record((0.5, 1.0, 2.0), 3000, 1, yields_um))
    form = identify_structure(inputs, y_um, TS_S)
    return form, identify_softening(inputs, y_um, form, {"other": (-2.0, 2.0)})


@pytest.mark.slow
def test_springs_that_yield_leave_less_on_new_rows_and_twice_the_same() -> None:
    linear, form = identified(40.0)
    assert form is not None
    assert form.softening is not None
    for v, y in zip(*signals(record((0.7, 1.5), 3000, 2, 40.0)), strict=True):
        left_um, straight_um = (float(np.std((one.simulate(v) - y)[300:])) for one in (form, linear))
        assert left_um < 0.65 * straight_um, (left_um, straight_um)
    small_Hz = form.softening.natural(0.0)[0]
    assert all(np.abs(small_Hz / f_Hz - 1.0).min() < 2e-3 for f_Hz in F_HZ)
    assert max(float(np.abs(form.softening.poles(TS_S, s)).max()) for s in ENDS) < 1.0
    identified.cache_clear()
    again = identified(40.0)[1]
    assert again is not None
    assert again.softening == form.softening


@pytest.mark.slow
def test_a_linear_stage_of_two_drives_is_given_no_amplitude() -> None:
    linear, form = identified(np.inf)
    assert form is None
    np.testing.assert_allclose(np.sort(linear.f_Hz), F_HZ, rtol=1e-3)


def test_slopes_of_the_free_run_are_those_of_differences() -> None:
    rng = np.random.default_rng(0)
    numbers = 0.3 * rng.normal(size=(3, 14))
    numbers[:, 0], numbers[:, 1], numbers[:, 2:4] = [0.9, 0.7, 0.2], [0.3, 0.6, 0.9], 0.05 * numbers[:, 2:4]
    v = rng.normal(size=(500, 2))
    v[:2] = 0.0  # the state that a first sample is at rest under does not count
    states = softening_states(v, numbers, 0.05, MOST)
    slopes = softening_slopes(v, numbers, 0.05, states)
    for i in range(numbers.size):
        more = numbers.copy()
        more.flat[i] += 1e-6
        difference = (softening_states(v, more, 0.05, MOST)[1][:, 0] - states[1][:, 0]) / 1e-6
        assert np.abs(difference - slopes[:, i]).max() < 1e-4 * np.abs(difference).max(), i


def test_a_step_leaves_no_pole_outside_the_circle_at_any_amplitude() -> None:
    rng = np.random.default_rng(1)
    for scale in (0.01, 0.3, 10.0):
        moved = Numbers(np.zeros((40, 14)), 0.0, 0.05).moved(scale * rng.normal(size=40 * 14 + 1)).rows
        for s in np.linspace(*ENDS, 9):
            assert np.abs((moved[:, 0] + s * moved[:, 2]) + 1j * (moved[:, 1] + s * moved[:, 3])).max() < 1.0
