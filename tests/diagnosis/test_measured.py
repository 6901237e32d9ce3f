"""Measured records: what is named on them, and what it gains on rows that were not looked at."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hysgen.diagnosis import DiagnoseSettings, Diagnosis, diagnose
from hysgen.record import Record

pytestmark = pytest.mark.slow

FITTED_ROWS = 5000


@pytest.fixture(scope="module")
def ramps(measured: Path, once_per_run: Callable[[str, Callable[[], Any]], Any]) -> Diagnosis:
    rows = np.loadtxt(measured / "dbo" / "ramps.csv", delimiter=",", skiprows=1)
    record = Record.from_arrays(rows[:, 1], rows[:, 2], 0.005)
    settings = DiagnoseSettings(identify=FITTED_ROWS / record.samples)
    found = once_per_run("ramps", lambda: diagnose(record, settings=settings))
    assert isinstance(found, Diagnosis)
    return found


def test_memory_a_line_a_drift_and_a_falling_gain_are_named_on_the_micromanipulator(ramps: Diagnosis) -> None:
    """The gain: sudden changes at 2.5, 5, .. 22.5 s, fitted freely, add up to -0.5 %, all but one of them downwards."""
    assert ramps.names == ("memory", "periodic", "drift", "aging")
    aging = next(cause for cause in ramps.causes if cause.name == "aging")
    assert aging.parameters["per_s"].value < 0.0
    # It comes back after the pause, behind the identification part: there the gain is what it was last.
    without_um, with_um = aging.cold_um
    assert with_um < without_um
    assert ramps.held_rows.min() == FITTED_ROWS


def test_the_extensions_remove_most_of_the_error_on_the_micromanipulator(ramps: Diagnosis) -> None:
    # Issue 4: the paper's model leaves about 0.47 um there, the hold noise is 0.067 um.
    assert ramps.base_rms_um == pytest.approx(0.47, abs=0.02)
    assert ramps.noise.rms_um == pytest.approx(0.067, abs=0.01)
    # After the hold the loop of the stage itself differs by 0.05 um rms from the loops that were fitted.
    assert ramps.extended_rms_um < 0.112
