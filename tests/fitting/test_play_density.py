"""The density of plays: curvature and sign from the weights, and their effect on a fit."""

from __future__ import annotations

import numpy as np
import pytest

from fixtures.bank_records import prepared_of
from hysgen.diagnosis.ladder import fit_ladder
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import rms
from hysgen.fitting import FitSettings
from hysgen.model.terms.memory import Memory
from hysgen.studies.bank.scenario import scenario
from hysgen.studies.bank.truth import true_extensions


def fall(prepared: Prepared, seed: int) -> float:
    """Held-out rms error without the memory extension over that with it."""
    extensions = true_extensions(scenario("memory", seed))
    held = [
        fit_ladder(prepared, extensions, names, FitSettings()).error_um[prepared.held_rows]
        for names in ([], ["memory"])
    ]
    return rms(held[0]) / rms(held[1])


def test_roughness_is_the_integral_of_the_curvature_squared_and_leaves_the_past_input_out() -> None:
    plays = Memory.polynomial(60, 2, -30.0, 50.0, past_input=True)
    rho = np.asarray(plays.thresholds_V)[1:] / 40.0
    width = np.diff(np.concatenate([[0.0], 0.5 * (rho[1:] + rho[:-1]), [1.0]]))

    def rough(play: np.ndarray, polynomial: np.ndarray, past: float) -> float:
        theta = np.concatenate([[past], play * width, [past], polynomial * width * 40.0 / 4.0])
        return float(np.sum((plays.roughness() @ theta) ** 2))

    # mu = sin(3 rho): the integral of 81 sin^2 over rho; 60 plays reach from 0.002 to 0.976.
    curved = 81.0 * (0.5 * 0.976 - np.sin(6.0 * 0.976) / 12.0)
    assert rough(np.sin(3.0 * rho), 0.0 * rho, 7.0) == pytest.approx(curved, rel=0.02)
    assert rough(0.0 * rho, np.sin(3.0 * rho), 7.0) == pytest.approx(curved, rel=0.02)
    assert rough(1.0 + 2.0 * rho, 3.0 - rho, 7.0) < 1e-9 * curved


@pytest.mark.slow
def test_the_memory_extension_lowers_the_held_out_error_at_least_seven_times() -> None:
    """On three drawn stages; the bank holds hundreds to the same limit."""
    assert min(fall(prepared_of("memory", seed), seed) for seed in range(3)) >= 7.0


def test_the_grid_reaches_where_the_command_leads_on_rows_that_are_held_out() -> None:
    """On at least seven of eight drawn stages, by the command alone, and by no more than 20 % of what is measured."""
    reached = []
    for seed in range(8):
        prepared = prepared_of("memory", seed)
        low, high = prepared.predicted_range_um
        held_um = prepared.y_um[prepared.held_rows]
        assert high - low < 1.2 * np.ptp(prepared.y_um)
        reached.append(low <= held_um.min() and held_um.max() <= high)
    assert sum(reached) >= 7
