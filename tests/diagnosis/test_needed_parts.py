"""A part is in the chain only where the record needs it; the plants share no equation with chain or analysis."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from fixtures.linear_stage import COMMAND_V, LAG, SAMPLES, T_S, scene
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.probe import Mode, linear_fit, refine, rms
from hysgen.diagnosis.procedure import name_causes
from hysgen.diagnosis.score import Scored, admissible
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.path.modes import Modes
from hysgen.record import Record
from hysgen.record.series import plateaus

Floats = NDArray[np.float64]
ROWS = 6000


def moves_V(rng: np.random.Generator, rows: int, longest: int) -> Floats:
    """Raised cosines between random levels, of longest / 4 rows or more, with rests; the whole range first."""
    parts, at_V, levels = [np.zeros(150)], 0.0, [100.0, 0.0]
    while sum(map(len, parts)) < rows:
        to_V = levels.pop(0) if levels else float(rng.uniform(0.0, 100.0))
        share = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, int(rng.integers(longest // 4, longest))))
        parts += [at_V + (to_V - at_V) * share, np.full(int(rng.integers(10, 400)), to_V)]
        at_V = to_V
    return np.concatenate(parts)[:rows]


def rounded_branches(u_V: Floats) -> Floats:
    """(n,) share of the stroke: after every turn the slope is 0.7 and grows to 1 with exp(-distance / 0.4 ranges)."""
    v, h, turn = u_V / 100.0, np.zeros(len(u_V)), 0.0
    for k, step in enumerate(np.diff(v), 1):
        turn = v[k - 1] if step * (v[k - 1] - turn) < 0.0 else turn
        h[k] = h[k - 1] + step * (1.0 - 0.3 * np.exp(-abs(v[k] - turn) / 0.4))
    return h + 0.08 * h * h


def low_pass(x: Floats, rows: float) -> Floats:
    """(n,) mean of what came before, weighted exp(-age / rows)."""
    weights = np.diff(1.0 - np.exp(-np.arange(30.0 * rows) / rows))
    return x[0] + np.append(0.0, fftconvolve(x - x[0], weights)[: len(x) - 1])


def names(u_V: Floats, y: Floats, rng: np.random.Generator) -> set[str]:
    y_um = 20.0 * (y + 1e-4 * np.ptp(y) * rng.standard_normal(len(y)))
    return set(name_causes(Record.from_arrays(u_V, y_um, 5e-4)).names)


@pytest.mark.proof
def test_a_drift_is_named_beside_creep_of_a_stage_that_rested() -> None:
    """Every move goes on by 2 % of itself per decade: the sum over the moves of log10(1 + age / 10 rows).

    The drift rises by 1.2 % of the stroke. A motion before a record that begins at the lowest level leaves no rise.
    """
    u_V = moves_V(rng := np.random.default_rng(1), ROWS, 200)
    h = rounded_branches(u_V)
    crept = fftconvolve(np.diff(h, prepend=h[0]), 0.02 * np.log10(1.0 + np.arange(ROWS) / 10.0))[:ROWS]
    still = low_pass(h + crept, 3.0)
    assert names(u_V, still + 0.012 * np.arange(ROWS) / ROWS, rng) == {"memory", "creep", "drift"}
    assert names(u_V, still, rng) == {"memory", "creep"}


@pytest.mark.slow
def test_friction_is_unknown_and_no_hysteresis_of_another_form() -> None:
    """Half of the motion waits until the other half is 1 % of the stroke ahead."""
    u_V = moves_V(rng := np.random.default_rng(2), 8000, 1600)
    smooth = low_pass(rounded_branches(u_V), 3.0)
    stuck = smooth.copy()
    for k in range(1, len(u_V)):
        stuck[k] = smooth[k] if abs(smooth[k] - stuck[k - 1]) > 0.01 else stuck[k - 1]
    assert "unknown" in names(u_V, 0.5 * (smooth + stuck), rng)
    assert names(u_V, smooth, rng) == {"memory"}


def test_a_part_that_moves_what_rests_is_no_gain() -> None:
    """Residuals by hand: a misfit of 40 nm falls to 10 nm, and what was 1 nm of noise at rest moves by 40 nm."""
    seen, rng = scene(LAG), np.random.default_rng(3)
    moving_um = np.sin(0.1 * np.pi * COMMAND_V)
    noise_um = 1e-3 * rng.standard_normal(SAMPLES)
    wander_um = np.zeros(SAMPLES)
    for begin, end in plateaus(COMMAND_V):
        wander_um[begin:end] = np.linspace(0.02, -0.02, end - begin)

    def scored(error_um: Floats, *parts: CreepPart) -> Scored:
        fit = linear_fit(seen, dataclasses.replace(LAG, parts=parts))
        return Scored.of(seen, dataclasses.replace(fit, error=error_um, rms_um=rms(error_um[seen.rows])))

    before = scored(0.04 * moving_um + noise_um)
    creep = CreepPart(0.02, 0.05)
    assert scored(0.01 * moving_um + noise_um, creep).fall_from(before) > 10.0
    assert scored(0.01 * moving_um + noise_um + wander_um, creep).fall_from(before) < 0.0


def test_a_mode_that_nothing_drives_is_no_mode() -> None:
    """A line of 10 nm that fades as slowly as a light mode, and a mode that moves by 1 % of the motion."""
    mode = Modes.of([Mode(60.0, 1e-3, 1e-4)], 1.0)
    humming = scene(LAG, 0.01 * np.exp(-0.4 * T_S) * np.sin(2 * np.pi * 60.0 * T_S))
    ringing = scene(LAG.having(Modes.of([Mode(60.0, 0.02, 0.01)], 1.0)))
    assert not admissible(humming, refine(humming, LAG.having(mode)))
    assert admissible(ringing, refine(ringing, LAG.having(Modes.of([Mode(58.0, 0.03, 0.005)], 1.0))))


def test_a_line_on_a_harmonic_of_the_command_is_the_stages() -> None:
    """The command repeats after 500 rows, 2 Hz: 14 Hz is a harmonic, and 14.7 Hz none."""
    swing_V, plain = 50.0 - 50.0 * np.cos(2 * np.pi * 2.0 * T_S) ** 3, scene(LAG)
    repeated = dataclasses.replace(plain.bare(), runs=(dataclasses.replace(plain.runs[0], u_V=swing_V),))
    for line_Hz, holds in ((14.0, False), (14.7, True)):
        seen = linear_fit(repeated, LAG.having(Periodic((line_Hz,))))
        assert admissible(repeated, seen) == holds


@pytest.mark.slow
def test_one_step_shows_creep_and_no_memory() -> None:
    """Three Kelvin elements that creep by 1 % of a step each, of a command that never turns, at 2 nm of noise."""
    rng, Ts_s, rows, step = np.random.default_rng(8), 5e-3, np.arange(4000), 300
    u_V, since_s = np.where(rows < step, 20.0, 80.0), Ts_s * (rows - step - 1)
    moved = sum(0.01 * -np.expm1(-since_s.clip(0.0) / tau_s) for tau_s in (0.1, 1.0, 10.0))
    y_um = 1.0 + 3.0 * (since_s >= 0.0) * (1.0 + moved) + 2e-3 * rng.standard_normal(len(rows))
    naming = name_causes(Record.from_arrays(u_V, y_um, Ts_s))
    assert naming.names == ("creep",)
    assert naming.estimates["creep.per_decade"].value == pytest.approx(0.01, rel=0.2)
