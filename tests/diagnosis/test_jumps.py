"""Jumps below the misfit of the hysteresis, seen where it has none: between two samples."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import COMMAND_V, LAG, T_S, TS_S, named, scene
from hysgen.diagnosis import search
from hysgen.diagnosis.causes.unknown import CAUSE, SuddenPart
from hysgen.diagnosis.probe import refine
from hysgen.diagnosis.probe.chain import respond
from hysgen.diagnosis.score import LEAST_EVIDENCE

Floats = NDArray[np.float64]


@pytest.mark.slow
def test_jumps_below_the_misfit_are_evident_between_two_samples() -> None:
    """Up, up and down, on a misfit twice as large."""
    planted_s = (0.9, 2.0, 3.1)
    stairs_um = 0.06 * sum(sign * (t_s <= T_S) for sign, t_s in zip((1.0, 1.0, -1.0), planted_s, strict=True))
    bent_um = 0.2 * respond(np.sin(0.06 * np.pi * COMMAND_V), LAG, TS_S)

    def evidence(more_um: Floats, *times_s: float) -> float:
        seen = scene(LAG, more_um)
        return CAUSE.evidence(seen, refine(seen, LAG.having(SuddenPart(times_s))))

    assert evidence(bent_um + stairs_um, *planted_s) > 3.0 * LEAST_EVIDENCE
    assert evidence(bent_um + stairs_um, 1.4) == 0.0
    assert evidence(bent_um, *planted_s) == 0.0
    found = search.search(scene(LAG, bent_um + stairs_um))
    assert named(found) == ["unknown"]
    for at_s in found.fit.chain.of(SuddenPart).times_s:
        assert min(abs(at_s - true_s) for true_s in planted_s) < 2.0 * TS_S
    assert named(search.search(scene(LAG, bent_um))) == []
