"""Windows of a long record: bounded, at equal distances, and as good for a fit as all rows."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from hysgen.fitting import FitSettings, PathSize, fit, least_squares
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.studies.bank.excitation import good


def test_windows_hold_at_most_their_samples_and_reach_both_ends() -> None:
    found = least_squares.windows(600_000, 1_000_000)
    assert sum(at.stop - at.start for at in found) <= 0.6 * least_squares.MOST_SAMPLES
    assert (found[0].start, found[-1].stop) == (0, 600_000)
    assert all(before.stop <= after.start for before, after in itertools.pairwise(found))


def test_a_short_record_is_one_window() -> None:
    assert least_squares.windows(5000, least_squares.MOST_SAMPLES) == [slice(0, 5000)]


@pytest.mark.slow
def test_a_path_fitted_to_windows_is_as_good_as_one_fitted_to_all_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    u_V = good(np.random.default_rng(2), 60_000, 0.0, 100.0)
    stage = Stage.nominal().with_effects(creep=(0.02, 0.05, 1e4))
    record = Record.from_arrays(u_V, run(stage, u_V, 1e-3, seed=2).displacement_um, 1e-3)
    settings = FitSettings(memory=PathSize(plays=4, hats=4, states=2))
    levels = []
    for most in (100_000, 40_000):
        monkeypatch.setattr(least_squares, "MOST_SAMPLES", most)
        found = free_run(fit(record, settings), record)[0]
        levels.append(float(np.sqrt(np.mean((found.y_um - record.segments[0].y_um)[5000:] ** 2))))
    assert levels[1] < 1.1 * levels[0]
