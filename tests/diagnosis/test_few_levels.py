"""A stage that is stepped to a few levels and read a part of a sample after the voltage changed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

from hysgen.diagnosis.procedure import name_causes
from hysgen.record import Record

TS_S, HELD, FINE = 2.5e-4, 1000, 20
LEVELS_V = (0.0, 55.0, 95.0, 15.0, 75.0, 5.0, 65.0, 35.0)
F_HZ, ZETA = 380.0, 0.025


def stepped(early: int) -> Record:
    """Backlash of three widths, creep by 1.5 % in each of three decades, a mode, read early / FINE samples early."""
    levels, play = np.array(LEVELS_V), np.zeros((3, len(LEVELS_V)))
    for k in range(1, len(levels)):
        play[:, k] = np.clip(play[:, k - 1], levels[k] - (5.0, 12.0, 20.0), levels[k] + np.array((5.0, 12.0, 20.0)))
    still_um = np.repeat(0.06 * levels + np.array((0.01, 0.01, 0.02)) @ play, HELD * FINE)
    fine_s, crept_um = TS_S / FINE, still_um.copy()
    for tau_s in (0.008, 0.08, 0.8):
        slow = StateSpace([[-1.0 / tau_s]], [[1.0 / tau_s]], [[1.0]], [[0.0]])
        crept_um += 0.015 * lsim(slow, still_um, fine_s * np.arange(still_um.size), interp=False)[1]
    w = 2.0 * np.pi * F_HZ
    mode = StateSpace([[0.0, 1.0], [-w * w, -2.0 * ZETA * w]], [[0.0], [w * w]], [[1.0, 0.0]], [[0.0]])
    rung_um = lsim(mode, crept_um, fine_s * np.arange(crept_um.size), interp=False)[1]
    read_um = np.append(rung_um[early:], np.full(early, rung_um[-1]))[::FINE]
    noise_um = 1e-3 * np.random.default_rng(len(LEVELS_V)).normal(size=read_um.size)
    return Record.from_arrays(np.repeat(levels, HELD), read_um + noise_um, TS_S)


@pytest.mark.slow
def test_a_few_levels_show_the_mode_and_creep_and_memory_stays() -> None:
    """Each level is passed once: nothing shows that the gain changes, and that a curve bends there fits as well."""
    names = name_causes(stepped(4))
    assert sorted(names.names) == ["creep", "memory", "resonance"], names.names
    assert "resonance.f_2_Hz" not in names.estimates
    assert names.estimates["resonance.f_Hz"].value == pytest.approx(F_HZ, rel=1e-3)
