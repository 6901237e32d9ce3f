"""States in the loop of a mode are found where friction sits beside its spring, none where a linear mode answers."""

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.fitting.loop import identify_loop
from hysgen.fitting.structure import identify_structure

Floats = NDArray[np.float64]

TS_S, FINE = 1e-3, 20


def mass(u: Floats, yields_um: float) -> Floats:
    """(n,) q of q'' + 2 zeta w q' + w^2 q = w^2 u - friction of a spring that yields; Euler's semi-implicit steps.

    The friction is that of Jenkins' element, a spring of 0.6 w^2 in series with a slider of `yields_um`, which has a
    corner where the states of the model are smooth.
    """
    w, zeta, dt = 2.0 * np.pi * 30.0, 0.02, TS_S / FINE
    q, rate, stretch, y = u[0], 0.0, 0.0, np.empty(u.size)
    for k, force in enumerate(u):
        y[k] = q
        for _ in range(FINE):
            rate += dt * (w * w * (force - q - 0.6 * stretch) - 2.0 * zeta * w * rate)
            q += dt * rate
            stretch = min(max(stretch + dt * rate, -yields_um), yields_um)
    return y


@pytest.mark.parametrize("yields_um", [0.0, 0.5])
def test_states_are_added_while_they_lower_the_error_of_rows_left_out(yields_um: float) -> None:
    rng = np.random.default_rng(3)
    u = np.interp(np.arange(4000) / 12.0, np.arange(400), rng.normal(size=400))
    y = mass(u, yields_um)
    measured, fresh = y[:2500] + 0.02 * rng.normal(size=2500), slice(2600, 4000)
    form = identify_structure([u[None, :2500]], [measured], TS_S)
    found = identify_loop([u[:2500]], [measured], form, 100)
    print(
        [float(np.std((e.simulate(u[None]) - y)[fresh])) for e in (form, found) if e is not None],
        form.f_Hz,
        form.rms_um,
        found and found.loop,
    )
    if not yields_um:
        assert found is None
        return
    assert found is not None
    assert found.loop is not None
    left = [np.std((each.simulate(u[None]) - y)[fresh]) for each in (form, found)]
    assert left[1] < 0.25 * left[0]
